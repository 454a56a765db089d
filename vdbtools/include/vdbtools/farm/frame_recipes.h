// SPDX-License-Identifier: Apache-2.0
/// @file frame_recipes.h
/// The recipes of a sequence whose frames one process makes one after the other.
#pragma once

#include "vdbtools/farm/frame_plan.h"
#include "vdbtools/files/input_files.h"

#include <memory>

namespace vdbtools::farm {

class FrameRecipes {
 public:
  /// Checks the options of every frame, and that the files they name exist. Nothing is opened.
  /// @param options  without names and makes, which belong to plans
  /// @throw std::invalid_argument  an option is refused (the message names the frame)
  /// @throw MissingInputError      names the first few missing files
  explicit FrameRecipes(FramePlanOptions options);
  ~FrameRecipes();

  const std::vector<int>& frames() const { return mOptions.frames; }
  /// The files that any of the frames names.
  const InputFiles& inputs() const { return mInputs; }

  /// The complete recipe of a frame, with the hashes of its files. A file that several frames name is read once, and
  /// later recipes use its hash to refuse a changed file.
  /// @throw MissingInputError, DataError, IoError  as when reading the files
  Recipe at(int frame) const;

 private:
  struct Hashes;
  FramePlanOptions mOptions;
  InputFiles mInputs;
  std::unique_ptr<Hashes> mHashes;
};

}  // namespace vdbtools::farm
