// SPDX-License-Identifier: Apache-2.0
/// @file mesh_conversion.h
/// The common part of meshToSdf() and repairedMeshToSdf(): the conversion itself, and checks of its result.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/distance/mesh_to_sdf.h"
#include "vdbtools/mesh/mesh.h"

#include <cstdint>
#include <string>
#include <vector>

namespace vdbtools {

/// @throw std::invalid_argument  options out of their domain, or too many nodes for this mesh
/// @throw DataError              a mesh without an area
void checkOptions(const MeshReport& report, const MeshToSdfOptions& options);

/// @return the points in index space, in double precision: floats would distort a mesh far from the origin
std::vector<openvdb::Vec3d> toIndexSpace(const std::vector<openvdb::Vec3d>& points, double voxelSize);

/// Computes the signed distances of a mesh, scaled to world units, without any check.
/// @param points  index space
/// @param counts  as in signedDistances()
/// @throw Interrupted
openvdb::FloatGrid::Ptr convert(const std::vector<openvdb::Vec3d>& points, const std::vector<openvdb::Vec3I>& triangles,
                                const MeshToSdfOptions& options, Monitor& monitor, PartCounts* counts = nullptr);

/// Converts a level set of distances in voxels to world units and names it "phi". Changes the given grid.
openvdb::FloatGrid::Ptr toWorld(openvdb::FloatGrid::Ptr grid, double voxelSize);

/// Derives from the @a band that convert() made the narrower band that it would make for @a options, without computing
/// a distance again; each node and each tile has the same bits. A node whose distance equals the width after scaling to
/// world units does not belong to the band. Returns the band itself if nothing is to be removed.
/// @param options  the options of the narrower band, with the voxel size of @a band
openvdb::FloatGrid::Ptr narrowed(const openvdb::FloatGrid::Ptr& band, const MeshToSdfOptions& options);

/// About @a count points spread over the surface, each representing the same area; always the same ones.
struct SurfaceSample {
  openvdb::Vec3d position;
  std::uint32_t triangle = 0;
};
std::vector<SurfaceSample> sampleSurface(const std::vector<openvdb::Vec3d>& points,
                                         const std::vector<openvdb::Vec3I>& triangles, std::size_t count);

/// The fraction of the surface that bounds nothing, i.e. the samples without a node below @a isovalue among the 4^3
/// nodes around them. A surface that bounds something has such a node, because the block reaches more than a voxel to
/// each side; within an overlap or at an inner wall, both sides are inside. A free-standing sheet has none: there the
/// mesh leaks or is thinner than a voxel.
double lostShare(const openvdb::FloatGrid& grid, const std::vector<SurfaceSample>& samplesInIndexSpace,
                 float isovalue = 0);

/// @return the number of nodes with phi < 0, including tiles
double insideNodes(const openvdb::FloatGrid& grid);

}  // namespace vdbtools
