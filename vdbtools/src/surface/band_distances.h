// SPDX-License-Identifier: Apache-2.0
/// @file band_distances.h
/// The distances of a level set before its nodes get a sign.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh.h"

namespace vdbtools {

/// Computes the distances to a mesh at the nodes of the band, all positive, active and in world units. The whole mesh
/// and any part of it that contains the nearest triangle give the same bits.
/// @param domain  of the whole field; distances are computed relative to its centre
openvdb::FloatGrid::Ptr bandDistances(const Mesh& mesh, double voxelSize, const openvdb::CoordBBox& domain,
                                      Monitor& monitor);

}  // namespace vdbtools
