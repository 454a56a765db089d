// SPDX-License-Identifier: Apache-2.0
/// @file clamped_control.h
/// A grid as a control whose values beyond its nodes are those of the nearest of them.
#pragma once

#include "vdbtools/control/control.h"

#include <optional>

namespace vdbtools {

struct Target;

/// Read trilinearly, in the grid's world space. Interpolation does not leave the range of the values.
/// @param nodes  those beyond which the nearest one's value holds; none: the tiles and the background hold there
/// @pre all values are finite
Control clampedControl(openvdb::FloatGrid::ConstPtr grid, const std::optional<openvdb::CoordBBox>& nodes);

/// The same of a grid each node of whose box is active.
Control clampedControl(const openvdb::FloatGrid::ConstPtr& grid);

/// The distance from the target's surface, as far as it is known (distance/target.h).
Control distanceControl(const Target& target);

}  // namespace vdbtools
