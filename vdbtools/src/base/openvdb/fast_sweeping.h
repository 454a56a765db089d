// SPDX-License-Identifier: Apache-2.0
/// @file fast_sweeping.h
/// openvdb::tools::FastSweeping, instantiated once: distances that solve |grad phi| = 1 about those that are known.
#pragma once

#include "vdbtools/base/grids.h"

namespace vdbtools {

/// Extends a signed distance field to the active nodes of @a mask.
/// @param sweeps  rounds of the eight directions
openvdb::FloatGrid::Ptr extendSdf(const openvdb::FloatGrid& sdf, const openvdb::MaskGrid& mask, int sweeps);

/// Extends a signed distance field by @a layers voxels on both sides.
/// @param anyInside  false where no value is negative, which OpenVDB's last step cannot deal with
openvdb::FloatGrid::Ptr dilateSdf(const openvdb::FloatGrid& sdf, int layers, bool anyInside);

/// The signed distance to a field's zero set, at the field's active nodes: voxels, negative where the field is.
/// @pre the field has both signs
openvdb::FloatGrid::Ptr sdfOfField(const openvdb::FloatGrid& field);

}  // namespace vdbtools
