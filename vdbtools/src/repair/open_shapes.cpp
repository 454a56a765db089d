// SPDX-License-Identifier: Apache-2.0
#include "repair/open_shapes.h"

#include "base/elementary.h"
#include "distance/distance_band.h"
#include "distance/hole_caps.h"
#include "distance/level_surface.h"
#include "distance/mesh_conversion.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/base/text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>

namespace vdbtools {
namespace {

using openvdb::Vec3d;
using openvdb::Vec3I;

/// The projected area of a mesh along one axis.
struct SeenArea {
  double up = 0, down = 0;  ///< area of the triangles that face to either side
};

std::array<SeenArea, 3> seenAreas(const Mesh& mesh) {
  std::array<SeenArea, 3> seen;
  for (const Vec3I& t : mesh.triangles) {
    const Vec3d& a = mesh.points[t[0]];
    const Vec3d normal = (mesh.points[t[1]] - a).cross(mesh.points[t[2]] - a) / 2.0;
    for (int axis = 0; axis < 3; ++axis) {
      SeenArea& side = seen[static_cast<std::size_t>(axis)];
      (normal[axis] > 0 ? side.up : side.down) += std::abs(normal[axis]);
    }
  }
  return seen;
}

/// If more than this fraction of the area faces the other way, a mesh is more than a height field with a few folds.
constexpr double kOverhang = 1e-3;

}  // namespace

Mesh solidified(const Mesh& mesh, const SolidifyOptions& options, bool repair) {
  Mesh block = weldMesh({.points = mesh.points, .triangles = mesh.triangles});
  if (repair) block = capInnerLoops(std::move(block));
  const std::vector<OpenEdge> edges = openEdges(block);
  if (edges.empty())
    throw DataError("the mesh has no open edge from which walls could go down: it is closed, and can be used as it is");
  const std::array<SeenArea, 3> seen = seenAreas(block);
  int up = options.up.value_or(0);
  if (!options.up)
    for (int axis = 1; axis < 3; ++axis) {
      const SeenArea &one = seen[static_cast<std::size_t>(axis)], &best = seen[static_cast<std::size_t>(up)];
      if (one.up + one.down > best.up + best.down) up = axis;
    }
  const SeenArea& side = seen[static_cast<std::size_t>(up)];
  if (!(side.up + side.down > 0))
    throw DataError("seen along the axis that is up, the mesh has no area: name another axis");
  double lowest = std::numeric_limits<double>::infinity();
  for (const Vec3I& t : block.triangles)
    for (int c = 0; c < 3; ++c) lowest = std::min(lowest, block.points[t[c]][up]);

  // A point of the base below each point.
  const auto first = static_cast<std::uint32_t>(block.points.size());
  block.points.reserve(2 * block.points.size());
  for (std::uint32_t p = 0; p < first; ++p) {
    Vec3d below = block.points[p];
    below[up] = lowest - options.depth;
    block.points.push_back(below);
  }
  const bool overhangs = std::min(side.up, side.down) > kOverhang * (side.up + side.down);
  std::vector<Vec3I> base;
  if (overhangs)
    for (const BoundaryLoop& loop : boundaryLoops(block)) spanLoop(loop, block.points, base);
  else
    for (const Vec3I& t : block.triangles) base.emplace_back(t[0], t[2], t[1]);
  for (const Vec3I& t : base) block.triangles.push_back(t + Vec3I(first));
  for (const OpenEdge& edge : edges) {
    block.triangles.emplace_back(edge.b, edge.a, edge.a + first);
    block.triangles.emplace_back(edge.b, edge.a + first, edge.b + first);
  }
  if (side.down > side.up)
    for (Vec3I& t : block.triangles) std::swap(t[1], t[2]);
  return block;
}

Mesh offsetSurface(const Mesh& mesh, double distance, double voxelSize, Monitor& monitor) {
  constexpr double kMargin = 2.5;           // voxels known beyond the surface
  constexpr double kFinest = 1.0 / 16;      // of the voxel size
  constexpr double kMostNodes = 536870912;  // for the lattice: about 4 GB
  const double spacing = std::max(std::min(voxelSize, distance / 2), kFinest * voxelSize);
  const double width = distance / spacing + kMargin;
  const MeshReport report = reportMesh(mesh);
  const double area = report.area / (spacing * spacing);
  const Vec3d sides = report.box.extents() / spacing + Vec3d(2 * width + 1);
  const double around = (static_cast<double>(report.triangles) + area) * elementary::pow(2 * width + 1, 3);
  const double nodes = std::min(sides[0] * sides[1] * sides[2], around);
  if (!(nodes < kMostNodes))
    throw std::invalid_argument("with voxels of " + shortText(spacing) + ", everything within " + shortText(distance) +
                                " of this mesh has about " + shortText(nodes) + " nodes, more than the " +
                                shortText(kMostNodes) + " that are allowed; use larger voxels or another distance");
  // A float for each node; if most of a lattice is far from the surface, only some of its nodes are created.
  constexpr double kBytesForNode = 4, kLeastShare = 0.25;
  requireMemory(kBytesForNode * kLeastShare * std::min(nodes, area * 2 * width), MemoryUse::Distances,
                "everything within " + shortText(distance) + " of this mesh");
  const Vec3d middle = report.box.getCenter();  // the mesher returns points in single precision
  std::vector<Vec3d> points(mesh.points.size());
  for (std::size_t p = 0; p < points.size(); ++p) points[p] = (mesh.points[p] - middle) / spacing;
  const TriangleTree tree(points, mesh.triangles);
  const LevelSurface surface = levelSurface(
      *unsignedDistances(tree, static_cast<float>(width), PhaseKind::Thickening, monitor), distance / spacing);
  monitor.throwIfCancelled();
  if (surface.triangles.empty())
    throw DataError("nothing is left of the target with voxels of " + shortText(spacing) +
                    ": use finer voxels, or a larger thickness or radius than " + shortText(distance));
  Mesh result{.points = surface.points, .triangles = surface.triangles};
  for (Vec3d& p : result.points) p = middle + spacing * p;
  return result;
}

}  // namespace vdbtools
