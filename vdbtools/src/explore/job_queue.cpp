// SPDX-License-Identifier: Apache-2.0
#include "explore/job_queue.h"

#include "explore/failure_answer.h"
#include "explore/file_access.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/base/text.h"
#include "vdbtools/files/output_files.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/scene/voxel_advice.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <stdexcept>

namespace vdbtools::explore {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostWaiting = 50, kMostKnown = 100;

/// Where addresses end soon, as in WebAssembly, refuses files that will not fit, by an estimate: no swap space helps
/// there, and the program could end in the middle.
void requireThatItFits(const Scene& scene) {
  constexpr double kAdvised = 0.75;  // what this attempt has taken may not all be given back
  const MemoryLeft left = addressSpaceLeft();
  const double bytes = left.bytes + residentMemory();
  if (!fittingResolution(scene, bytes)) return;
  const std::optional<double> fits = fittingResolution(scene, kAdvised * bytes);
  throw MemoryError("these voxels would take more memory than the " + memoryText(left.bytes) + " that " + left.limit +
                        " leaves" + (*fits > 0 ? "; --resolution " + shortText(*fits) + " fits" : ""),
                    MemoryUse::Field);
}

}  // namespace

/// A job, and the monitor of its work.
class JobQueue::Job final : public Monitor {
 public:
  Job(int number, const JobRequest& request, std::unique_ptr<WorkShare> share)
      : mStatus{.number = number, .request = request}, mShare(std::move(share)) {}

  void begin(const Phase& phase, std::uint64_t total) override {
    throwIfCancelled();
    const std::lock_guard lock(mMutex);
    mStatus.phase = phase.text();
    mTotal = total;
    mDone = 0;
    if (mShare) mShare->begin(phase);
  }
  void advance(std::uint64_t steps) override { mDone.fetch_add(steps, std::memory_order_relaxed); }
  bool cancelled() const override { return mCancelled.load(std::memory_order_relaxed); }

  const JobRequest& request() const { return mStatus.request; }
  void cancel() { mCancelled = true; }

  void setState(JobState state) {
    const std::lock_guard lock(mMutex);
    mStatus.state = state;
    if (state == JobState::Running) mStart = Clock::now();
  }
  void fail(const std::string& error) {
    const std::lock_guard lock(mMutex);
    mStatus.state = JobState::Failed;
    mStatus.error = error;
  }
  void finish(std::vector<std::string> files, std::vector<std::string> warnings) {
    const std::lock_guard lock(mMutex);
    mStatus.state = JobState::Done;
    mStatus.files = std::move(files);
    mStatus.warnings = std::move(warnings);
  }
  JobState state() const {
    const std::lock_guard lock(mMutex);
    return mStatus.state;
  }
  bool waits() const { return state() == JobState::Queued; }
  bool isOver() const {
    const JobState at = state();
    return at != JobState::Queued && at != JobState::Running;
  }

  JobStatus status() const {
    const std::lock_guard lock(mMutex);
    JobStatus status = mStatus;
    if (status.state == JobState::Done) status.share = 1;
    if (status.state != JobState::Running || !mShare) return status;
    const double fraction = mTotal ? std::min(1.0, static_cast<double>(mDone.load()) / static_cast<double>(mTotal)) : 0;
    status.share = mShare->at(fraction);
    constexpr double kKnown = 0.01;  // the share from which the remaining time is reported
    const double seconds = std::chrono::duration<double>(Clock::now() - mStart).count();
    if (status.share > kKnown) status.left = seconds * (1 - status.share) / status.share;
    return status;
  }

 private:
  mutable std::mutex mMutex;  // guards everything below except the two atomic numbers
  JobStatus mStatus;
  std::unique_ptr<WorkShare> mShare;
  std::uint64_t mTotal = 0;
  Clock::time_point mStart{};
  std::atomic<std::uint64_t> mDone{0};
  std::atomic<bool> mCancelled{false};
};

JobQueue::JobQueue(std::filesystem::path folder, InputFiles inputs, MakeShare makeShare)
    : mFolder(std::move(folder)),
      mInputs(std::move(inputs)),
      mMakeShare(std::move(makeShare)),
      mThread([this] { work(); }) {}

JobQueue::~JobQueue() {
  stop();
  mThread.join();
}

void JobQueue::stop() {
  const std::lock_guard lock(mMutex);
  mStopped = true;
  for (const auto& job : mJobs) job->cancel();
  mWake.notify_all();
}

std::filesystem::path JobQueue::fileOf(const JobRequest& request, const std::string& format) const {
  return mFolder / (request.name + '.' + format);
}

