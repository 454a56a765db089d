// SPDX-License-Identifier: Apache-2.0
// The nearest point of a mesh, against all of its triangles one by one.
#include "search/surface_search.h"
#include "support/test_meshes.h"

#include <openvdb/math/Proximity.h>

#include <gtest/gtest.h>

#include <random>

namespace {

using namespace test_meshes;
using vdbtools::SurfacePoint;
using vdbtools::SurfaceSearch;

double distanceByOpenVdb(const Mesh& mesh, const Vec3d& position) {
  double least = std::numeric_limits<double>::infinity();
  for (const Vec3I& t : mesh.triangles) {
    Vec3d weights;
    const Vec3d nearest = openvdb::math::closestPointOnTriangleToPoint(mesh.points[t[0]], mesh.points[t[1]],
                                                                       mesh.points[t[2]], position, weights);
    least = std::min(least, (nearest - position).length());
  }
  return least;
}

TEST(SurfaceSearch, FindsTheNearestPoint) {
  const Mesh meshes[] = {makeSphere(3, 3), makeSoup(makeSphere(2, 2), 0.5), makeCube(4),
                         withoutTriangles(makeSphere(3, 2), [](const Vec3d& p) { return p[0] > 0; })};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-6, 6);
  for (const Mesh& mesh : meshes) {
    const SurfaceSearch search(mesh.points, mesh.triangles);
    std::uint32_t hint = 0;
    for (int i = 0; i < 500; ++i) {
      const Vec3d position(place(random), place(random), place(random));
      const std::optional<SurfacePoint> found = search.nearest(position);
      ASSERT_TRUE(found);
      const double distance = distanceByOpenVdb(mesh, position);
      EXPECT_NEAR(found->distance, distance, 1e-12);
      Vec3d point(0);
      double sum = 0;
      for (int c = 0; c < 3; ++c) {
        point += found->weights[c] * mesh.points[mesh.triangles[found->triangle][c]];
        sum += found->weights[c];
      }
      EXPECT_NEAR(sum, 1, 1e-12);
      EXPECT_NEAR((point - position).length(), distance, 1e-12);
      // A hint changes nothing, wherever it is.
      const std::optional<SurfacePoint> hinted = search.nearest(position, 100, hint);
      ASSERT_TRUE(hinted);
      EXPECT_EQ(hinted->triangle, found->triangle);
      hint = (hint * 31 + 17) % static_cast<std::uint32_t>(mesh.triangles.size());
      EXPECT_FALSE(search.nearest(position, distance * 0.999 - 1e-9));
      EXPECT_TRUE(search.nearest(position, distance * 1.001 + 1e-9));
    }
  }
}

TEST(SurfaceSearch, TakesTrianglesWithoutArea) {
  Mesh mesh = makeCube(4);
  mesh.triangles.insert(mesh.triangles.begin(), {Vec3I(0, 0, 0), Vec3I(0, 1, 1)});
  const SurfaceSearch search(mesh.points, mesh.triangles);
  EXPECT_NEAR(search.nearest(Vec3d(1, 0.5, 3))->distance, 1, 1e-12);
  EXPECT_FALSE(SurfaceSearch({}, {}).nearest(Vec3d(0)));
}

}  // namespace
