// SPDX-License-Identifier: Apache-2.0
#include "sequence.h"

#include "exit_code.h"
#include "failure.h"
#include "options.h"
#include "plan.h"
#include "report.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/numbered_monitor.h"
#include "vdbtools/files/frame_name.h"
#include "vdbtools/job/made_fractal.h"

#include <algorithm>
#include <ostream>
#include <stdexcept>

namespace po = boost::program_options;

namespace cli {
namespace {

/// Whether all files of a frame hold its recipe.
bool isMade(const CommandLine& line, const FractalRun& run, std::span<const char* const> outputs) {
  return std::all_of(outputs.begin(), outputs.end(), [&](const char* option) {
    return !line.has(option) || vdbtools::holdsFractal(vdbtools::expandFrame(line.text(option), run.frame), run.recipe);
  });
}

std::string framesText(std::size_t count) { return std::to_string(count) + (count == 1 ? " frame" : " frames"); }

}  // namespace

void addSequenceOptions(CommandLine& line) {
  addFrameOptions(line);
  line.addOptions()("force", "with --frames: make all frames, also those that are there with the same recipe")(
      "keep-going", "with --frames: make the other frames where one has failed, and fail at the end");
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

SequenceCounts makeSequence(const CommandLine& line, const vdbtools::farm::FrameRecipes& recipes,
                            std::span<const char* const> outputs, const FrameMaker& make) {
  const std::vector<int>& frames = recipes.frames();
  SequenceCounts counts{.frames = frames.size()};
  for (std::size_t i = 0; i < frames.size(); ++i) {
    vdbtools::NumberedMonitor monitor(line.progress(), "frame", i + 1, frames.size());
    try {
      monitor.begin(vdbtools::PhaseKind::Checking, 0);
      monitor.throwIfCancelled();
      const vdbtools::Recipe recipe = recipes.at(frames[i]);
      const FractalRun run{recipe, recipe, frames[i], i + 1 == frames.size() && counts.failed == 0};
      if (!line.has("force") && isMade(line, run, outputs))
        ++counts.kept;
      else
        make(run, monitor);
      report().noteKept("finished frames are kept, and the same command goes on from there");
    } catch (const vdbtools::Interrupted&) {
      throw;
    } catch (...) {
      const Failure failure = currentFailure();
      const std::string text = "frame " + std::to_string(frames[i]) + ": " + failure.text;
      if (!line.has("keep-going") || failure.code == kInterrupted)
        throw FailedWith({failure.code, i == 0 ? text : text + "; the frames before it are finished"});
      report().text() << "warning: " << text << '\n';
      if (counts.failed++ == 0) {
        counts.firstFailure = text;
        counts.failureCode = failure.code;
      }
    }
  }
  return counts;
}

int finishSequence(const SequenceCounts& counts) {
  const std::size_t made = counts.frames - counts.kept - counts.failed;
  report().count("frames", counts.frames);
  report().count("keptFrames", counts.kept);
  report().count("failedFrames", counts.failed);
  report().text() << "made " << framesText(made) << ", kept " << counts.kept << " of " << framesText(counts.frames)
                  << '\n';
  if (counts.failed == 0) return kDone;
  const std::string others = counts.failed == 1 ? "" : "; " + std::to_string(counts.failed - 1) + " more failed";
  throw FailedWith({counts.failureCode, counts.firstFailure + others});
}

}  // namespace cli
