// SPDX-License-Identifier: Apache-2.0
/// @file frame_plan.h
/// Plans of frames: a fractal for each frame, with options that change from frame to frame by keys, inputs with a file
/// for each frame, and targets that are animated.
///
/// Between two keys, at the fraction t of the way from one frame to the other, a number is
///
///     a + (b - a) t                    linear
///     a + (b - a) (3 t^2 - 2 t^3)      smooth: its slope is 0 at every key, and it stays between a and b
///     a                                step
///
/// Before the first key and after the last it is constant. At a key the value is the key's text itself. Several numbers
/// with separators between them, as in "0,1,-2" or "x:0.05:0.6:smooth", are blended one by one; the text around them
/// must be the same in both keys.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/farm/manifest.h"
#include "vdbtools/recipe/option_table.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools::farm {

enum class Ease { Linear, Smooth, Step };

/// The values of an option at some frames.
struct KeyedOption {
  std::string name;
  std::map<int, std::string> keys;  ///< by frame, at least one
  Ease ease = Ease::Linear;
};

inline constexpr int kMostFrames = 100'000;

/// Parses a list of frames and ranges such as "7", "1-48", "1-48x2" (every second one, from 1 on) or "1-48x8,1-48"
/// (every eighth first, and then the others). Numbers may be negative, as in "-5-5" or "-8--4". The result is in the
/// order of the list, each frame once.
/// @throw std::invalid_argument  not such a list, a reversed range, or more than kMostFrames
std::vector<int> parseFrames(const std::string& text);

/// @param keys   such as "alpha@48=120"
/// @param eases  "linear", "smooth" or "step" for all options, or for one as in "alpha=smooth", which takes precedence
/// @return the options in the order of their names
/// @throw std::invalid_argument  an unknown option, two values at one frame, or two keys that cannot be blended
std::vector<KeyedOption> parseKeys(const std::vector<std::string>& keys, const std::vector<std::string>& eases,
                                   const OptionTable& table);

/// The option's value at a frame. @throw std::invalid_argument  the keys around the frame cannot be blended
std::string valueAt(const KeyedOption& option, int frame);

struct FramePlanOptions {
  Recipe base;   ///< of `juliavdb fractal`. File names may have a frame pattern (vdbtools/files/frame_name.h)
  Recipe given;  ///< options of the base that were requested as explicitly as the keys and are not replaced by them
  std::vector<KeyedOption> keys;
  std::vector<int> frames{1};             ///< in the order of execution
  std::string name;                       ///< base name of the files; empty: named after the target, or else the map
  std::vector<std::string> makes{"vdb"};  ///< any of writtenFormats()
  std::optional<double> resolution{};     ///< the value of `--resolution auto` at every frame that has it
  std::optional<double> sdfResolution{};  ///< that of `--sdf-resolution auto`, likewise
};

/// If the target is one glTF with animations, and its frame is neither given nor keyed, gives each frame its own number
/// as `--target-frame`, by a key. @throw DataError, IoError  the target cannot be read
void playTarget(FramePlanOptions& options);

/// Sets options.resolution if a frame has `auto`: to the largest number that the first of these frames, the middle one
/// and the last would choose by themselves, so that the frames of a sequence have matching voxels. Sets
/// options.sdfResolution likewise, if the target changes from frame to frame.
/// @throw as makeScene()
void chooseResolution(FramePlanOptions& options, Monitor& monitor);

/// The given options and their values at a frame.
/// @throw std::invalid_argument  keys cannot be blended, or a name has more than one place for the frame
Recipe recipeAt(const FramePlanOptions& options, int frame);

/// @throw std::invalid_argument  a key is a file name with a frame pattern
void requireKeysWithoutPatterns(const FramePlanOptions& options);

/// Plans a task for each frame, whose files are out/NAME.0007.vdb and the like. Every frame's recipe is checked, and
/// all files that it names are read and hashed. If nothing changes from frame to frame, all are the same.
/// @throw std::invalid_argument  an option is refused (the message names the frame)
/// @throw MissingInputError      a frame's file is missing
/// @throw DataError, IoError
Manifest planFrames(const FramePlanOptions& options);

}  // namespace vdbtools::farm
