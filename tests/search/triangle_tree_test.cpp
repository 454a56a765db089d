// SPDX-License-Identifier: Apache-2.0
// The nearest triangles of blocks and positions, against all triangles one by one.
#include "search/triangle_tree.h"
#include "julia/instruction_set.h"
#include "support/test_meshes.h"
#include "support/triangle_edges.h"

#include <openvdb/math/Proximity.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace test_meshes;
using openvdb::Coord;
using vdbtools::BlockDistances;
using vdbtools::TriangleTree;

double distanceTo(const Mesh& mesh, std::size_t triangle, const Vec3d& position) {
  const Vec3I& t = mesh.triangles[triangle];
  const Vec3d corners[] = {mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]};
  // The edges too, as OpenVDB's function fails for triangles without an area.
  const double least = distanceToEdges(corners, position);
  Vec3d weights;
  const Vec3d nearest =
      openvdb::math::closestPointOnTriangleToPoint(corners[0], corners[1], corners[2], position, weights);
  const double inPlane = (nearest - position).length();
  return std::isfinite(inPlane) ? std::min(least, inPlane) : least;
}

double distanceToMesh(const Mesh& mesh, const Vec3d& position) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) least = std::min(least, distanceTo(mesh, i, position));
  return least;
}

/// Triangles of any size and shape: slivers, needles, points and large ones among small ones.
Mesh makeMixture(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  // One number in each statement: compilers evaluate arguments in different orders.
  const auto direction = [&] {
    Vec3d d;
    for (int axis = 0; axis < 3; ++axis) d[axis] = unit(random);
    return d;
  };
  Mesh mesh;
  for (unsigned i = 0; i < 300; ++i) {
    const double size = std::pow(10.0, 1.5 * unit(random)), width = size * std::pow(10.0, -6 * std::abs(unit(random)));
    const Vec3d a = direction() * 30.0, b = direction() * size;
    Vec3d c = b * unit(random);
    if (i % 7 != 0) c += direction() * width;
    mesh.points.push_back(a);
    mesh.points.push_back(i % 41 == 0 ? a : a + b);
    mesh.points.push_back(i % 41 == 0 ? a : a + c);
    mesh.triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
  }
  return mesh;
}

struct Case {
  std::string name;
  Mesh mesh;
};

std::vector<Case> cases() {
  const Vec3d off(0.3, -0.2, 0.45);
  return {{"sphere", makeSphere(20, 4, off)},
          {"large triangles", makeBox(Vec3d(-31.4, -20.2, -9.7), Vec3d(30.3, 22.9, 11.1))},
          {"thin plate", makeBox(Vec3d(-30, -30, 0.31), Vec3d(30, 30, 0.34))},
          {"one triangle", withoutTriangles(makeCube(40, off), [](const Vec3d& c) { return c[0] + c[1] / 3 < 20; })},
          {"soup", makeSoup(makeSphere(15, 3, off), 3)},
          {"more triangles than nodes", makeSphere(3, 5, off)},
          {"many triangles, and larger ones among them", merged(makeSoup(makeSphere(3, 5, off), 0.02), makeMixture(2))},
          {"mixture", makeMixture(1)},
          {"another mixture", makeMixture(2)}};
}

/// Floats choose the triangle, so that a distance may be that of one a little farther.
double tolerance(const Mesh& mesh, double distance) {
  openvdb::BBoxd box;
  for (const Vec3d& p : mesh.points) box.expand(p);
  return 1e-6 * (1 + distance) + 2e-7 * box.extents().length();
}

// Promise of design.md: A node "has the distance to the nearest of all triangles"
TEST(TriangleTree, BlocksHaveTheDistancesToAllTriangles) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> near(-5, 5), far(-40, 40), node(0, 511);
  for (const Case& c : cases()) {
    const TriangleTree tree(c.mesh.points, c.mesh.triangles);
    BlockDistances block(tree);
    double worst = 0;
    for (int i = 0; i < 60; ++i) {
      auto& reach = i % 4 == 0 ? far : near;
      const Coord origin = Coord(8 * reach(random), 8 * reach(random), 8 * reach(random));
      block.evaluate(origin, std::numeric_limits<float>::max());
      for (int k = 0; k < 10; ++k) {
        const int n = node(random);
        const Vec3d position = origin.asVec3d() + Vec3d(n >> 6, n >> 3 & 7, n & 7);
        const double distance = distanceToMesh(c.mesh, position);
        worst = std::max(worst, std::abs(block.distances()[n] - distance) / tolerance(c.mesh, distance));
        EXPECT_NEAR(distanceTo(c.mesh, block.triangles()[n], position), block.distances()[n], 1e-6 * (1 + distance));
      }
    }
    EXPECT_LT(worst, 1) << c.name;
  }
}

