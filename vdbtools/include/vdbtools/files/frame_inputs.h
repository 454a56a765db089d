// SPDX-License-Identifier: Apache-2.0
/// @file frame_inputs.h
/// Collects the files that the frames of a sequence read, so that missing files are reported before the work begins.
#pragma once

#include "vdbtools/files/input_files.h"

#include <cstddef>
#include <filesystem>
#include <set>
#include <string>

namespace vdbtools {

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
