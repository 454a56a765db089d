// SPDX-License-Identifier: Apache-2.0
// Distances to parts that run into each other, beside the exact ones to their union.
#include "distance/outer_surface.h"
#include "support/mesh_laws.h"
#include "support/test_meshes.h"

#include "vdbtools/distance/mesh_to_sdf.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace {

using namespace test_meshes;
using openvdb::BBoxd;
using openvdb::FloatGrid;
using vdbtools::HiddenPlace;
using vdbtools::MeshToSdfOptions;
using vdbtools::Monitor;
using vdbtools::PartCounts;

class OuterSurface : public testing::Test {
 protected:
  static void SetUpTestSuite() { openvdb::initialize(); }

  std::optional<vdbtools::OuterSurface> outerSurfaceOf(const Mesh& mesh, const std::vector<HiddenPlace>& hidden) {
    return vdbtools::outerSurface(vdbtools::TriangleTree(mesh.points, mesh.triangles), hidden, monitor);
  }

  /// Expects that a face in which two parts touch is no wall. @param area  of the face
  void expectNoWall(const Mesh& a, const Mesh& b, double area, const PartCounts& parts) {
    const auto surface = outerSurfaceOf(merged(a, b), {});
    ASSERT_TRUE(surface) << area;
    EXPECT_EQ(surface->parts, parts);
    EXPECT_NEAR(mesh_laws::area({.points = surface->points, .triangles = surface->triangles}),
                mesh_laws::area(a) + mesh_laws::area(b) - 2 * area, 1e-3);
  }
  Monitor monitor;
};

/// The middles of all triangles.
std::vector<HiddenPlace> placesOf(const Mesh& mesh) {
  std::vector<HiddenPlace> places;
  for (const openvdb::Vec3I& t : mesh.triangles)
    places.push_back(
        {static_cast<std::uint32_t>(places.size()), (mesh.points[t[0]] + mesh.points[t[1]] + mesh.points[t[2]]) / 3.0});
  return places;
}

double distanceTo(const BBoxd& box, const Vec3d& p) {
  Vec3d beyond;
  for (int axis = 0; axis < 3; ++axis)
    beyond[axis] = std::max({box.min()[axis] - p[axis], 0.0, p[axis] - box.max()[axis]});
  return beyond.length();
}

/// The signed distance to a union of boxes. Their faces cut space into boxes that lie wholly inside or outside.
class Boxes {
 public:
  explicit Boxes(std::vector<BBoxd> boxes) : mBoxes(std::move(boxes)) {
    std::vector<double> cuts[3];
    for (int axis = 0; axis < 3; ++axis) {
      cuts[axis] = {-1e3, 1e3};
      for (const BBoxd& box : mBoxes) cuts[axis].insert(cuts[axis].end(), {box.min()[axis], box.max()[axis]});
      std::sort(cuts[axis].begin(), cuts[axis].end());
    }
    for (std::size_t x = 0; x + 1 < cuts[0].size(); ++x)
      for (std::size_t y = 0; y + 1 < cuts[1].size(); ++y)
        for (std::size_t z = 0; z + 1 < cuts[2].size(); ++z) {
          const BBoxd cell(Vec3d(cuts[0][x], cuts[1][y], cuts[2][z]),
                           Vec3d(cuts[0][x + 1], cuts[1][y + 1], cuts[2][z + 1]));
          const Vec3d middle = cell.getCenter();
          const bool flat = cell.extents()[0] == 0 || cell.extents()[1] == 0 || cell.extents()[2] == 0;
          if (!flat && std::none_of(mBoxes.begin(), mBoxes.end(),
                                    [&](const BBoxd& box) { return distanceTo(box, middle) == 0; }))
            mOutside.push_back(cell);
        }
  }

  double distance(const Vec3d& p) const {
    const double outside = least(mBoxes, p);
    return outside > 0 ? outside : -least(mOutside, p);
  }
  Mesh mesh() const {
    Mesh mesh;
    for (const BBoxd& box : mBoxes) mesh = merged(mesh, makeBox(box.min(), box.max()));
    return mesh;
  }

 private:
  static double least(const std::vector<BBoxd>& boxes, const Vec3d& p) {
    double least = std::numeric_limits<double>::infinity();
    for (const BBoxd& box : boxes) least = std::min(least, distanceTo(box, p));
    return least;
  }

