// SPDX-License-Identifier: Apache-2.0
/// @file mesh_conversion.h
/// What meshToSdf() and repairedMeshToSdf() share: the conversion itself, and checks of its result.
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

/// The signed distances of a mesh, scaled to world units. Nothing is checked.
/// @param points  index space
/// @param united  as of signedDistances()
/// @throw Interrupted
openvdb::FloatGrid::Ptr convert(const std::vector<openvdb::Vec3d>& points, const std::vector<openvdb::Vec3I>& triangles,
                                const MeshToSdfOptions& options, Monitor& monitor, std::size_t* united = nullptr);

/// A level set of distances in voxels, in world units; named "phi". Changes the grid that it is given.
openvdb::FloatGrid::Ptr toWorld(openvdb::FloatGrid::Ptr grid, double voxelSize);

/// What convert() makes for narrower bands, out of the @a band that it made for wider ones, without finding a distance
/// again: each node and each tile has the same bits. A node whose distance is the width itself after it is scaled to
/// world units does not belong to the band. The band itself where nothing is to be left out.
/// @param options  as of the narrower band; the voxel size is that of @a band
openvdb::FloatGrid::Ptr narrowed(const openvdb::FloatGrid::Ptr& band, const MeshToSdfOptions& options);

/// Points spread over the surface, about @a count of them, each standing for the same area; the same ones every time.
struct SurfaceSample {
  openvdb::Vec3d position;
  std::uint32_t triangle = 0;
};
std::vector<SurfaceSample> sampleSurface(const std::vector<openvdb::Vec3d>& points,
                                         const std::vector<openvdb::Vec3I>& triangles, std::size_t count);

/// The share of the surface that bounds nothing: none of the 4^3 nodes around a sample is below @a isovalue. A surface
/// that does bound something has such a node next to it, as the block reaches a voxel and more to each side; within an
/// overlap or at an inner wall, both sides are inside. A sheet that stands free in the outside has none: there the mesh
/// leaks or is thinner than a voxel.
double lostShare(const openvdb::FloatGrid& grid, const std::vector<SurfaceSample>& samplesInIndexSpace,
                 float isovalue = 0);

/// @return the number of nodes with phi < 0, tiles included
double insideNodes(const openvdb::FloatGrid& grid);

}  // namespace vdbtools
