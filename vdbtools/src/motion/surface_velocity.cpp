// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/motion/surface_velocity.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace vdbtools {

using openvdb::Vec3d;

SurfaceVelocity::SurfaceVelocity(const Mesh& now, std::span<const SurfaceAt> moments, MotionDepth depth) {
  for (const SurfaceAt& moment : moments) {
    if (moment.seconds == 0) continue;
    Side& side = mSides.emplace_back(Side{.seconds = moment.seconds});
    // What is exactly the same has the velocity 0 without rounding.
    if (moment.mesh->points != now.points || moment.mesh->triangles != now.triangles)
      side.motion = std::make_unique<const SurfaceMotion>(now, *moment.mesh, depth, moment.name);
  }
}

SurfaceVelocity::~SurfaceVelocity() = default;

std::vector<Vec3d> SurfaceVelocity::at(std::span<const Vec3d> points) const {
  std::vector<Vec3d> result(points.size(), Vec3d(0));
  const SurfaceMotion* search = nullptr;
  for (const Side& side : mSides)
    if (side.motion && !search) search = side.motion.get();
  if (!search) return result;
  const double seconds = mSides.back().seconds - (mSides.size() > 1 ? mSides.front().seconds : 0);
  std::optional<std::uint32_t> hint;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3d& x = points[i];
    // All motions begin at the same triangles, so that one search is enough.
    hint = search->carry(x, hint).hint;
    const auto placeAt = [&](const Side& side) { return side.motion ? side.motion->carryBy(*hint, x).at : x; };
    const Vec3d from = mSides.size() > 1 ? placeAt(mSides.front()) : x;
    result[i] = (placeAt(mSides.back()) - from) / seconds;
  }
  return result;
}

double SurfaceVelocity::frame() const {
  double longest = 0;
  for (const Side& side : mSides) longest = std::max(longest, std::abs(side.seconds));
  return longest;
}

}  // namespace vdbtools