  std::vector<BBoxd> mBoxes, mOutside;
};

/// A turn by which no face is parallel to the lattice.
Vec3d turned(const Vec3d& p) {
  const double c = std::cos(0.7), s = std::sin(0.7), d = std::cos(0.4), e = std::sin(0.4);
  const Vec3d once(c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]);
  return {once[0], d * once[1] - e * once[2], e * once[1] + d * once[2]};
}
Vec3d turnedBack(const Vec3d& p) {
  const double c = std::cos(0.7), s = std::sin(0.7), d = std::cos(0.4), e = std::sin(0.4);
  const Vec3d once(p[0], d * p[1] + e * p[2], -e * p[1] + d * p[2]);
  return {c * once[0] + s * once[1], -s * once[0] + c * once[1], once[2]};
}
Mesh turned(Mesh mesh) {
  for (Vec3d& p : mesh.points) p = turned(p);
  return mesh;
}

constexpr double kCell = 0.04;
const MeshToSdfOptions kWhole{
    .voxelSize = kCell, .exteriorBandWidth = 8, .interiorBandWidth = std::numeric_limits<double>::infinity()};

/// By how much the distances are off, voxels. Their signs are a flood's: in the corner of a crease, nodes nearer to the
/// surface than half a voxel may be on either side.
double worst(const FloatGrid& phi, const std::function<double(const Vec3d&)>& exact) {
  double most = 0;
  for (auto value = phi.cbeginValueOn(); value; ++value) {
    const double found = static_cast<double>(*value) / kCell,
                 wanted = exact(phi.indexToWorld(value.getCoord())) / kCell;
    const bool sameSide = (found < 0) == (wanted < 0) || std::abs(wanted) < 0.5;
    most = std::max(most, std::abs(sameSide ? std::abs(found) - std::abs(wanted) : found - wanted));
  }
  return most;
}
double worst(const FloatGrid& phi, const Boxes& boxes) {
  return worst(phi, [&](const Vec3d& p) { return boxes.distance(turnedBack(p)); });
}

BBoxd box(double x, double y, double z, double X, double Y, double Z) { return {Vec3d(x, y, z), Vec3d(X, Y, Z)}; }

struct Arrangement {
  const char* name;
  std::vector<BBoxd> boxes;
  PartCounts parts;  ///< those that share an edge are one
};

const std::vector<Arrangement>& arrangements() {
  static const std::vector<Arrangement> all = {
      {"two that overlap", {box(0, 0, 0, 1, 1, 1), box(0.6, 0.3, 0.4, 1.7, 0.8, 0.9)}, {.intersecting = 2}},
      {"a thin one through another", {box(0, 0, 0, 1, 1, 1), box(-0.5, 0.4, 0.4, 1.5, 0.5, 0.5)}, {.intersecting = 2}},
      {"one within another", {box(0, 0, 0, 1, 1, 1), box(0.1, 0.2, 0.3, 0.5, 0.6, 0.95)}, {.inner = 1}},
      {"two that touch", {box(0, 0, 0, 1, 1, 1), box(1, 0.2, 0.2, 1.7, 0.8, 0.8)}, {.intersecting = 2}},
      {"faces that coincide",
       {box(0, 0, 0, 1, 1, 1), box(1, 0, 0, 2, 1, 1), box(0.5, 0, 0.5, 1.5, 1, 1.5)},
       {.intersecting = 2}},
      {"the same twice", {box(0, 0, 0, 1, 1, 1), box(0, 0, 0, 1, 1, 1)}, {}},
      {"one within another, at a corner of both",
       {box(0, 0, 0, 1, 1, 1), box(0, 0, 0, 0.6, 0.7, 0.5)},
       {.intersecting = 2}},
      {"one through another, from a corner of both",
       {box(0, 0, 0, 1, 1, 1), box(0, 0, 0, 1.5, 0.4, 0.3)},
       {.intersecting = 2}},
      {"two that meet in a corner alone", {box(0, 0, 0, 1, 1, 1), box(1, 1, 1, 1.6, 1.7, 1.5)}, {}},
      {"a chair",
       {box(0, 0, 0.9, 1, 1, 1.04), box(0, 0.88, 0.9, 1, 1, 2), box(0, 0, 0, 0.12, 0.12, 1),
        box(0.88, 0, 0, 1, 0.12, 1), box(0, 0.88, 0, 0.12, 1, 1), box(0.88, 0.88, 0, 1, 1, 1)},
       {.intersecting = 5}}};
  return all;
}

