// SPDX-License-Identifier: Apache-2.0
/// @file clamped_control.h
/// A grid as a control; points outside its nodes get the value of the nearest node.
#pragma once

#include "vdbtools/control/control.h"

#include <optional>

namespace vdbtools {

struct Target;

/// Reads the grid trilinearly, in its world space. Interpolation stays within the range of the values.
/// @param nodes  points outside them get the nearest node's value; empty: the tiles and the background apply there
/// @pre all values are finite
Control clampedControl(openvdb::FloatGrid::ConstPtr grid, const std::optional<openvdb::CoordBBox>& nodes);

/// The control of a grid that is active at every node of its box.
Control clampedControl(const openvdb::FloatGrid::ConstPtr& grid);

/// The distance from the target's surface, as far as it is known (distance/target.h).
Control distanceControl(const Target& target);

}  // namespace vdbtools
