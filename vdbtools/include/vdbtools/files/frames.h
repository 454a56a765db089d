// SPDX-License-Identifier: Apache-2.0
/// @file frames.h
/// The files of a sequence of frames.
#pragma once

#include "vdbtools/files/input_files.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>

namespace vdbtools {

// File names with a frame number, in the notations of Houdini (`$F4`), Nuke and Blender (`####`) and printf (`%04d`).

/// Returns the name of one frame's file. A pattern is one of
///   - `$F4`, padded with zeros to 4 digits, or `$F`, not padded. `$F` before a letter or `_` is another variable, and
///     left alone. `${F4}` and `${F}` are the same and may stand before a letter.
///   - a run of `#`, one for each digit; only in the file's own name, since folder names often contain it.
///   - `%04d`, padded with zeros to 4 digits, or `%d`, not padded.
///   - a run of two or more `@`, in the same way; a single one is a part of the name.
///   - `<F4>` or `<F>`, as `$F4` or `$F`.
///   - `<frame>`, padded with zeros to 4 digits, as some programs for rendering write it.
/// The sign of a negative number stands before its digits: `-0005` for `$F4` and `####`, as Blender has it, and `-005`
/// for `%04d`, where printf counts the sign. A number too long for its padding is written in full. If the name has no
/// pattern, the frame goes before the extension, with 4 digits: `name.vdb` becomes `name.0001.vdb`. Without a pattern
/// and a frame the name is unchanged.
/// @throw std::invalid_argument  a pattern without a frame, more than one pattern, padding with blanks (`%4d`) or
///                               beyond 16 digits, or a frame for a path without a file name
std::string expandFrame(std::string_view name, std::optional<int> frame);

/// Whether the name has such a pattern. @throw std::invalid_argument  as expandFrame() for its pattern
bool hasFramePattern(std::string_view name);

/// The file name without folders, extension and pattern, and without the dots, dashes, blanks and underscores that this
/// leaves at its ends: "run" for "shots/run.####.obj". May be empty. @throw std::invalid_argument  as expandFrame()
std::string stemWithoutFrame(std::string_view name);

// Collects the files that the frames of a sequence read, so that missing files are reported before the work begins.

class FrameInputs {
 public:
  /// Adds a file and checks whether it exists. Nothing is opened.
  /// @param frame  the frame that reads it; if several frames read the same file, the first one is reported
  void add(const std::filesystem::path& file, int frame);

  /// @throw MissingInputError  names the first few missing files and their frames
  void requireNoneMissing() const;

  /// All files, which no output may replace.
  const InputFiles& files() const { return mFiles; }

 private:
  InputFiles mFiles;
  std::set<std::filesystem::path> mKnown;
  std::size_t mMissing = 0;
  std::string mNames;  ///< the first few missing ones
};

}  // namespace vdbtools