// Promise of design.md: "Parts that run into each other" are "one shape": "the outer surface of their union" counts;
//   where none do, "nothing changes, to the bit"
TEST_F(OuterSurface, DistancesAreThoseOfTheUnion) {
  for (const auto& [name, given, parts] : arrangements()) {
    const Boxes boxes(given);
    const Mesh mesh = turned(boxes.mesh());
    PartCounts found;
    EXPECT_LT(worst(*meshToSdf(mesh, kWhole, monitor, &found), boxes), 1e-3) << name;
    EXPECT_EQ(found, parts) << name;
    EXPECT_LT(worst(*meshToSdf(makeSoup(mesh, 0), kWhole, monitor), boxes), 1e-3) << name << ", a soup";
    EXPECT_LT(worst(*meshToSdf(flipped(mesh), kWhole, monitor), boxes), 1e-3) << name << ", inside out";
  }
}

// Promise: "Parts that run into each ..."
TEST_F(OuterSurface, EachPartMayBeOrientedEitherWay) {
  const Boxes boxes(arrangements().front().boxes);
  const Mesh first = makeBox(Vec3d(0), Vec3d(1)), second = makeBox(Vec3d(0.6, 0.3, 0.4), Vec3d(1.7, 0.8, 0.9));
  EXPECT_LT(worst(*meshToSdf(turned(merged(first, flipped(second))), kWhole, monitor), boxes), 1e-3);
  // Neither way: parity says what is inside.
  Mesh mixed = second;
  std::swap(mixed.triangles[3][1], mixed.triangles[3][2]);
  EXPECT_LT(worst(*meshToSdf(turned(merged(first, mixed)), kWhole, monitor), boxes), 1e-3);
}

// Promise: "Parts that run into each ..."
TEST_F(OuterSurface, OnePartMayCrossItself) {
  // A square tube that comes back and runs through where it began.
  const double r = 0.15;
  const std::vector<Vec3d> path = {{0, 0, 0}, {2, 0, 0}, {2, 1.5, 0}, {1, 1.5, 0}, {1, -1, 0}};
  Mesh tube;
  std::vector<BBoxd> boxes;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Vec3d into = i > 0 ? (path[i] - path[i - 1]).unit() : Vec3d(0),
                outOf = i + 1 < path.size() ? (path[i + 1] - path[i]).unit() : Vec3d(0);
    const auto left = [](const Vec3d& d) { return Vec3d(-d[1], d[0], 0); };
    const Vec3d side = i == 0 ? left(outOf) : i + 1 == path.size() ? left(into) : left(into) + left(outOf);
    for (const auto& [across, up] : {std::pair{1, 1}, {-1, 1}, {-1, -1}, {1, -1}})
      tube.points.push_back(path[i] + side * (r * across) + Vec3d(0, 0, r * up));
    if (i == 0) continue;
    const auto first = static_cast<std::uint32_t>(4 * (i - 1));
    for (std::uint32_t k = 0; k < 4; ++k) {
      const std::uint32_t a = first + k, b = first + (k + 1) % 4;
      tube.triangles.insert(tube.triangles.end(), {Vec3I(a, a + 4, b), Vec3I(b, a + 4, b + 4)});
    }
    const bool lastBend = i + 1 == path.size();
    BBoxd straight(openvdb::math::minComponent(path[i - 1], path[i]),
                   openvdb::math::maxComponent(path[i - 1], path[i]));
    straight.expand(r);
    // The ends are flat.
    if (i == 1) straight.min()[0] = path[0][0];
    if (lastBend) straight.min()[1] = path.back()[1];
    boxes.push_back(straight);
  }
  const std::uint32_t e = 4 * static_cast<std::uint32_t>(path.size() - 1);
  tube.triangles.insert(tube.triangles.end(),
                        {Vec3I(0, 1, 2), Vec3I(0, 2, 3), Vec3I(e, e + 2, e + 1), Vec3I(e, e + 3, e + 2)});
  ASSERT_TRUE(reportMesh(tube).closed());
  PartCounts found;
  EXPECT_LT(worst(*meshToSdf(turned(tube), kWhole, monitor, &found), Boxes(boxes)), 1e-3);
  EXPECT_EQ(found, PartCounts{.intersecting = 1});
}

