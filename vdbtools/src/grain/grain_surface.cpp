// SPDX-License-Identifier: Apache-2.0
#include "base/counter_random.h"
#include "base/in_parallel.h"
#include "exponent/thin_parts.h"
#include "search/point_cells.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/grain/grain.h"

#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

namespace vdbtools {
namespace {

using julia::Point;
using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3d;

Point pointOf(const Vec3d& v) { return {v[0], v[1], v[2]}; }

/// A place on the surface, in index space.
struct SurfacePlace {
  Coord cell;
  Vec3d at{}, normal{};
  double thickness = 0;  ///< voxels
};

/// The middle of the places where a cell's edges cross the surface; nothing if none does.
std::optional<Vec3d> crossingIn(const FloatGrid::ConstAccessor& phi, const Coord& cell) {
  std::array<double, 8> values;
  int inside = 0;
  for (int corner = 0; corner < 8; ++corner) {
    values[static_cast<std::size_t>(corner)] =
        static_cast<double>(phi.getValue(cell.offsetBy(corner & 1, corner >> 1 & 1, corner >> 2)));
    inside += values[static_cast<std::size_t>(corner)] < 0;
  }
  if (inside == 0 || inside == 8) return std::nullopt;
  Vec3d sum(0);
  int count = 0;
  for (int corner = 0; corner < 8; ++corner)
    for (int axis = 0; axis < 3; ++axis) {
      if (corner >> axis & 1) continue;
      const double a = values[static_cast<std::size_t>(corner)],
                   b = values[static_cast<std::size_t>(corner | 1 << axis)];
      if ((a < 0) == (b < 0)) continue;
      Vec3d at(corner & 1, corner >> 1 & 1, corner >> 2);
      at[axis] += a / (a - b);
      sum += at;
      ++count;
    }
  return cell.asVec3d() + sum / count;
}

std::vector<SurfacePlace> surfacePlaces(const FloatGrid& phi, const LocalThickness& thickness, Monitor& monitor) {
  using Sampler = openvdb::tools::BoxSampler;
  const double voxel = phi.voxelSize()[0];
  const openvdb::CoordBBox known = thickness.tau->evalActiveVoxelBoundingBox();
  std::vector<const FloatGrid::TreeType::LeafNodeType*> leaves;
  phi.tree().getNodes(leaves);
  std::vector<std::vector<SurfacePlace>> found(leaves.size());
  inParallel(leaves.size(), 4, monitor, [&](std::size_t begin, std::size_t end) {
    const FloatGrid::ConstAccessor values = phi.getConstAccessor(), tau = thickness.tau->getConstAccessor();
    const auto slopeAt = [&](const Vec3d& at) {
      Vec3d slope;
      for (int axis = 0; axis < 3; ++axis) {
        Vec3d step(0);
        step[axis] = 1;
        slope[axis] = static_cast<double>(Sampler::sample(values, at + step)) -
                      static_cast<double>(Sampler::sample(values, at - step));
      }
      return slope;
    };
    for (std::size_t leaf = begin; leaf != end; ++leaf) {
      for (auto node = leaves[leaf]->cbeginValueAll(); node; ++node) {
        const Coord cell = node.getCoord();
        // Farther than a cell's diagonal from the surface, nothing crosses it.
        if (!(std::abs(static_cast<double>(*node)) < 2 * voxel)) continue;
        const auto distance = [&](int dx, int dy, int dz) {
          return static_cast<float>(static_cast<double>(values.getValue(cell.offsetBy(dx, dy, dz))) / voxel);
        };
        SurfacePlace place{.cell = cell};
        if (const std::optional<Vec3d> crossing = crossingIn(values, cell)) {
          place.at = *crossing;
          place.normal = slopeAt(place.at);
        } else if (isBesideThinPart(distance)) {
          place.normal = slopeAt(cell.asVec3d());
          if (!place.normal.normalize(0)) continue;
          place.at = cell.asVec3d() - place.normal * (static_cast<double>(*node) / voxel);
        } else {
          continue;
        }
        if (!place.normal.normalize(0)) continue;
        Vec3d at = thickness.tau->worldToIndex(phi.indexToWorld(place.at));
        for (int axis = 0; axis < 3; ++axis)
          at[axis] = std::clamp<double>(at[axis], known.min()[axis], known.max()[axis]);
        place.thickness = static_cast<double>(Sampler::sample(tau, at)) / voxel;
        found[leaf].push_back(place);
      }
    }
  });
  std::vector<SurfacePlace> places;
  for (const std::vector<SurfacePlace>& some : found) places.insert(places.end(), some.begin(), some.end());
  // The order must not depend on where the leaves of the tree begin, so that a target that lies elsewhere has the same.
  std::sort(places.begin(), places.end(), [](const auto& a, const auto& b) { return a.cell < b.cell; });
  return places;
}

/// Chooses places such that no two of them are nearer than the spacing, and none is farther from one.
/// @param spacing  of a place
template <class Spacing>
std::vector<std::size_t> spacedPlaces(const std::vector<SurfacePlace>& places, const Spacing& spacing) {
  std::vector<std::size_t> order(places.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [](std::size_t a, std::size_t b) { return std::pair(mixedBits(a), a) < std::pair(mixedBits(b), b); });
  PointCells all(1, Vec3d(0));
  for (const SurfacePlace& place : places) all.add(place.at);
  std::vector<bool> covered(places.size());
  std::vector<std::size_t> chosen;
  for (const std::size_t i : order) {
    if (covered[i]) continue;
    chosen.push_back(i);
    all.forEachWithin(places[i].at, spacing(i), [&](std::uint32_t j, double) {
      if (places[i].normal.dot(places[j].normal) > 0) covered[j] = true;
      return true;
    });
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace

GrainSurface grainSurface(const FloatGrid& phi, const LocalThickness& thickness, Monitor& monitor) {
  constexpr double kShare = 1. / 3;     // of the thickness, from point to point
  constexpr double kLeast = 1;          // voxels
  constexpr std::size_t kMost = 40000;  // points
  constexpr double kReach = 1.1;        // of the sum of two spacings, within which points are neighbours
  constexpr double kSameSide = 0.3;     // the cosine of two normals
  const double voxel = phi.voxelSize()[0];
  const std::vector<SurfacePlace> places = surfacePlaces(phi, thickness, monitor);
  if (places.empty()) throw DataError("the target has no surface along which a texture could lie");
  double wider = 1;
  std::vector<std::size_t> chosen;
  const auto spacing = [&](std::size_t i) { return wider * std::max(kShare * places[i].thickness, kLeast); };
  for (;;) {
    monitor.throwIfCancelled();
    chosen = spacedPlaces(places, spacing);
    if (chosen.size() <= kMost) break;
    constexpr double kStep = 1.05;
    wider *= kStep * std::sqrt(static_cast<double>(chosen.size()) / static_cast<double>(kMost));
  }
  std::vector<Point> positions, normals;
  std::vector<double> spacings, thicknesses;
  std::vector<double> sorted;
  for (const std::size_t i : chosen) sorted.push_back(spacing(i));
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
  PointCells cells(2 * kReach * sorted[sorted.size() / 2], Vec3d(0));
  for (const std::size_t i : chosen) {
    cells.add(places[i].at);
    positions.push_back(pointOf(phi.indexToWorld(places[i].at)));
    normals.push_back(pointOf(places[i].normal));
    spacings.push_back(voxel * spacing(i));
    thicknesses.push_back(voxel * places[i].thickness);
  }
  std::vector<std::vector<julia::SurfaceEdge>> parts(chosen.size());
  inParallel(chosen.size(), 64, monitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i != end; ++i) {
      const SurfacePlace& here = places[chosen[i]];
      const double own = spacing(chosen[i]);
      cells.forEachWithin(here.at, 2 * kReach * own, [&](std::uint32_t j, double squared) {
        const double other = spacing(chosen[j]), reach = kReach * (own + other);
        // Each pair is found from its wider point.
        if (std::pair(other, std::size_t{j}) >= std::pair(own, i) || squared >= reach * reach) return true;
        const SurfacePlace& there = places[chosen[j]];
        if (here.normal.dot(there.normal) > kSameSide) parts[i].push_back({static_cast<std::uint32_t>(i), j});
        return true;
      });
      std::sort(parts[i].begin(), parts[i].end(), [](const auto& a, const auto& b) { return a.to < b.to; });
    }
  });
  std::vector<julia::SurfaceEdge> edges;
  for (const auto& part : parts) edges.insert(edges.end(), part.begin(), part.end());
  return {julia::SurfaceGraph(std::move(positions), std::move(normals), std::move(spacings), std::move(edges)),
          std::move(thicknesses), voxel};
}

}  // namespace vdbtools
