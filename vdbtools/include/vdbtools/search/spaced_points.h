// SPDX-License-Identifier: Apache-2.0
/// @file spaced_points.h
/// Points spread over a surface as blue noise: irregular, yet nowhere crowded and nowhere sparse. Distances are
/// Euclidean, in world units: on two sides of a thin sheet points keep apart, too. The same seed gives the same points,
/// for any number of threads.
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
  std::uint32_t triangle = 0;  ///< of the mesh, in which the point was placed
  openvdb::Vec3d weights;      ///< of the triangle's corners, adding up to 1
  bool lost = false;           ///< it has no place on the surface that is meant, and is not used
};

/// Moves points from the mesh to the surface that the mesh stands for, or marks them as lost. What it does to a point
/// depends on that point alone. It is called in many threads at once.
using PointMover = std::function<void(std::span<PlacedPoint>)>;

struct SpacedPointsOptions {
  std::uint64_t seed = 1;
  PointMover move{};  ///< none: the points stay on the mesh
  /// Whether the normal of a point near a sharp edge is that of its triangle; otherwise it is interpolated between the
  /// normals of the corners.
  bool keepsCreases = false;
};

struct SpacedPoints {
  std::vector<PlacedPoint> points;
  double spacing = 0;  ///< the least distance between two of them; 0: there is only one
  /// The greatest distance found from the mesh to the nearest point, by a sample of the mesh of four places a point.
  double reach = 0;
  std::uint64_t lost = 0;  ///< of those that were tried
};

/// No two points are nearer to each other than @a spacing; and no place on the mesh is farther than 1.1 spacing from a
/// point, if the points were not moved; otherwise no farther than that and the way of a move, but for places whose
/// points were lost. By dart throwing over the triangles, then over the pieces of them that are not covered, which are
/// halved [Cline et al., Dart Throwing on Surfaces, EGSR 2009].
/// @param mesh  with normals
/// @throw std::invalid_argument  a spacing that is not positive, or that would take more than 2^27 points
/// @throw DataError              a mesh without an area; every point was lost
/// @throw Interrupted
SpacedPoints pointsBySpacing(const Mesh& mesh, double spacing, const SpacedPointsOptions& options, Monitor& monitor);

/// Exactly @a count points, as far from each other as weighted sample elimination leaves them [Yuksel 2015], which is
/// some 0.7 of the distance in the densest packing.
/// @throw std::invalid_argument  a count of 0 or above 2^25
/// @throw DataError              a mesh without an area; too many points were lost
/// @throw Interrupted
SpacedPoints pointsByCount(const Mesh& mesh, std::uint64_t count, const SpacedPointsOptions& options, Monitor& monitor);

}  // namespace vdbtools
