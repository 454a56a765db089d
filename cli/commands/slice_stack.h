// SPDX-License-Identifier: Apache-2.0
/// @file slice_stack.h
/// 'juliavdb slice --stack': a picture for each layer of voxels.
#pragma once

#include "options.h"
#include "slice_plane.h"
#include "slice_samples.h"

#include "vdbtools/files/input_files.h"
#include "vdbtools/picture/slice_image.h"

#include <functional>
#include <optional>
#include <string>

namespace cli {

/// --stack and --bits; --units is an option of the fractal.
void addStackOptions(CommandLine& line);

/// The numbers that a stack contains.
struct StackOptions {
  int bits = 8;
  double range = 0;  ///< of fields with a sign
};
/// @throw std::invalid_argument  an option of stacks without --stack, an option that does not go with --stack, or a
///                               missing range
StackOptions parseStack(const CommandLine& line, SliceField field);

/// The numbers of a layer.
using LayerMaker = std::function<vdbtools::SliceCodes(const vdbtools::SlicePlane&, vdbtools::Monitor&)>;

/// Claims the names of a stack's files before the field is made, and writes the layers one by one.
class StackWriter {
 public:
  /// @param inputs  the files that are read in addition to CommandLine::inputs()
  /// @throw std::invalid_argument  the extension is neither .png nor .tif, or the text beside the layers is an input
  /// @throw vdbtools::CreateError  no file can be created in the folder
  StackWriter(const CommandLine& line, vdbtools::InputFiles inputs, StackOptions options);

  /// @param box     world units
  /// @param values  the meaning of the numbers, for the text
  /// @param unit    of the coordinates, if it is known
  /// @throw std::invalid_argument  there are layers of an earlier stack beyond the last of this one
  /// @throw vdbtools::IoError, vdbtools::Interrupted  the layers written before stay
  void write(const PlanePlacement& placement, const openvdb::BBoxd& box, const std::string& values,
             std::optional<vdbtools::LengthUnit> unit, const LayerMaker& make);

 private:
  const CommandLine& mLine;
  vdbtools::InputFiles mInputs;
  StackOptions mOptions;
  std::string mText;  ///< the name of the text
};

}  // namespace cli
