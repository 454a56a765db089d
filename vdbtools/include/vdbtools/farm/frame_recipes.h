// SPDX-License-Identifier: Apache-2.0
/// @file frame_recipes.h
/// The recipes of a sequence whose frames are made one after the other by one process.
#pragma once

#include "vdbtools/farm/frame_plan.h"
#include "vdbtools/files/input_files.h"

#include <memory>

namespace vdbtools::farm {

class FrameRecipes {
 public:
  /// Checks every frame: its options, and that the files are there that they name. Nothing is opened.
  /// @param options  without names and makes, which are those of a plan
  /// @throw std::invalid_argument  an option is refused, with the frame; or nothing changes from frame to frame
  /// @throw MissingInputError      the first few of the files that are missing
  explicit FrameRecipes(FramePlanOptions options);
  ~FrameRecipes();

  const std::vector<int>& frames() const { return mOptions.frames; }
  /// The files that any of the frames names.
  const InputFiles& inputs() const { return mInputs; }

  /// The recipe of a frame: complete, and with the hashes of its files. A file that several frames name is read once,
  /// and its hash in later recipes lets them refuse another.
  /// @throw MissingInputError, DataError, IoError  as reading the files
  Recipe at(int frame) const;

 private:
  struct Hashes;
  FramePlanOptions mOptions;
  InputFiles mInputs;
  std::unique_ptr<Hashes> mHashes;
};

}  // namespace vdbtools::farm
