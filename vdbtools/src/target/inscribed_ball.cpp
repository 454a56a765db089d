// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/target/inscribed_ball.h"

#include "vdbtools/base/errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3d;

// The search for the centre ends at this step size, in voxels.
constexpr double kLastStep = 1e-4;

/// The score of a ball: its radius minus the pull toward the preferred point. All lengths are in voxels.
struct Score {
  Vec3d preferred;
  double operator()(const Vec3d& centre, double radius) const {
    return radius - kInscribedBallPull * (centre - preferred).length();
  }
};

/// The node with the best score; of equal ones the first in the order of coordinates.
Coord bestNode(const FloatGrid& phi, double voxel, const Score& score) {
  double best = -std::numeric_limits<double>::infinity();
  Coord found;
  for (auto value = phi.cbeginValueOn(); value; ++value) {
    if (!(*value < 0)) continue;
    const Coord node = value.getCoord();
    const double here = score(node.asVec3d(), -*value / voxel);
    if (here > best || (here == best && node < found)) {
      best = here;
      found = node;
    }
  }
  if (best == -std::numeric_limits<double>::infinity())
    throw DataError("the signed distance field is nowhere negative: it has no inside");
  return found;
}

/// Points of the surface within @a reach of @a centre, index space: nodes next to the surface, moved onto it along the
/// gradient of phi, which is accurate to second order.
std::vector<Vec3d> surfaceAbout(const FloatGrid& phi, double voxel, const Vec3d& centre, double reach) {
  std::vector<Vec3d> points;
  const auto accessor = phi.getConstAccessor();
  for (auto value = phi.cbeginValueOn(); value; ++value) {
    if (std::abs(*value) > voxel) continue;
    const Coord node = value.getCoord();
    if ((node.asVec3d() - centre).length() > reach) continue;
    Vec3d gradient;
    for (int axis = 0; axis < 3; ++axis) {
      Coord before = node, after = node;
      --before[axis], ++after[axis];
      gradient[axis] = (accessor.getValue(after) - accessor.getValue(before)) / 2;
    }
    const double squared = gradient.lengthSqr();
    // On a crease the gradient does not point to the surface.
    if (squared < 0.25 * voxel * voxel) continue;
    points.push_back(node.asVec3d() - gradient * (*value / squared));
  }
  return points;
}

}  // namespace

InscribedBall largestInscribedBall(const FloatGrid& phi, const Vec3d& preferred) {
  const double voxel = phi.voxelSize()[0];
  const Score score{phi.worldToIndex(preferred)};
  const Coord start = bestNode(phi, voxel, score);
  Vec3d centre = start.asVec3d();
  const double nodeRadius = -phi.tree().getValue(start) / voxel;
  // The centre moves by less than two voxels, so that no other points of the surface matter.
  constexpr double kMost = 2;
  const std::vector<Vec3d> surface = surfaceAbout(phi, voxel, centre, nodeRadius + 2 * kMost);
  const auto radiusAt = [&](const Vec3d& x) {
    double least = std::numeric_limits<double>::infinity();
    for (const Vec3d& point : surface) least = std::min(least, (point - x).lengthSqr());
    return std::sqrt(least);
  };
  if (surface.empty()) return {phi.indexToWorld(centre), nodeRadius * voxel};
  // Compass search: the radius is not smooth where the ball touches the surface at several points.
  double radius = radiusAt(centre), best = score(centre, radius);
  for (double step = 0.5; step > kLastStep;) {
    Vec3d next = centre;
    double nextRadius = radius, nextBest = best;
    for (int i = 0; i < 27; ++i) {
      const Vec3d direction = Coord(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1).asVec3d();
      const Vec3d candidate = centre + direction * step;
      if ((candidate - start.asVec3d()).length() > kMost) continue;
      const double there = radiusAt(candidate), value = score(candidate, there);
      if (value > nextBest) next = candidate, nextRadius = there, nextBest = value;
    }
    if (nextBest > best)
      centre = next, radius = nextRadius, best = nextBest;
    else
      step /= 2;
  }
  return {phi.indexToWorld(centre), radius * voxel};
}

}  // namespace vdbtools
