// SPDX-License-Identifier: Apache-2.0
#include "surface/part_shape.h"

#include "base/in_parallel.h"
#include "base/lattice_transform.h"
#include "distance/distance_band.h"
#include "distance/mesh_conversion.h"
#include "vdbtools/base/text.h"
#include "vdbtools/surface/extract_mesh.h"
#include "vdbtools/surface/level_set.h"

#include <openvdb/tools/Composite.h>
#include <openvdb/tools/Prune.h>
#include <openvdb/tree/LeafManager.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace vdbtools {
namespace {

using openvdb::FloatGrid;
using openvdb::FloatTree;
using openvdb::Vec3d;
using openvdb::Vec3I;

/// Halves all edges longer than @a longest, and the triangles with them, until there are none; the mesh stays closed.
/// Normals are interpolated.
Mesh refined(Mesh mesh, double longest) {
  constexpr std::size_t kMostTriangles = 40'000'000;
  for (bool again = true; again && mesh.triangles.size() < kMostTriangles;) {
    again = false;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> halves;
    const auto half = [&](std::uint32_t a, std::uint32_t b) -> std::optional<std::uint32_t> {
      if ((mesh.points[a] - mesh.points[b]).length() <= longest) return std::nullopt;
      const auto [at, isNew] = halves.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.points.size()));
      if (isNew) {
        mesh.points.push_back((mesh.points[a] + mesh.points[b]) / 2.0);
        openvdb::Vec3s normal = mesh.normals[a] + mesh.normals[b];
        if (!normal.normalize(1e-6F)) normal = mesh.normals[a];
        mesh.normals.push_back(normal);
      }
      return at->second;
    };
    std::vector<Vec3I> triangles;
    triangles.reserve(mesh.triangles.size());
    for (const Vec3I& t : mesh.triangles) {
      std::array<std::optional<std::uint32_t>, 3> middle;
      int count = 0, first = 0;
      for (int c = 0; c < 3; ++c) {
        middle[static_cast<std::size_t>(c)] = half(t[c], t[(c + 1) % 3]);
        count += middle[static_cast<std::size_t>(c)].has_value();
      }
      // Rotated so that a single split edge is the first one, and that with two split edges the last one is not split.
      for (int c = 0; c < 3; ++c) {
        const auto has = [&](int k) { return middle[static_cast<std::size_t>((c + k) % 3)].has_value(); };
        if ((count == 1 && has(0)) || (count == 2 && !has(2))) first = c;
      }
      const auto corner = [&](int c) { return t[(first + c) % 3]; };
      const auto cut = [&](int c) { return *middle[static_cast<std::size_t>((first + c) % 3)]; };
      switch (count) {
        case 0: triangles.push_back(t); break;
        case 1:
          triangles.emplace_back(corner(0), cut(0), corner(2));
          triangles.emplace_back(cut(0), corner(1), corner(2));
          break;
        case 2:
          triangles.emplace_back(cut(0), corner(1), cut(1));
          triangles.emplace_back(corner(0), cut(0), cut(1));
          triangles.emplace_back(corner(0), cut(1), corner(2));
          break;
        default:
          triangles.emplace_back(corner(0), cut(0), cut(2));
          triangles.emplace_back(cut(0), corner(1), cut(1));
          triangles.emplace_back(cut(1), corner(2), cut(2));
          triangles.emplace_back(cut(0), cut(1), cut(2));
      }
      again = again || count > 0;
    }
    mesh.triangles = std::move(triangles);
  }
  return mesh;
}

/// The level set of all points nearer than @a radius to a mesh, whose triangles may be points.
FloatGrid::Ptr ballsAround(const Mesh& centres, double radius, double voxelSize, Monitor& monitor) {
  const std::vector<Vec3d> points = toIndexSpace(centres.points, voxelSize);
  const TriangleTree search(points, centres.triangles);
  const double inVoxels = radius / voxelSize;
  FloatGrid::Ptr grid =
      unsignedDistances(search, static_cast<float>(inVoxels + kPartBand + 1), PhaseKind::ThinParts, monitor);
  FloatTree& tree = grid->tree();
  const auto width = static_cast<float>(kPartBand * voxelSize);
  openvdb::tree::LeafManager<FloatTree>(tree).foreach ([&](FloatTree::LeafNodeType& leaf, std::size_t) {
    for (openvdb::Index i = 0; i < FloatTree::LeafNodeType::SIZE; ++i) {
      const float distance = leaf.isValueOn(i)
                                 ? static_cast<float>((static_cast<double>(leaf.getValue(i)) - inVoxels) * voxelSize)
                                 : width;
      if (std::abs(distance) < width)
        leaf.setValueOn(i, distance);
      else
        leaf.setValueOff(i, std::copysign(width, distance));
    }
  });
  tree.root().setBackground(width, true);
  grid->setTransform(latticeTransform(voxelSize));
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  openvdb::tools::pruneLevelSet(tree);
  return grid;
}

