// SPDX-License-Identifier: Apache-2.0
/// @file sequence.h
/// Sequences that one process makes, frame by frame: which frames are kept, what a failure stops, and what is said.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/farm/frame_recipes.h"

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>

namespace cli {

class CommandLine;

/// --frames, --key, --ease, --force and --keep-going.
void addSequenceOptions(CommandLine& line);
/// @throw std::invalid_argument  an option that makes sense with --frames only, or --frame and --frames
void requireSequenceFits(const CommandLine& line);

/// What one fractal is made with.
struct FractalRun {
  vdbtools::Recipe recipe;  ///< to be recorded
  vdbtools::Recipe found;   ///< the same with the names under which files are opened
  std::optional<int> frame;
  bool isLast = true;  ///< nothing is to be made after it
};

struct SequenceCounts {
  std::size_t frames = 0, kept = 0;
  std::size_t failed = 0;
  std::string firstFailure;  ///< with the frame; empty if none failed
  int failureCode = 0;
};

using FrameMaker = std::function<void(const FractalRun&, vdbtools::Monitor&)>;

/// Makes the frames in their order, except those whose files are there and hold the frame's recipe. Names the frame in
/// a failure, which ends the sequence, or with --keep-going that frame alone.
/// @param outputs  the options that name the files of a frame
/// @throw FailedWith, vdbtools::Interrupted
SequenceCounts makeSequence(const CommandLine& line, const vdbtools::farm::FrameRecipes& recipes,
                            std::span<const char* const> outputs, const FrameMaker& make);

/// Says what has become of the frames. @return the exit code @throw FailedWith  some have failed
int finishSequence(const SequenceCounts& counts);

}  // namespace cli
