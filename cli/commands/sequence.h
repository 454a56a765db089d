// SPDX-License-Identifier: Apache-2.0
/// @file sequence.h
/// Sequences that one process makes frame by frame: the option --frames of all commands that have it, the checks before
/// the first frame, which frames are kept, which failures end the sequence, and what is reported.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/farm/plans.h"
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
    "a sequence: a list of numbers and ranges such as 7, 1-48, -5-5, or 1-48x2 or 1-48:2 for every second one. Names "
    "such as "
    "in.####.obj and out.$F4.vdb have a place for the frame, and outputs need one; what has none is the same in all "
    "frames";

/// The options that name the files of a frame, for commands with one output.
inline constexpr const char* kOnlyOutput[] = {"output"};

/// --frames and --keep-going.
void addFramesOption(CommandLine& line);
/// The same options, and --key, --ease and --force of 'fractal'.
void addSequenceOptions(CommandLine& line);
/// @throw std::invalid_argument  an option that requires --frames without it, or --frame and --frames together
void requireSequenceFits(const CommandLine& line);

/// The requested frames; empty without --frames.
/// @param outputs  the options that name the files of a frame
/// @throw std::invalid_argument  --frames is not a valid list, an option that requires --frames without it, or the name
///                               of an output has no frame pattern although there are several frames
std::vector<int> framesOf(const CommandLine& line, std::span<const char* const> outputs);

/// Reports that all frames are the same, if there are several.
void noteEqualFrames(std::size_t frames);

struct SequenceCounts {
  std::size_t frames = 0, keptFrames = 0;
  std::size_t failed = 0;
  std::string firstFailure;  ///< with the number of the frame; empty if no frame failed
  int failureCode = 0;
};

/// What was done for a frame.
enum class FrameOutcome { Made, Kept };
/// @param isLast  whether nothing is made after this frame
using FrameMaker = std::function<FrameOutcome(std::size_t index, bool isLast, vdbtools::Monitor& monitor)>;

/// Checks all frames before the first one is made. With --keep-going, a frame that does not pass fails later, when it
/// is its turn. @throw FailedWith  names the frame @throw vdbtools::Interrupted
void checkFrames(const CommandLine& line, const std::vector<int>& frames, const std::function<void(int frame)>& check);

/// Makes frames in their order. A failure is reported with the number of its frame. It ends the sequence or, with
/// --keep-going, only that frame.
/// @throw FailedWith, vdbtools::Interrupted
SequenceCounts makeSequence(const CommandLine& line, const std::vector<int>& frames, const FrameMaker& make);

/// Reports how many frames were made and kept. @param keeps  whether existing frames may be kept
/// @return the exit code @throw FailedWith  some frames have failed
int finishSequence(const SequenceCounts& counts, bool keeps);

/// Copies the files of one frame to the names of another, and reports it.
/// @param outputs  the options that name the files of a frame
/// @return false if the files cannot be copied; nothing was written then
bool copyFrame(const CommandLine& line, std::span<const char* const> outputs, int from, int to, bool isLast);

// ---- One fractal of a sequence -------------------------------------------------------------------------------------

struct FractalRun {
  vdbtools::Recipe recipe;  ///< the recipe to record
  vdbtools::Recipe found;   ///< the same with the current paths of its files
  std::optional<int> frame;
  bool isLast = true;  ///< whether nothing is made after it
};

using FractalMaker = std::function<void(const FractalRun&, vdbtools::Monitor&)>;

/// Makes the fractals of frames. It keeps frames whose files exist and record the frame's recipe, and copies the files
/// of the previous frame if that has the same recipe.
/// @throw as makeSequence()
SequenceCounts makeFractals(const CommandLine& line, const vdbtools::farm::FrameRecipes& recipes,
                            std::span<const char* const> outputs, const FractalMaker& make);

// ---- Commands that make files from one input -----------------------------------------------------------------------

/// A frame that is being made, or the only output of a command without --frames.
struct FrameRun {
  Outputs& outputs;
  vdbtools::Monitor& monitor;
  bool isLast;  ///< for Outputs::commit()
};

/// The work of a command on one input.
struct FrameJob {
  vdbtools::InputFiles inputs{};  ///< what is read in addition to CommandLine::inputs()
  /// Claims the outputs, makes and commits them, and reports them.
  std::function<void(const FrameRun&)> make{};
};

/// Checks everything about an input. Of the input itself it reads only the recipe.
using FramePreparer = std::function<FrameJob(const std::string& input)>;

/// Runs a command on its input or, with --frames, on each frame's input. Before the first frame is made, all frames are
/// prepared, all inputs must exist and be readable (with --keep-going, they fail their own frame), and no output may be
/// an input of any frame. If all frames have the same input, the first frame is made and the others are copies.
/// @param input    the name of the input, which may contain a frame pattern
/// @param outputs  the options that name the files of a frame
/// @return the exit code
int runFrames(const CommandLine& line, const std::string& input, std::span<const char* const> outputs,
              const FramePreparer& prepare);

}  // namespace cli