/// A closed tube in the form of an eight, which crosses itself in the middle.
class Eight {
 public:
  static constexpr double kRadius = 6;

  static Mesh mesh() {
    constexpr std::uint32_t kAlong = 240, kAround = 40;
    Mesh mesh;
    for (std::uint32_t i = 0; i < kAlong; ++i) {
      const double t = i * 2 * M_PI / kAlong;
      const Vec3d side = Vec3d(-50 * std::cos(2 * t), 40 * std::cos(t), 0).unit() * kRadius, up(0, 0, kRadius);
      for (std::uint32_t k = 0; k < kAround; ++k) {
        const double turn = k * 2 * M_PI / kAround;
        mesh.points.push_back(at(t) + side * std::cos(turn) + up * std::sin(turn));
        const std::uint32_t a = i * kAround, b = (i + 1) % kAlong * kAround, next = (k + 1) % kAround;
        mesh.triangles.emplace_back(a + k, b + k, b + next);
        mesh.triangles.emplace_back(a + k, b + next, a + next);
      }
    }
    return mesh;
  }
  /// Whether a position is inside, and not just below the surface.
  static bool isDeep(const Vec3d& p) {
    double least = 1e9;
    for (int i = 0; i < 2000; ++i) least = std::min(least, (at(i * 2 * M_PI / 2000) - p).length());
    return least < 0.95 * kRadius;
  }

 private:
  static Vec3d at(double t) { return {40 * std::sin(t), 25 * std::sin(2 * t), 0}; }
};

TEST_F(OuterSurface, APartIsExaminedOnlyWhereItMayCrossItself) {
  const Mesh eight = Eight::mesh();
  std::vector<HiddenPlace> outer, inner;
  for (const HiddenPlace& place : placesOf(eight)) {
    if (Eight::isDeep(place.point)) inner.push_back(place);
    if (place.point.length() > 4 * Eight::kRadius) outer.push_back(place);
  }
  ASSERT_GT(inner.size(), 100U);
  outer.resize(100);
  // A groove may be too narrow for the lattice, but its walls are part of the surface.
  EXPECT_FALSE(outerSurfaceOf(eight, outer));
  outer.push_back(inner[inner.size() / 2]);
  const auto surface = outerSurfaceOf(eight, outer);
  ASSERT_TRUE(surface);
  EXPECT_EQ(surface->parts, PartCounts{.intersecting = 1});
  EXPECT_GT(surface->triangles.size(), eight.triangles.size() / 2);
  const Mesh left{.points = surface->points, .triangles = surface->triangles};
  for (const HiddenPlace& place : placesOf(left)) EXPECT_FALSE(Eight::isDeep(place.point)) << place.point;
}

// Promise: "Parts that run into each ..."
TEST_F(OuterSurface, AFaceInWhichPartsTouchIsNoWallHoweverSmallItIs) {
  const Mesh plate = makeBox({0, 0, 0}, {40, 8, 40});
  for (const double width : {0.1, 2.0, 20.0}) {
    const Mesh post = makeBox({17.3, 8, 16.1}, {17.3 + width, 30, 16.1 + width});
    expectNoWall(plate, post, width * width, {.intersecting = 2});
  }
}

// Promise: "Parts that run into each ..."
TEST_F(OuterSurface, SoIsAFaceWhoseCornersBothPartsHave) {
  for (const double width : {0.1, 2.0, 20.0}) {
    const Mesh lower = makeBox({0, 0, 0}, {width, 8, width}), upper = makeBox({0, 8, 0}, {width, 30, width});
    expectNoWall(lower, upper, width * width, {.intersecting = 1});
  }
}

// Promise: "Parts that run into each ..."
TEST_F(OuterSurface, BlocksThatShareAnEdgeAloneKeepTheirFaces) {
  const Mesh low = makeBox({0, 0, 0}, {5, 5, 5}), high = makeBox({5, 5, 0}, {10, 10, 5});
  EXPECT_FALSE(outerSurfaceOf(merged(low, high), {}));
}

