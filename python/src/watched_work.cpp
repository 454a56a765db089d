// SPDX-License-Identifier: Apache-2.0
#include "watched_work.h"

#include "device_use.h"
#include "thread_limit.h"

#include "vdbtools/base/memory.h"
#include "vdbtools/base/scheduler.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace py = pybind11;

namespace {

/// The interval at which the calling thread checks for signals and reports the progress.
constexpr std::chrono::milliseconds kTick(50);
/// The number of such intervals between two checks of the memory.
constexpr int kTicksOfMemory = 4;

struct PhaseNews {
  std::string phase;
  std::optional<double> share;
};

class WatchedMonitor final : public vdbtools::Monitor {
 public:
  void begin(const vdbtools::Phase& phase, std::uint64_t total) override {
    const std::scoped_lock lock(mMutex);
    mDone = 0;
    mTotal = total;
    mBegun.push_back(phase.text());
  }
  void advance(std::uint64_t steps) override { mDone += steps; }
  bool cancelled() const override { return mCancelled; }
  void cancel() { mCancelled = true; }

  /// The phases that began since the last call, and how much of the last one is done.
  std::vector<PhaseNews> news() {
    const std::scoped_lock lock(mMutex);
    std::vector<PhaseNews> news;
    for (std::string& phase : mBegun) news.push_back({mPhase = std::move(phase), {}});
    mBegun.clear();
    if (mTotal > 0 && !mPhase.empty()) {
      const double share = std::min(1.0, static_cast<double>(mDone) / static_cast<double>(mTotal));
      if (news.empty() && share == mTold) return news;
      if (news.empty()) news.push_back({mPhase, {}});
      mTold = share;
      news.back().share = share;
    }
    return news;
  }

 private:
  std::mutex mMutex;  // guards the phases; steps are counted without it
  std::vector<std::string> mBegun;
  std::string mPhase;
  std::uint64_t mTotal = 0;
  double mTold = 0;
  std::atomic<std::uint64_t> mDone{0};
  std::atomic<bool> mCancelled{false};
};

/// @throw pybind11::error_already_set
void tell(const py::object& progress, WatchedMonitor& monitor) {
  if (progress.is_none()) return;
  for (const PhaseNews& news : monitor.news()) {
    const py::object share = news.share ? py::object(py::float_(*news.share)) : py::object(py::none());
    if (progress(news.phase, share).ptr() == Py_False) monitor.cancel();
  }
}

}  // namespace

void doWatched(const py::object& progress, const Resources& resources,
               const std::function<void(vdbtools::Monitor&)>& work) {
  std::optional<vdbtools::MemoryLimit> limit;
  if (resources.memory) limit.emplace(*resources.memory);
  WatchedMonitor monitor;
  std::exception_ptr failure, stopped;
  std::mutex mutex;
  std::condition_variable ended;
  bool over = false;
  std::thread worker([&] {
    try {
      vdbtools::startScheduler();
      inThreads(resources.threads, [&] {
        if (resources.device.empty()) return work(monitor);
        onDevice(resources.device, monitor, [&] { work(monitor); });
      });
    } catch (...) {
      failure = std::current_exception();
    }
    const std::scoped_lock lock(mutex);
    over = true;
    ended.notify_one();
  });
  // The worker must end before this function does in any case, because it uses local variables.
  int tick = 0;
  for (bool last = false; !last; ++tick) {
    {
      const py::gil_scoped_release release;
      std::unique_lock lock(mutex);
      last = ended.wait_for(lock, kTick, [&] { return over; });
    }
    if (stopped) continue;
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      tell(progress, monitor);
      if (tick % kTicksOfMemory == 0)
        if (const std::optional<std::string> why = vdbtools::memoryRunsOut())
          throw vdbtools::MemoryError(*why, vdbtools::MemoryUse::Field);
    } catch (...) {
      stopped = std::current_exception();
      monitor.cancel();
    }
  }
  {
    const py::gil_scoped_release release;
    worker.join();
  }
  if (stopped) std::rethrow_exception(stopped);
  if (failure) std::rethrow_exception(failure);
  // Short work may end before it notices that it was cancelled.
  monitor.throwIfCancelled();
}
