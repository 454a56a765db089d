// SPDX-License-Identifier: Apache-2.0
/// @file points_job.h
/// Oriented points on a surface, as `juliavdb points` makes them: for dressing sets, and for programs that take points.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh/mesh_sink.h"
#include "vdbtools/scene/scene.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace vdbtools {

/// Exactly one of count and spacing is set.
struct PointsOptions {
  std::optional<std::uint64_t> count;
  std::optional<double> spacing;  ///< world units: the least distance between two points
  std::uint64_t seed = 1;
};

struct OrientedPoints {
  std::vector<openvdb::Vec3d> positions;  ///< world units
  std::vector<openvdb::Vec3s> normals;
  std::vector<VertexColumn> columns;
  std::vector<float> values;  ///< row by row
  double spacing = 0;         ///< the least distance between two points, world units
  double reach = 0;        ///< the largest distance that was found from the surface to its nearest point, world units
  std::uint64_t lost = 0;  ///< number of tried places that had no true surface within a voxel

  PointBatch batch() const { return {positions, normals, values}; }
};

/// Makes points on the true surface F = 0 of a scene, within the tolerance of its options. They are spread over the
/// mesh and then moved along its normals by up to a voxel. They have the normals of the mesh, because the true surface
/// may have none, and the attributes that the scene's options name.
/// @throw as fractalMesh(), pointsBySpacing() and pointsByCount()
OrientedPoints fractalPoints(const Scene& scene, const PointsOptions& options, Monitor& monitor);

/// Makes points on a mesh. The attributes of the mesh are carried over: red, green and blue together as the colour Cd,
/// other numbers under their names.
/// @throw as pointsBySpacing() and pointsByCount()
OrientedPoints meshPoints(Mesh mesh, const PointsOptions& options, Monitor& monitor);

}  // namespace vdbtools
