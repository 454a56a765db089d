// SPDX-License-Identifier: Apache-2.0
// The nearest point of a triangle, also of one without an area, against other points of it.
#include "search/triangle_point.h"
#include "support/triangle_edges.h"

#include <openvdb/math/Proximity.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace {

using openvdb::Vec3d;
using vdbtools::nearestOnTriangle;

class NearestOnTriangle : public testing::Test {
 protected:
  double number() { return mUnit(mRandom); }  // from -1 to 1
  Vec3d direction() {
    Vec3d d;
    for (int axis = 0; axis < 3; ++axis) d[axis] = number();
    return d;
  }

 private:
  std::mt19937 mRandom{1};
  std::uniform_real_distribution<double> mUnit{-1, 1};
};

void expectItIsOn(const Vec3d (&corners)[3], const Vec3d& weights, const Vec3d& point) {
  EXPECT_NEAR(weights[0] + weights[1] + weights[2], 1, 1e-12);
  for (int k = 0; k < 3; ++k) {
    EXPECT_GE(weights[k], 0);
    EXPECT_NEAR(corners[0][k] * weights[0] + corners[1][k] * weights[1] + corners[2][k] * weights[2], point[k], 1e-10);
  }
}

// A triangle whose corners lie on a line is its edges.
TEST_F(NearestOnTriangle, OfATriangleWithoutAnAreaIsOnItsEdges) {
  int wrongOfOpenVdb = 0;
  for (int i = 0; i < 1000000; ++i) {
    const double size = std::pow(10.0, 1.5 * number());
    const Vec3d a = direction() * 30.0, b = direction() * size;
    const Vec3d corners[] = {a, a + b, i % 50 == 0 ? a : a + b * number()};
    const Vec3d position = direction() * 60.0;
    const double distance = test_meshes::distanceToEdges(corners, position), most = distance * (1 + 1e-12) + 1e-12;
    Vec3d weights;
    const Vec3d point = nearestOnTriangle(corners[0], corners[1], corners[2], position, weights);
    ASSERT_LE((point - position).length(), most);
    ASSERT_TRUE(vdbtools::isThin(corners[0], corners[1], corners[2]));
    if (i % 1000 == 0) expectItIsOn(corners, weights, point);
    const Vec3d simple =
        openvdb::math::closestPointOnTriangleToPoint(corners[0], corners[1], corners[2], position, weights);
    if (!((simple - position).length() <= most)) ++wrongOfOpenVdb;
  }
  EXPECT_GT(wrongOfOpenVdb, 0) << "these triangles are no test of it";
}

// Where isThin() is false, OpenVDB's function is used as it is.
TEST_F(NearestOnTriangle, IsThatOfOpenVdbUnlessTheTriangleIsThin) {
  int compared = 0;
  for (int i = 0; i < 200000; ++i) {
    const double size = std::pow(10.0, 1.5 * number()), width = size * std::pow(10.0, -6 * std::abs(number()));
    const Vec3d a = direction() * 30.0, b = direction() * size, along = b * number(), aside = direction() * width;
    const Vec3d c = a + along + aside, position = direction() * 60.0;
    if (vdbtools::isThin(a, a + b, c)) continue;
    ++compared;
    Vec3d weights;
    const double distance = (nearestOnTriangle(a, a + b, c, position, weights) - position).length();
    const double simple =
        (openvdb::math::closestPointOnTriangleToPoint(a, a + b, c, position, weights) - position).length();
    ASSERT_NEAR(simple, distance, 1e-5);
  }
  EXPECT_GT(compared, 100000);
}

TEST_F(NearestOnTriangle, NoOtherPointOfItIsNearer) {
  constexpr int kSteps = 12;
  for (int i = 0; i < 20000; ++i) {
    const double size = std::pow(10.0, 1.5 * number()), width = size * std::pow(10.0, -6 * std::abs(number()));
    const Vec3d a = direction() * 30.0, b = direction() * size;
    const Vec3d along = b * number(), aside = direction() * width;
    const Vec3d corners[] = {a, a + b, a + along + aside};
    const Vec3d position = i % 2 == 0 ? direction() * 60.0 : a + direction() * size;
    Vec3d weights;
    const Vec3d point = nearestOnTriangle(corners[0], corners[1], corners[2], position, weights);
    expectItIsOn(corners, weights, point);
    double least = std::numeric_limits<double>::infinity();
    for (int u = 0; u <= kSteps; ++u)
      for (int v = 0; u + v <= kSteps; ++v) {
        const Vec3d other = corners[0] + (corners[1] - corners[0]) * (u / double{kSteps}) +
                            (corners[2] - corners[0]) * (v / double{kSteps});
        least = std::min(least, (other - position).length());
      }
    ASSERT_LE((point - position).length(), least + 1e-10);
  }
}

}  // namespace
