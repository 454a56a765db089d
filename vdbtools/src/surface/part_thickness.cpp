// SPDX-License-Identifier: Apache-2.0
#include "surface/part_thickness.h"

#include "base/counter_random.h"
#include "base/in_parallel.h"
#include "distance/distance_band.h"
#include "distance/mesh_conversion.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace vdbtools {

using openvdb::Vec3d;

namespace {

/// Half the diagonal of a voxel of size 1.
constexpr double kHalfDiagonal = 0.8661;

double voxelFor(const Mesh& mesh, double thickness) {
  constexpr double kVoxelsAcross = 5, kMostVoxels = 600;
  const Vec3d extents = boundingBox(mesh).extents();
  return std::max(thickness / kVoxelsAcross, std::max({extents[0], extents[1], extents[2]}) / kMostVoxels);
}

openvdb::FloatGrid::ConstPtr distancesInside(const std::vector<Vec3d>& points, const Mesh& mesh, double thickness,
                                             double voxel, Monitor& monitor) {
  constexpr double kBand = 3;
  return convert(points, mesh.triangles,
                 {.voxelSize = voxel, .exteriorBandWidth = kBand, .interiorBandWidth = thickness / 2 / voxel + kBand},
                 monitor);
}

}  // namespace

PartThickness::PartThickness(const Mesh& mesh, double thickness, std::optional<double> floor, Monitor& monitor)
    : mThickness(thickness),
      mFloor(floor),
      mVoxel(voxelFor(mesh, thickness)),
      mPoints(toIndexSpace(mesh.points, mVoxel)),
      mTree(mPoints, mesh.triangles),
      mDistances(distancesInside(mPoints, mesh, thickness, mVoxel, monitor)) {}

PartThickness::Depth PartThickness::depthAt(const Vec3d& p) const {
  const auto at = mTree.nearest(p / mVoxel, std::numeric_limits<double>::infinity());
  if (!at) return {0, p};
  Depth depth{at->distance * mVoxel, at->point * mVoxel};
  if (mFloor && p[2] - *mFloor < depth.distance) depth = {std::max(0.0, p[2] - *mFloor), Vec3d(p[0], p[1], *mFloor)};
  return depth;
}

bool PartThickness::hasDeepNode(const Vec3d& point, const Vec3d& normal, double radius) const {
  // The nodes hold distances in floats.
  const double enough = radius + 1e-4 * mVoxel, reach = 2 * radius;
  const auto accessor = mDistances->getConstAccessor();
  for (double deep = radius + mVoxel / 2; deep < reach; deep += mVoxel) {
    const openvdb::Coord node = openvdb::Coord::round((point - normal * deep) / mVoxel);
    const Vec3d centre = node.asVec3d() * mVoxel;
    if (-static_cast<double>(accessor.getValue(node)) >= enough && (centre - point).lengthSqr() <= reach * reach &&
        (!mFloor || centre[2] - *mFloor >= enough))
      return true;
  }
  return false;
}

InnerBall PartThickness::ballNear(const Vec3d& point, const Vec3d& normal, double reach, double enough) const {
  // Shrinks the ball that touches the surface at the point until nothing else reaches into it [Ma, Bae and Choi, 3D
  // medial axis point approximation using nearest neighbors and the normal field, The Visual Computer 28, 2012].
  constexpr double kTouches = 0.999;
  constexpr int kMostShrinks = 24;
  const double least = enough / 64;
  double radius = std::min(enough, reach);
  InnerBall best{point, 0};
  Vec3d nearest = point;
  for (int i = 0; i < kMostShrinks; ++i) {
    const Vec3d centre = point - normal * radius;
    const Depth depth = depthAt(centre);
    const Vec3d away = point - depth.nearest;
    const double along = normal.dot(away);
    // Below the minimum radius the corner of an edge may be in the way, and the centre is inside nevertheless.
    if (depth.distance >= kTouches * radius || (radius <= least && depth.distance >= radius / 4)) {
      best = {centre, depth.distance};
      nearest = depth.nearest;
      break;
    }
    const double next = along > 0 ? away.lengthSqr() / (2 * along) : 0;
    radius = std::clamp(next, radius / 4, radius * kTouches);
    if (radius < least / 64) return best;
  }
  return climbed(best, nearest, point, reach, enough);
}

