// SPDX-License-Identifier: Apache-2.0
/// @file fast_sweeping.h
/// openvdb::tools::FastSweeping, instantiated once: solves |grad phi| = 1 starting from known distances.
#pragma once

#include "vdbtools/base/grids.h"

namespace vdbtools {

/// Extends a signed distance field to the active nodes of @a mask.
/// @param sweeps  number of rounds, each over the eight directions
openvdb::FloatGrid::Ptr extendSdf(const openvdb::FloatGrid& sdf, const openvdb::MaskGrid& mask, int sweeps);

/// Extends a signed distance field by @a layers voxels on both sides.
/// @param anyInside  false if no value is negative, a case that OpenVDB's last step cannot handle
openvdb::FloatGrid::Ptr dilateSdf(const openvdb::FloatGrid& sdf, int layers, bool anyInside);

/// The signed distance to a field's zero set, at the field's active nodes: in voxels, negative where the field is
/// negative.
/// @pre the field has both signs
openvdb::FloatGrid::Ptr sdfOfField(const openvdb::FloatGrid& field);

}  // namespace vdbtools