// Promise: A node "has the distance ..."
TEST(TriangleTree, NeitherFramesNorEarlierQueriesChangeABit) {
  std::mt19937 random(11);
  std::uniform_int_distribution<int> place(-9, 9);
  constexpr float kFar = 60;
  for (const Case& c : cases()) {
    const TriangleTree tree(c.mesh.points, c.mesh.triangles);
    const TriangleTree framed(c.mesh.points, c.mesh.triangles, {}, TriangleTree::Frames::Once);
    EXPECT_EQ(tree.frames(), TriangleTree::Frames::ForEachBlock);
    EXPECT_EQ(framed.frames(), TriangleTree::Frames::Once);
    BlockDistances used(tree), framedAndUsed(framed);
    for (int i = 0; i < 40; ++i) {
      const Coord origin(8 * place(random), 8 * place(random), 8 * place(random));
      BlockDistances fresh(tree);
      fresh.evaluate(origin, kFar);
      const Vec3d middle = origin.asVec3d() + Vec3d(3.5), elsewhere(place(random), 3 * place(random), 0);
      for (BlockDistances* const block : {&used, &framedAndUsed}) {
        // The last query is for the middle of this block, or another place, or what it was before.
        if (i % 3 > 0) block->distance(i % 3 == 1 ? middle : elsewhere, i % 2 == 0 ? 3 : 200);
        block->evaluate(origin, kFar);
        for (int n = 0; n < 512; ++n) {
          if (!(fresh.distances()[n] <= kFar)) continue;
          ASSERT_EQ(block->distances()[n], fresh.distances()[n]) << c.name;
          ASSERT_EQ(block->triangles()[n], fresh.triangles()[n]) << c.name;
        }
      }
    }
  }
}

TEST(TriangleTree, NodesWithinReachAreNeverLeftOut) {
  for (const Case& c : cases()) {
    const TriangleTree tree(c.mesh.points, c.mesh.triangles);
    BlockDistances near(tree), all(tree);
    for (int i = -4; i < 4; ++i) {
      const Coord origin = Coord(8 * i, 8, -8 * i);
      constexpr float kFar = 3;
      near.evaluate(origin, kFar);
      all.evaluate(origin, std::numeric_limits<float>::max());
      for (int n = 0; n < 512; ++n) {
        if (all.distances()[n] <= kFar) {
          EXPECT_EQ(near.distances()[n], all.distances()[n]) << c.name;
        } else {
          EXPECT_GT(near.distances()[n], kFar) << c.name;
        }
      }
    }
  }
}

// Promise: "any size of a batch, and any ..."
TEST(TriangleTree, AllInstructionSetsGiveTheSameBits) {
  const julia::InstructionSet best = julia::instructionSet();
  for (const Case& c : cases()) {
    const TriangleTree tree(c.mesh.points, c.mesh.triangles);
    std::vector<float> distances;
    std::vector<std::uint32_t> triangles;
    for (const julia::InstructionSet set : julia::availableInstructionSets()) {
      julia::setInstructionSet(set);
      BlockDistances block(tree);
      std::vector<float> d;
      std::vector<std::uint32_t> t;
      for (int i = -6; i < 6; ++i) {
        block.evaluate(Coord(8 * i, -8 * i, 16 * i), std::numeric_limits<float>::max());
        d.insert(d.end(), block.distances(), block.distances() + 512);
        t.insert(t.end(), block.triangles(), block.triangles() + 512);
        const auto nearest = tree.nearest(Vec3d(i * 7.3, i, 3), 1e6);
        ASSERT_TRUE(nearest);
        t.push_back(nearest->triangle);
      }
      if (distances.empty()) {
        distances = d;
        triangles = t;
      }
      EXPECT_TRUE(d == distances) << c.name << ", " << julia::nameOf(set);
      EXPECT_TRUE(t == triangles) << c.name << ", " << julia::nameOf(set);
    }
    julia::setInstructionSet(best);
  }
}