void JobQueue::requireFree(const JobRequest& request) const {
  for (const std::string& format : request.formats) {
    const std::filesystem::path path = fileOf(request, format);
    mInputs.requireNot(path);
    std::error_code ignored;
    const auto status = std::filesystem::symlink_status(path, ignored);
    if (!std::filesystem::exists(status)) continue;
    const std::string name = path.filename().string();
    if (!std::filesystem::is_regular_file(status))
      throw std::invalid_argument("'" + name + "' is there and is no ordinary file; choose another name");
    if (!request.overwrite)
      throw std::invalid_argument("'" + name + "' is there already; choose another name, or allow it to be replaced");
  }
}

int JobQueue::add(const JobRequest& request) {
  requireFileName(request.name);
  const std::vector<std::string> known = writtenFormats();
  if (request.formats.empty()) throw std::invalid_argument("no format was given for the files");
  for (const std::string& format : request.formats) {
    if (std::find(known.begin(), known.end(), format) == known.end())
      throw std::invalid_argument("there is no format '" + format + "' for files");
    if (std::count(request.formats.begin(), request.formats.end(), format) > 1)
      throw std::invalid_argument("the format '" + format + "' was given twice");
  }
  requireFree(request);
  const std::lock_guard lock(mMutex);
  const auto waiting = std::count_if(mJobs.begin(), mJobs.end(), [](const auto& job) { return !job->isOver(); });
  if (static_cast<std::size_t>(waiting) >= kMostWaiting)
    throw std::invalid_argument(std::to_string(waiting) + " jobs wait already; let some of them end first");
  for (const auto& job : mJobs)
    if (!job->isOver() && job->request().name == request.name)
      throw std::invalid_argument("a job with the name '" + request.name + "' waits already; choose another name");
  mJobs.push_back(std::make_shared<Job>(++mLast, request, mMakeShare ? mMakeShare() : nullptr));
  for (auto job = mJobs.begin(); mJobs.size() > kMostKnown && job != mJobs.end();)
    job = (*job)->isOver() ? mJobs.erase(job) : job + 1;
  mWake.notify_all();
  return mLast;
}

std::vector<JobStatus> JobQueue::list() const {
  const std::lock_guard lock(mMutex);
  std::vector<JobStatus> jobs;
  for (const auto& job : mJobs) jobs.push_back(job->status());
  return jobs;
}

std::optional<MadeFiles> JobQueue::madeFiles(int number) const {
  for (const JobStatus& status : list()) {
    if (status.number != number || status.state != JobState::Done) continue;
    MadeFiles made{.recipe = status.request.recipe, .files = {}};
    for (const std::string& format : status.request.formats) made.files.push_back(fileOf(status.request, format));
    return made;
  }
  return std::nullopt;
}

bool JobQueue::cancel(int number) {
  const std::lock_guard lock(mMutex);
  for (const auto& job : mJobs) {
    if (job->status().number != number) continue;
    job->cancel();
    if (job->waits()) job->setState(JobState::Cancelled);
    return true;
  }
  return false;
}

void JobQueue::work() {
  // The page's own requests have priority over files.
  tbb::task_arena arena(tbb::task_arena::automatic, 1, tbb::task_arena::priority::low);
  std::unique_lock lock(mMutex);
  for (;;) {
    const auto next = std::find_if(mJobs.begin(), mJobs.end(), [](const auto& job) { return job->waits(); });
    if (mStopped) return;
    if (next == mJobs.end()) {
      mWake.wait(lock);
      continue;
    }
    const std::shared_ptr<Job> job = *next;
    job->setState(JobState::Running);
    lock.unlock();
    arena.execute([&] { run(*job); });
    lock.lock();
  }
}

void JobQueue::run(Job& job) {
  try {
    const JobRequest& request = job.request();
    const FractalOptions options = parseFractalOptions(request.recipe);
    requireFree(request);
    OutputFiles files(mInputs);
    std::vector<std::string> names;
    FractalFiles outputs;
    for (const std::string& format : request.formats) {
      const std::filesystem::path path = fileOf(request, format);
      outputs.files.push_back({&files.add(path), findFormat(path.native())});
      names.push_back(path.filename().string());
    }
    const Scene scene = makeScene(options, job);
    requireThatItFits(scene);
    const FractalResult result = writeFractal(scene, request.recipe, outputs, job);
    job.throwIfCancelled();
    requireFree(request);
    files.commit();
    job.finish(std::move(names), textsOf(result.clamped));
  } catch (const Interrupted&) {
    job.setState(JobState::Cancelled);
  } catch (...) {
    job.fail(currentFailureAnswer().text);
  }
}

}  // namespace vdbtools::explore
