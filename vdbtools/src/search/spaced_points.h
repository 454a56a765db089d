// SPDX-License-Identifier: Apache-2.0
/// @file spaced_points.h
/// Points spread over a surface as blue noise: irregular, but of even density. Distances are Euclidean, in world units,
/// so points on two sides of a thin sheet keep apart, too. The same seed gives the same points, for any number of
/// threads.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh.h"

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace vdbtools {

struct PlacedPoint {
  openvdb::Vec3d position;     ///< world units
  openvdb::Vec3s normal;       ///< of unit length, outward
  std::uint32_t triangle = 0;  ///< the triangle of the mesh in which the point was placed
  openvdb::Vec3d weights;      ///< barycentric coordinates in the triangle, which sum to 1
  bool lost = false;           ///< whether the point has no place on the intended surface; it is not used
};

/// Moves points from the mesh to the surface that the mesh approximates, or marks them as lost. The result for a point
/// depends on that point alone. Many threads call it at once.
using PointMover = std::function<void(std::span<PlacedPoint>)>;

struct SpacedPointsOptions {
  std::uint64_t seed = 1;
  PointMover move{};  ///< if empty, the points stay on the mesh
  /// Whether a point near a sharp edge gets the normal of its triangle; otherwise the normal is interpolated between
  /// the corners.
  bool keepsCreases = false;
};

struct SpacedPoints {
  std::vector<PlacedPoint> points;
  double spacing = 0;  ///< the minimum distance between two points; 0: there is only one
  /// The maximum distance found from the mesh to the nearest point, over a sample of the mesh with four places per
  /// point.
  double reach = 0;
  std::uint64_t lost = 0;  ///< number of tried points that were lost
};

/// Places points at least @a spacing apart. If they are not moved, no place on the mesh is farther than 1.1 spacing
/// from a point. If they are moved, the way of the move adds to that distance, and places whose points were lost are
/// exempt. The method is dart throwing over the triangles, then over the pieces of them that are not covered, which are
/// halved [Cline et al., Dart Throwing on Surfaces, EGSR 2009].
/// @param mesh  with normals
/// @throw std::invalid_argument  a spacing that is not positive, or that would take more than 2^27 points
/// @throw DataError              a mesh without an area; every point was lost
/// @throw Interrupted
SpacedPoints pointsBySpacing(const Mesh& mesh, double spacing, const SpacedPointsOptions& options, Monitor& monitor);

/// Places exactly @a count points. Weighted sample elimination [Yuksel 2015] spaces them at about 0.7 of the distance
/// in the densest packing.
/// @throw std::invalid_argument  a count of 0 or above 2^25
/// @throw DataError              a mesh without an area; too many points were lost
/// @throw Interrupted
SpacedPoints pointsByCount(const Mesh& mesh, std::uint64_t count, const SpacedPointsOptions& options, Monitor& monitor);

}  // namespace vdbtools
