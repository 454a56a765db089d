// SPDX-License-Identifier: Apache-2.0
#include "search/surface_distance.h"

#include "base/in_parallel.h"

#include <openvdb/math/Proximity.h>

namespace vdbtools {

double squaredDistance(const openvdb::Vec3d& position, const TriangleCorners& triangle) {
  openvdb::Vec3d weights;
  return (position -
          openvdb::math::closestPointOnTriangleToPoint(triangle[0], triangle[1], triangle[2], position, weights))
      .lengthSqr();
}

std::vector<FarPlace> placesFartherThan(double limit, const Mesh& mesh, const Mesh& surface,
                                        const SurfaceSearch& search, const Monitor& monitor) {
  constexpr std::size_t kGrain = 1024;
  constexpr int kMostHalvings = 22;  // the sides of a piece are then below 1/1000 of the triangle's
  const NearProof proof(limit, surface, search, kMostHalvings);
  const auto nearby = [](const openvdb::Vec3d&, std::optional<std::uint32_t> last) { return last; };
  std::vector<std::optional<openvdb::Vec3d>> found(mesh.triangles.size());
  inParallel(found.size(), kGrain, monitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const openvdb::Vec3I& t = mesh.triangles[i];
      found[i] = proof.farPlace({mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]}, nearby);
    }
  });
  std::vector<FarPlace> places;
  for (std::size_t i = 0; i < found.size(); ++i)
    if (found[i]) places.push_back({static_cast<std::uint32_t>(i), *found[i]});
  return places;
}

}  // namespace vdbtools