InnerBall PartThickness::climbed(InnerBall best, Vec3d nearest, const Vec3d& point, double reach, double enough) const {
  // Moves away from the nearest surface, or between the two that were nearest alternately. A step is shorter than the
  // distance to the surface, so it never crosses it.
  double step = enough / 2;
  Vec3d last(0);
  constexpr int kMostSteps = 40;
  for (int i = 0; i < kMostSteps && best.radius > 0 && best.radius < enough && step > enough / 50; ++i) {
    Vec3d away = best.centre - nearest;
    away.normalize(0);
    Vec3d between = away + last, inward = best.centre - point;
    between.normalize(0), inward.normalize(0);
    InnerBall better = best;
    Vec3d betterNearest = nearest;
    for (const Vec3d& direction : {away, between, inward}) {
      Vec3d centre = best.centre + direction * std::min(step, 0.9 * best.radius);
      const Vec3d from = centre - point;
      if (from.length() > reach) centre = point + from * (reach / from.length());
      const Depth depth = depthAt(centre);
      if (depth.distance <= better.radius) continue;
      better = {centre, depth.distance};
      betterNearest = depth.nearest;
    }
    last = away;
    if (better.radius < best.radius + step / 50) step /= 2;
    best = better;
    nearest = betterNearest;
  }
  return best;
}

InnerBall PartThickness::deepestNode(const Vec3d& point, double reach) const {
  const double voxel = mVoxel, far = reach + kHalfDiagonal * voxel;
  const auto accessor = mDistances->getConstAccessor();
  const auto steps = static_cast<int>(std::ceil(far / voxel));
  const openvdb::Coord middle = openvdb::Coord::round(point / voxel);
  InnerBall best{point, 0};
  for (int x = -steps; x <= steps; ++x)
    for (int y = -steps; y <= steps; ++y)
      for (int z = -steps; z <= steps; ++z) {
        const openvdb::Coord node = middle.offsetBy(x, y, z);
        const Vec3d centre = node.asVec3d() * voxel;
        if ((centre - point).lengthSqr() > far * far) continue;
        double depth = -static_cast<double>(accessor.getValue(node));
        if (mFloor) depth = std::min(depth, centre[2] - *mFloor);
        if (depth > best.radius) best = {centre, depth};
      }
  return best;
}

InnerBall PartThickness::climbedFrom(const InnerBall& node, const Vec3d& point, double reach, double enough) const {
  Vec3d centre = node.centre;
  const Vec3d from = centre - point;
  if (from.length() > reach) centre = point + from * (reach / from.length());
  const Depth depth = depthAt(centre);
  return climbed({centre, depth.distance}, depth.nearest, point, reach, enough);
}

InnerBall PartThickness::deepestBall(const Vec3d& point, const Vec3d& normal, double reach, double enough) const {
  const InnerBall node = deepestNode(point, reach);
  // A node that is barely inside is not a useful start.
  return node.radius < enough / 20 ? ballNear(point, normal, reach, enough) : climbedFrom(node, point, reach, enough);
}

bool PartThickness::isThick(const Vec3d& point, const Vec3d& normal, double thickness) const {
  const double radius = thickness / 2;
  if (hasDeepNode(point, normal, radius)) return true;
  if (thickness <= mThickness) {
    const InnerBall node = deepestNode(point, thickness);
    if (node.radius < radius - kHalfDiagonal * mVoxel) return false;
    if (climbedFrom(node, point, thickness, radius).radius >= radius) return true;
  }
  return ballNear(point, normal, thickness, radius).radius >= radius;
}

ThinPlaces findThinPlaces(const Mesh& mesh, double thickness, double rounding, std::size_t most, Monitor& monitor) {
  const PartThickness part(mesh, thickness, {}, monitor);
  constexpr std::size_t kGrain = 256;
  // Random choice takes an even share of all parts of the mesh, whatever the order of its points.
  const double share = static_cast<double>(most) / static_cast<double>(std::max<std::size_t>(1, mesh.points.size()));
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    if (randomUnit(1, 0, i) < share) chosen.push_back(i);
  // From thin to thick: a needle on a ball is thin, although there is a larger ball nearby.
  constexpr double kStep = 1.05;
  const double nearly = thickness * (1 - rounding);
  std::vector<double> found(chosen.size());
  // The minimum thickness so far. A place that is known to be at least that thick cannot change it, so its search ends
  // there.
  std::atomic<double> least{2 * thickness};
  inParallel(found.size(), kGrain, monitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3d point = mesh.points[chosen[i]], normal(mesh.normals[chosen[i]]);
      double level = thickness;
      if (part.isThick(point, normal, level)) {
        while (level < least.load() && part.isThick(point, normal, level * kStep)) level *= kStep;
      } else {
        level = nearly;
        while (level > thickness / 100 && !part.isThick(point, normal, level)) level /= kStep;
      }
      found[i] = level;
      for (double other = least.load(); level < other && !least.compare_exchange_weak(other, level);) {
      }
    }
  });
  ThinPlaces result{.places = chosen.size()};
  result.thinnest = 2 * thickness;
  for (const double level : found) {
    result.thinnest = std::min(result.thinnest, level);
    result.thin += level < nearly;
  }
  return result;
}

}  // namespace vdbtools
