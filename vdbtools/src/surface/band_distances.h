// SPDX-License-Identifier: Apache-2.0
/// @file band_distances.h
/// The distances of a level set before its nodes have a sign.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh.h"

namespace vdbtools {

/// The distances to a mesh at the nodes of the band, all positive, active and in world units: the same bits for the
/// whole mesh and for a part of it that holds the nearest triangle.
/// @param domain  of the whole field; distances are computed about its centre
openvdb::FloatGrid::Ptr bandDistances(const Mesh& mesh, double voxelSize, const openvdb::CoordBBox& domain,
                                      Monitor& monitor);

}  // namespace vdbtools
