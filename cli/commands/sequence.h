// SPDX-License-Identifier: Apache-2.0
/// @file sequence.h
/// Sequences that one process makes, frame by frame: --frames of every command that has it, what is checked before the
/// first frame, which frames are kept, what a failure stops, and what is said.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/farm/frame_recipes.h"
#include "vdbtools/files/input_files.h"

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace cli {

class CommandLine;
class Outputs;

/// The help on --frames, after what each frame is.
inline constexpr const char* kFramesHelp =
    "a sequence: a list of numbers and ranges such as 7, 1-48, -5-5, or 1-48x2 for every second one. Names such as "
    "in.####.obj and out.$F4.vdb have a place for the frame, and outputs need one; what has none is the same in all "
    "frames";

/// The options that name the files of a frame, for commands with one output.
inline constexpr const char* kOnlyOutput[] = {"output"};

/// --frames and --keep-going.
void addFramesOption(CommandLine& line);
/// These, and --key, --ease and --force of 'fractal'.
void addSequenceOptions(CommandLine& line);
/// @throw std::invalid_argument  an option that makes sense with --frames only, or --frame and --frames
void requireSequenceFits(const CommandLine& line);

/// The frames that were asked for; none without --frames.
/// @param outputs  the options that name the files of a frame
/// @throw std::invalid_argument  --frames is no such list, an option goes with --frames only, or an output has no place
///                               for the frame although there are several
std::vector<int> framesOf(const CommandLine& line, std::span<const char* const> outputs);

/// Says that all frames are the same, if there are several.
void noteHeld(std::size_t frames);

struct SequenceCounts {
  std::size_t frames = 0, kept = 0;
  std::size_t failed = 0;
  std::string firstFailure;  ///< with the frame; empty if none failed
  int failureCode = 0;
};

/// What becomes of a frame.
enum class FrameOutcome { Made, Kept };
/// @param isLast  nothing is to be made after it
using FrameMaker = std::function<FrameOutcome(std::size_t index, bool isLast, vdbtools::Monitor& monitor)>;

/// Makes frames in their order. Names the frame in a failure, which ends the sequence, or with --keep-going that frame
/// alone.
/// @throw FailedWith, vdbtools::Interrupted
SequenceCounts makeSequence(const CommandLine& line, const std::vector<int>& frames, const FrameMaker& make);

/// Says what has become of the frames. @param keeps  whether frames that are there may be kept
/// @return the exit code @throw FailedWith  some have failed
int finishSequence(const SequenceCounts& counts, bool keeps);

/// Writes the files of one frame under the names of another, and says so.
/// @param outputs  the options that name the files of a frame
/// @return false: they are no files that can be copied, and nothing was written
bool copyFrame(const CommandLine& line, std::span<const char* const> outputs, int from, int to, bool isLast);

// ---- What one fractal of a sequence is made with -------------------------------------------------------------------

struct FractalRun {
  vdbtools::Recipe recipe;  ///< to be recorded
  vdbtools::Recipe found;   ///< the same with the names under which files are opened
  std::optional<int> frame;
  bool isLast = true;  ///< nothing is to be made after it
};

using FractalMaker = std::function<void(const FractalRun&, vdbtools::Monitor&)>;

/// Makes the fractals of frames, except those whose files are there and hold the frame's recipe, and those whose recipe
/// is that of the frame before, whose files are copied.
/// @throw as makeSequence()
SequenceCounts makeFractals(const CommandLine& line, const vdbtools::farm::FrameRecipes& recipes,
                            std::span<const char* const> outputs, const FractalMaker& make);

// ---- Commands that make files from one input -----------------------------------------------------------------------

/// A frame that is being made, or what a command makes without --frames.
struct FrameRun {
  Outputs& outputs;
  vdbtools::Monitor& monitor;
  bool isLast;  ///< for Outputs::commit()
};

/// What a command makes from an input.
struct FrameJob {
  vdbtools::InputFiles inputs{};  ///< what is read in addition to CommandLine::inputs()
  /// Claims the outputs, makes and commits them, and says so.
  std::function<void(const FrameRun&)> make{};
};

/// Checks everything about an input, and reads nothing but the recipe in it.
using FramePreparer = std::function<FrameJob(const std::string& input)>;

/// Makes what a command makes: from its input, or with --frames from that of each frame. All frames are prepared, all
/// their inputs exist, and no output is an input of any frame, before the first is made. Frames with the same input are
/// made once and copied.
/// @param input    the name of the input, which may have a place for the frame
/// @param outputs  the options that name the files of a frame
/// @return the exit code
int runFrames(const CommandLine& line, const std::string& input, std::span<const char* const> outputs,
              const FramePreparer& prepare);

}  // namespace cli
