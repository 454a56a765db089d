// SPDX-License-Identifier: Apache-2.0
/// @file slice_plane.h
/// The plane of a picture, from the options --axis, --position and --size, and the rectangle that they frame.
#pragma once

#include "options.h"

#include "vdbtools/picture/slice_image.h"

#include <optional>

namespace cli {

struct PlanePlacement {
  vdbtools::Axis axis = vdbtools::Axis::Z;
  std::optional<double> position;  ///< position on that axis, world units, if it was given
  int size = 0;                    ///< pixels along the longer side

  /// @param usual  a point of the plane if no position was given
  vdbtools::SlicePlane plane(const openvdb::BBoxd& box, const openvdb::Vec3d& usual) const {
    return {axis, position.value_or(usual[static_cast<int>(axis)]), box, size};
  }
};

/// @param usual  the default position of the plane, in words
void addPlaneOptions(CommandLine& line, const std::string& usual);

/// @throw std::invalid_argument
PlanePlacement parsePlacement(const CommandLine& line);

}  // namespace cli