TEST(TriangleTree, FindsTheNearestTriangleOfAPosition) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-60, 60);
  for (const Case& c : cases()) {
    const TriangleTree tree(c.mesh.points, c.mesh.triangles);
    for (int i = 0; i < 100; ++i) {
      const Vec3d position(place(random), place(random), place(random));
      const double distance = distanceToMesh(c.mesh, position), rounding = tolerance(c.mesh, distance);
      const auto found = tree.nearest(position, 1e6);
      ASSERT_TRUE(found) << c.name;
      EXPECT_NEAR(found->distance, distance, rounding) << c.name;
      EXPECT_NEAR((found->point - position).length(), found->distance, 1e-9);
      EXPECT_FALSE(tree.nearest(position, distance - 2 * rounding)) << c.name;
    }
  }
}

/// Far from the origin, the lattice is as fine as doubles make it.
TEST(TriangleTree, TheOriginDoesNotMatter) {
  const Mesh mesh = makeSphere(20, 3);
  const Coord shift(1 << 28, -(1 << 27), 12345 * 8);
  const Mesh moved = transformed(mesh, 1, shift.asVec3d());
  const TriangleTree tree(moved.points, moved.triangles);
  BlockDistances block(tree);
  for (int i = -3; i < 3; ++i) {
    const Coord origin = shift + Coord(8 * i, 8 * i, 0);
    block.evaluate(origin, 100);
    for (int n = 0; n < 512; n += 37) {
      const Vec3d position = (origin - shift).asVec3d() + Vec3d(n >> 6, n >> 3 & 7, n & 7);
      EXPECT_NEAR(block.distances()[n], distanceToMesh(mesh, position), 1e-5);
    }
  }
}

/// Calls check(name, mesh, tree) for each case, and once more far from the origin.
template <class Check>
void forEachCaseHereAndFarAway(const Check& check) {
  for (const Case& c : cases())
    for (const Mesh& mesh : {c.mesh, transformed(c.mesh, 1, Vec3d(5000.25, -70.5, 9000))})
      check(c.name, mesh, TriangleTree(mesh.points, mesh.triangles));
}

TEST(TriangleTree, VisitsEachTriangleInABoxOnce) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  forEachCaseHereAndFarAway([&](const std::string& name, const Mesh& mesh, const TriangleTree& tree) {
    for (int i = 0; i < 20; ++i) {
      const Vec3d at = mesh.points[random() % mesh.points.size()];
      openvdb::BBoxd box(at, at);
      box.expand(at + Vec3d(unit(random), unit(random), unit(random)) * (i % 5));
      std::vector<int> visits(mesh.triangles.size(), 0);
      tree.meeting(box, [&](std::uint32_t t) { ++visits[t]; });
      for (std::size_t t = 0; t < visits.size(); ++t) {
        openvdb::BBoxd around;
        for (int corner = 0; corner < 3; ++corner) around.expand(mesh.points[mesh.triangles[t][corner]]);
        EXPECT_LE(visits[t], 1) << name;
        EXPECT_GE(visits[t], around.hasOverlap(box) ? 1 : 0) << name;
      }
    }
  });
}

TEST(TriangleTree, VisitsEachTriangleOnARayOnce) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> unit(-1, 1);
  forEachCaseHereAndFarAway([&](const std::string& name, const Mesh& mesh, const TriangleTree& tree) {
    for (int i = 0; i < 20; ++i) {
      // A ray through a point of a triangle.
      const auto target = static_cast<std::uint32_t>(random() % mesh.triangles.size());
      const double u = 0.5 + 0.4 * unit(random), v = (1 - u) * (0.5 + 0.4 * unit(random));
      const Vec3I& t = mesh.triangles[target];
      const Vec3d point = mesh.points[t[0]] * u + mesh.points[t[1]] * v + mesh.points[t[2]] * (1 - u - v);
      const Vec3d direction(unit(random), unit(random), unit(random));
      std::vector<int> visits(mesh.triangles.size(), 0);
      tree.along(point - direction * 20.0, direction, 1e-3, [&](std::uint32_t n) { ++visits[n]; });
      EXPECT_EQ(visits[target], 1) << name;
      EXPECT_LE(*std::max_element(visits.begin(), visits.end()), 1) << name;
    }
  });
}

}  // namespace
