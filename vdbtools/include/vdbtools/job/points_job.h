// SPDX-License-Identifier: Apache-2.0
/// @file points_job.h
/// Oriented points on a surface, as `juliavdb points` makes them: for dressing sets, and for programs that take points.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh/mesh_sink.h"
#include "vdbtools/mesh/vertex_column.h"
#include "vdbtools/scene/scene.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace vdbtools {

/// Exactly one of count and spacing is there.
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
  double reach = 0;           ///< how far the surface was found to lie from the nearest point at most, world units
  std::uint64_t lost = 0;     ///< places that were tried, and had no true surface within a voxel

  PointBatch batch() const { return {positions, normals, values}; }
};

/// On the true surface F = 0 of a scene, within its options' tolerance: spread over its mesh, and moved along the
/// normals of that by up to a voxel. The normals are those of the mesh, as the true surface may have none. The points
/// have the attributes of the scene's options, computed at the points.
/// @throw as fractalMesh(), pointsBySpacing() and pointsByCount()
OrientedPoints fractalPoints(const Scene& scene, const PointsOptions& options, Monitor& monitor);

/// On a mesh. What the mesh has at its points is carried over: red, green and blue together as the colour Cd, other
/// numbers under their names.
/// @throw as pointsBySpacing() and pointsByCount()
OrientedPoints meshPoints(Mesh mesh, const PointsOptions& options, Monitor& monitor);

}  // namespace vdbtools
