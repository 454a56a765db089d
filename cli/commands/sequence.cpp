// SPDX-License-Identifier: Apache-2.0
#include "sequence.h"

#include "exit_code.h"
#include "failure.h"
#include "options.h"
#include "output.h"
#include "plan.h"
#include "report.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/frames.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/mesh_files/mesh_reader.h"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <stdexcept>
#include <utility>

namespace cli {
namespace {

/// Whether all files of a frame record its recipe.
bool isMade(const CommandLine& line, const FractalRun& run, std::span<const char* const> outputs) {
  return std::all_of(outputs.begin(), outputs.end(), [&](const char* option) {
    return !line.has(option) || vdbtools::holdsFractal(vdbtools::expandFrame(line.text(option), run.frame), run.recipe);
  });
}

std::string framesText(std::size_t count) { return std::to_string(count) + (count == 1 ? " frame" : " frames"); }

/// The failure that is being handled, with the number of its frame.
Failure failureOf(int frame) {
  Failure failure = currentFailure();
  failure.text = "frame " + std::to_string(frame) + ": " + failure.text;
  return failure;
}

/// Reads a mesh, or what the head of a VDB says, and forgets it. @throw as readMesh(), readVdbMetadata()
void requireReadable(const std::string& input) {
  if (vdbtools::isVdbPath(input))
    vdbtools::readVdbMetadata(input);
  else if (vdbtools::formatOfMesh(input))
    vdbtools::readMesh(input);
}

/// Refuses outputs that would have the same name in several frames.
void requirePlaces(const CommandLine& line, std::span<const char* const> outputs, std::size_t frames) {
  if (frames < 2) return;
  for (const char* option : outputs) {
    if (!line.has(option) || isStandardOutput(line.text(option)) || vdbtools::hasFramePattern(line.text(option)))
      continue;
    std::filesystem::path better = line.text(option);
    better.replace_extension(".####" + better.extension().string());
    throw std::invalid_argument("--" + std::string(option) + " is '" + line.text(option) +
                                "', which has no place for " + "the number of a frame, and --frames " +
                                line.text("frames") + " has " + framesText(frames) + "; write a name such as " +
                                better.string());
  }
}

std::string copyText(int from) { return ": the same as frame " + std::to_string(from) + '\n'; }

}  // namespace

void addFramesOption(CommandLine& line) {
  line.addOptions({{.name = "frames", .argument = "LIST", .help = kFramesHelp},
                   {.name = "keep-going",
                    .help = "with --frames: make the other frames where one has failed, and fail at the end"}});
}

void addSequenceOptions(CommandLine& line) {
  addFramesOption(line);
  addKeyOptions(line);
  line.addOptions()("force", "with --frames: make all frames, also those that are there with the same recipe");
}

void requireSequenceFits(const CommandLine& line) {
  if (line.has("frames")) {
    if (line.has("frame"))
      throw std::invalid_argument("--frame and --frames exclude each other; --frames 7 makes frame 7 alone");
    return;
  }
  for (const char* name : {"key", "ease", "force", "keep-going"})
    if (line.has(name)) throw std::invalid_argument("--" + std::string(name) + " can be used with --frames only");
}

std::vector<int> framesOf(const CommandLine& line, std::span<const char* const> outputs) {
  requireSequenceFits(line);
  if (!line.has("frames")) return {};
  std::vector<int> frames = vdbtools::farm::parseFrames(line.text("frames"));
  requirePlaces(line, outputs, frames.size());
  return frames;
}

void noteEqualFrames(std::size_t frames) {
  if (frames > 1) report().text() << "note: nothing changes from frame to frame, and all are the same\n";
}

void checkFrames(const CommandLine& line, const std::vector<int>& frames, const std::function<void(int frame)>& check) {
  for (const int frame : frames) {
    line.progress().throwIfCancelled();
    try {
      check(frame);
    } catch (const vdbtools::Interrupted&) {
      throw;
    } catch (...) {
      if (!line.has("keep-going")) throw FailedWith(failureOf(frame));
    }
  }
}

SequenceCounts makeSequence(const CommandLine& line, const std::vector<int>& frames, const FrameMaker& make) {
  SequenceCounts counts{.frames = frames.size()};
  for (std::size_t i = 0; i < frames.size(); ++i) {
    vdbtools::NumberedMonitor monitor(line.progress(), "frame", i + 1, frames.size());
    try {
      if (make(i, i + 1 == frames.size() && counts.failed == 0, monitor) == FrameOutcome::Kept) ++counts.keptFrames;
    } catch (const vdbtools::Interrupted&) {
      throw;
    } catch (...) {
      const Failure failure = failureOf(frames[i]);
      if (!line.has("keep-going") || failure.code == kInterrupted)
        throw FailedWith({failure.code, i == 0 ? failure.text : failure.text + "; the frames before it are finished"});
      report().text() << "warning: " << failure.text << '\n';
      if (counts.failed++ == 0) {
        counts.firstFailure = failure.text;
        counts.failureCode = failure.code;
      }
    }
  }
  return counts;
}

int finishSequence(const SequenceCounts& counts, bool keeps) {
  const std::size_t made = counts.frames - counts.keptFrames - counts.failed;
  report().count("frames", counts.frames);
  if (keeps) report().count("keptFrames", counts.keptFrames);
  report().count("failedFrames", counts.failed);
  report().text() << "made " << framesText(made);
  if (keeps)
    report().text() << ", kept " << counts.keptFrames << " of " << framesText(counts.frames);
  else if (made < counts.frames)
    report().text() << " of " << counts.frames;
  report().text() << '\n';
  if (counts.failed == 0) return kDone;
  const std::string others = counts.failed == 1 ? "" : "; " + std::to_string(counts.failed - 1) + " more failed";
  throw FailedWith({counts.failureCode, counts.firstFailure + others});
}

bool copyFrame(const CommandLine& line, std::span<const char* const> outputs, int from, int to, bool isLast) {
  const auto nameAt = [&](const char* option, int frame) { return vdbtools::expandFrame(line.text(option), frame); };
  std::vector<const char*> given;
  std::copy_if(outputs.begin(), outputs.end(), std::back_inserter(given),
               [&](const char* option) { return line.has(option); });
  std::error_code error;
  for (const char* option : given)
    if (!std::filesystem::is_regular_file(nameAt(option, from), error)) return false;
  Outputs files(line, {}, to);
  for (const char* option : given) {
    const std::string source = nameAt(option, from);
    std::ifstream content(source, std::ios::binary);
    // If this fails, the commit reports it.
    files.add(option, line.text(option), vdbtools::lowerExtension(source)).stream() << content.rdbuf();
    if (!content.is_open() || content.bad()) throw vdbtools::IoError("'" + source + "' cannot be read to copy it");
  }
  files.commit(isLast);
  report().text() << "wrote " << files.names() << copyText(from);
  return true;
}

SequenceCounts makeFractals(const CommandLine& line, const vdbtools::farm::FrameRecipes& recipes,
                            std::span<const char* const> outputs, const FractalMaker& make) {
  const std::vector<int>& frames = recipes.frames();
  std::optional<std::pair<vdbtools::Recipe, int>> before;  // the previous frame
  bool areEqual = true;
  const SequenceCounts counts = makeSequence(line, frames, [&](std::size_t i, bool isLast, vdbtools::Monitor& monitor) {
    monitor.begin(vdbtools::PhaseKind::Checking, 0);
    monitor.throwIfCancelled();
    const vdbtools::Recipe recipe = recipes.at(frames[i]);
    const FractalRun run{recipe, recipe, frames[i], isLast};
    const bool isEqual = before && before->first == recipe;
    areEqual = areEqual && (isEqual || i == 0);
    const bool isThere = !line.has("force") && isMade(line, run, outputs);
    if (!isThere && !(isEqual && copyFrame(line, outputs, before->second, frames[i], isLast))) make(run, monitor);
    before = {recipe, frames[i]};
    report().noteKept("finished frames are kept, and the same command goes on from there");
    return isThere ? FrameOutcome::Kept : FrameOutcome::Made;
  });
  if (areEqual) noteEqualFrames(frames.size());
  return counts;
}

int runFrames(const CommandLine& line, const std::string& input, std::span<const char* const> outputs,
              const FramePreparer& prepare) {
  const std::vector<int> frames = framesOf(line, outputs);
  if (frames.empty()) {
    const FrameJob job = prepare(input);
    Outputs files(line, job.inputs, parseFrame(line.text("frame")));
    job.make({files, line.progress(), true});
    return kDone;
  }
  const bool isSequence = vdbtools::hasFramePattern(input);
  const auto inputOf = [&](int frame) { return isSequence ? vdbtools::expandFrame(input, frame) : input; };
  vdbtools::FrameInputs there;
  for (const int frame : frames)
    if (!input.empty()) there.add(inputOf(frame), frame);
  if (!line.has("keep-going")) there.requireNoneMissing();
  vdbtools::InputFiles inputs = there.files();
  std::vector<FrameJob> jobs;  // one for all frames if they are the same
  checkFrames(line, isSequence ? frames : std::vector<int>{frames.front()}, [&](int frame) {
    FrameJob& job = jobs.emplace_back();
    try {
      if (!input.empty()) requireReadable(inputOf(frame));
      job = prepare(inputOf(frame));
    } catch (...) {
      job.make = [failure = std::current_exception()](const FrameRun&) { std::rethrow_exception(failure); };
      throw;
    }
    if (!input.empty()) job.inputs.add(inputOf(frame));
    inputs.add(job.inputs);
  });
  requireFramePlaces(line, inputs, outputs, frames);
  std::optional<int> before;
  const SequenceCounts counts = makeSequence(line, frames, [&](std::size_t i, bool isLast, vdbtools::Monitor& monitor) {
    monitor.throwIfCancelled();
    if (isSequence || !before || !copyFrame(line, outputs, *before, frames[i], isLast)) {
      const FrameJob& job = jobs[isSequence ? i : 0];
      Outputs files(line, job.inputs, frames[i]);
      job.make({files, monitor, isLast});
      before = frames[i];
    }
    report().noteKept("finished frames are kept");
    return FrameOutcome::Made;
  });
  if (!isSequence) noteEqualFrames(frames.size());
  return finishSequence(counts, /*keeps=*/false);
}

}  // namespace cli