// Promise: "Parts that run into each ..."
TEST_F(OuterSurface, BallsThatMeetHaveTheDistancesOfTheirUnion) {
  const double r = 0.7;
  const Vec3d a(0, 0, 0), b(0.9, 0.2, 0.1);
  const Vec3d way = b - a, along = way.unit();
  const double half = way.length() / 2, ring = std::sqrt(r * r - half * half);
  const auto exact = [&](const Vec3d& given) {
    const Vec3d p = given + Vec3d(1e-9, 2e-9, 3e-9);  // a node may be a centre
    const double da = (p - a).length() - r, db = (p - b).length() - r;
    if (da >= 0 || db >= 0)
      return std::min(da, db) >= 0 ? std::min(da, db) : [&] {
        // Within one of them: to its own sphere, or where that lies in the other one, to the circle that they share.
        const bool inFirst = da < 0;
        const Vec3d centre = inFirst ? a : b, onSphere = centre + (p - centre).unit() * r;
        if ((onSphere - (inFirst ? b : a)).length() >= r) return std::min(da, db);
        const Vec3d q = p - (a + b) * 0.5;
        const double x = q.dot(along), y = (q - along * x).length();
        return -std::hypot(x, y - ring);
      }();
    const Vec3d q = p - (a + b) * 0.5;
    const double x = q.dot(along), y = (q - along * x).length();
    double depth = std::hypot(x, y - ring);
    for (const auto& [centre, other] : {std::pair{a, b}, {b, a}}) {
      const Vec3d onSphere = centre + (p - centre).unit() * r;
      if ((onSphere - other).length() >= r) depth = std::min(depth, (p - onSphere).length());
    }
    return -depth;
  };
  const FloatGrid::Ptr phi = meshToSdf(merged(makeSphere(r, 5, a), makeSphere(r, 5, b)), kWhole, monitor);
  // The spheres' triangles lie within them by 0.0007.
  EXPECT_LT(worst(*phi, exact), 0.03);
}

// Promise: "Parts that run into each ..."
TEST_F(OuterSurface, WhatDoesNotMeetIsLeftAsItIs) {
  const Mesh apart = merged(makeSphere(5, 3), makeBox(Vec3d(3.2, 3.2, 3.2), Vec3d(8, 8, 9))), one = makeSphere(9, 4);
  for (const Mesh& mesh : {apart, one, withoutTriangles(one, [](const Vec3d& p) { return p[2] > 8; })})
    EXPECT_FALSE(outerSurfaceOf(mesh, placesOf(mesh)));
  if (hasBunny()) {
    const Mesh mesh = transformed(bunny(), 50, Vec3d(0));
    EXPECT_FALSE(outerSurfaceOf(mesh, {}));
  }
}

// Promise: "Parts that run into each ..."
TEST_F(OuterSurface, AHollowBallIsInsideAsBeforeAndItsInnerWallIsNotSeen) {
  const Mesh ball = makeSphere(1, 5);
  for (const double inner : {0.5, 0.95}) {
    for (const Mesh& wall : {makeSphere(inner, 4), flipped(makeSphere(inner, 4))}) {
      const FloatGrid::Ptr hollow = meshToSdf(merged(ball, wall), kWhole, monitor),
                           solid = meshToSdf(ball, kWhole, monitor);
      for (auto value = solid->cbeginValueOn(); value; ++value)
        ASSERT_NEAR(hollow->tree().getValue(value.getCoord()), *value, 1e-5 * kCell) << inner;
    }
  }
}

// Promise: "Parts that run into each ..."
TEST_F(OuterSurface, ACupStaysHollow) {
  // Four walls and a floor, which overlap at their corners.
  const Boxes cup({box(0, 0, 0, 1, 1, 0.1), box(0, 0, 0, 0.1, 1, 1), box(0.9, 0, 0, 1, 1, 1), box(0, 0, 0, 1, 0.1, 1),
                   box(0, 0.9, 0, 1, 1, 1)});
  const FloatGrid::Ptr phi = meshToSdf(turned(cup.mesh()), kWhole, monitor);
  EXPECT_LT(worst(*phi, cup), 1e-3);
  EXPECT_GT(phi->tree().getValue(openvdb::Coord::round(phi->worldToIndex(turned(Vec3d(0.5, 0.5, 0.5))))), 0.0F);
}

}  // namespace
