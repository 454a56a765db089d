// SPDX-License-Identifier: Apache-2.0
/// @file mesh_to_volume.h
/// openvdb::tools::meshToVolume, instantiated once.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"

#include <vector>

namespace vdbtools {

enum class DistanceField { Signed, SignedNotRenormalized, Unsigned };

/// The distances to a mesh, in a narrow band about it.
/// @param points  index space; so are the distances and the widths of the bands
/// @param closest  receives the index of the triangle closest to each active node, unless it is null
/// @throw Interrupted
openvdb::FloatGrid::Ptr meshToVolume(const std::vector<openvdb::Vec3d>& points,
                                     const std::vector<openvdb::Vec3I>& triangles, float exteriorBand,
                                     float interiorBand, DistanceField kind, openvdb::Int32Grid* closest,
                                     const Monitor& monitor);

}  // namespace vdbtools