/// The centres for balls: at the corners of the triangles that have a thin corner, and between them.
Mesh ballCentres(const Mesh& mesh, const PartThickness& part, const std::vector<bool>& thin, double radius,
                 std::optional<double> floor, const Monitor& monitor) {
  std::vector<char> used(mesh.points.size(), 0);
  Mesh centres;
  for (const Vec3I& t : mesh.triangles) {
    if (!thin[t[0]] && !thin[t[1]] && !thin[t[2]]) continue;
    centres.triangles.push_back(t);
    for (int c = 0; c < 3; ++c) used[t[c]] = 1;
  }
  // The point itself must be within the ball.
  constexpr double kWithin = 0.95;
  std::vector<Vec3d> at(mesh.points.size());
  constexpr std::size_t kGrain = 256;
  inParallel(at.size(), kGrain, monitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (!used[i]) continue;
      at[i] = part.deepestBall(mesh.points[i], Vec3d(mesh.normals[i]), kWithin * radius, radius).centre;
      if (floor) at[i][2] = std::max(at[i][2], *floor + radius);
    }
  });
  std::vector<std::uint32_t> numbers(at.size());
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (!used[i]) continue;
    numbers[i] = static_cast<std::uint32_t>(centres.points.size());
    centres.points.push_back(at[i]);
  }
  for (Vec3I& t : centres.triangles)
    for (int c = 0; c < 3; ++c) t[c] = numbers[t[c]];
  return centres;
}

}  // namespace

FloatGrid::Ptr partLevelSet(const Mesh& closed, double voxelSize, Monitor& monitor) {
  return convert(toIndexSpace(closed.points, voxelSize), closed.triangles,
                 {.voxelSize = voxelSize, .exteriorBandWidth = kPartBand, .interiorBandWidth = kPartBand}, monitor);
}

void cutBelow(FloatGrid& part, double floor, Monitor& monitor) {
  const double voxel = part.voxelSize()[0];
  openvdb::CoordBBox nodes = part.evalActiveVoxelBoundingBox();
  constexpr int kBeyond = 16;
  nodes.expand(kBeyond);
  const Vec3d low = nodes.min().asVec3d() * voxel, high = nodes.max().asVec3d() * voxel;
  Mesh box;
  for (int n = 0; n < 8; ++n)
    box.points.emplace_back(n & 1 ? high[0] : low[0], n & 2 ? high[1] : low[1], n & 4 ? high[2] : floor);
  box.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                   {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  const FloatGrid::Ptr above = partLevelSet(box, voxel, monitor);
  openvdb::tools::csgIntersection(part, *above);
}

std::size_t thicken(FloatGrid& part, const Mesh& mesh, double thickness, std::optional<double> floor,
                    Monitor& monitor) {
  const double voxel = part.voxelSize()[0], radius = thickness / 2;
  monitor.begin(PhaseKind::Thickness, 0);
  const PartThickness depths(mesh, thickness, floor, monitor);
  const Mesh fine = refined(mesh, thickness);
  std::vector<char> isThin(fine.points.size(), 0);
  constexpr std::size_t kGrain = 256;
  inParallel(isThin.size(), kGrain, monitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3d& point = fine.points[i];
      if (floor && point[2] <= *floor) continue;
      isThin[i] = !depths.isThick(point, Vec3d(fine.normals[i]), thickness);
    }
  });
  const std::vector<bool> thin(isThin.begin(), isThin.end());
  const auto count = static_cast<std::size_t>(std::count(thin.begin(), thin.end(), true));
  if (count == 0) return 0;
  // Marching cubes cuts off at most an eighth of a voxel from a ball.
  const FloatGrid::Ptr balls =
      ballsAround(ballCentres(fine, depths, thin, radius, floor, monitor), radius + voxel / 4, voxel, monitor);
  if (floor) cutBelow(*balls, *floor, monitor);
  openvdb::tools::csgUnion(part, *balls);
  return count;
}

void dropThin(FloatGrid& part, const Mesh& mesh, double thickness, Monitor& monitor) {
  const double voxel = part.voxelSize()[0], radius = thickness / 2;
  const FloatGrid::Ptr deep = convert(
      toIndexSpace(mesh.points, voxel), mesh.triangles,
      {.voxelSize = voxel, .exteriorBandWidth = kPartBand, .interiorBandWidth = radius / voxel + kPartBand}, monitor);
  // The centres of balls fill the part of the solid that lies deeper than their radius.
  bool any = false;
  for (auto value = deep->tree().beginValueAll(); value; ++value) {
    value.setValue(*value + static_cast<float>(radius));
    any = any || *value < 0;
  }
  if (!any)
    throw DataError("nothing of the part is " + shortText(thickness) +
                    " mm thick, so nothing would be left of it; thicken thin parts instead, or make the part larger");
  const Mesh centres = meshOfLevelSet(*deep, monitor);
  const FloatGrid::Ptr stays = ballsAround(centres, thickness, voxel, monitor);
  openvdb::tools::csgUnion(*stays, *partLevelSet(centres, voxel, monitor));
  openvdb::tools::csgIntersection(part, *stays);
}

}  // namespace vdbtools
