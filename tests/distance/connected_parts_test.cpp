// SPDX-License-Identifier: Apache-2.0
// Parts beside those that a walk from triangle to triangle finds.
#include "distance/connected_parts.h"
#include "support/test_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <random>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

namespace {

using namespace test_meshes;
using vdbtools::Closure;
using vdbtools::ConnectedParts;
using vdbtools::Monitor;
using vdbtools::TriangleTree;
using vdbtools::WeldedMesh;

using Place = std::tuple<double, double, double>;

struct ReferenceParts {
  std::vector<std::set<std::size_t>> triangles;
  std::vector<Closure> closure;
};

/// By positions, one triangle after the other. Triangles with two corners in one place are in no part.
ReferenceParts partsByWalking(const Mesh& mesh) {
  const auto place = [&](const Vec3I& t, int c) {
    const Vec3d& p = mesh.points[t[c % 3]];
    return Place(p[0], p[1], p[2]);
  };
  std::map<std::pair<Place, Place>, std::vector<std::size_t>> ways;  // triangles by their edges, in their direction
  std::vector<bool> isLeft(mesh.triangles.size(), false);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3I& triangle = mesh.triangles[t];
    const std::set<Place> corners = {place(triangle, 0), place(triangle, 1), place(triangle, 2)};
    if (corners.size() < 3) continue;
    isLeft[t] = true;
    for (int c = 0; c < 3; ++c) ways[{place(triangle, c), place(triangle, c + 1)}].push_back(t);
  }
  const auto uses = [&](const Place& a, const Place& b) {
    const auto found = ways.find({a, b});
    return found == ways.end() ? std::vector<std::size_t>() : found->second;
  };
  ReferenceParts parts;
  for (std::size_t first = 0; first < mesh.triangles.size(); ++first) {
    if (!isLeft[first]) continue;
    std::set<std::size_t> part;
    std::vector<std::size_t> next = {first};
    isLeft[first] = false;
    bool winds = true, isEven = true;
    while (!next.empty()) {
      const std::size_t t = next.back();
      next.pop_back();
      part.insert(t);
      for (int c = 0; c < 3; ++c) {
        const Place a = place(mesh.triangles[t], c), b = place(mesh.triangles[t], c + 1);
        const auto along = uses(a, b), against = uses(b, a);
        winds &= along.size() == against.size();
        isEven &= (along.size() + against.size()) % 2 == 0;
        for (const auto& side : {along, against})
          for (const std::size_t other : side)
            if (isLeft[other]) {
              isLeft[other] = false;
              next.push_back(other);
            }
      }
    }
    parts.triangles.push_back(part);
    parts.closure.push_back(winds ? Closure::Winding : isEven ? Closure::Parity : Closure::Open);
  }
  return parts;
}

void expectPartsOf(const Mesh& mesh) {
  const TriangleTree tree(mesh.points, mesh.triangles);
  const Monitor monitor;
  const ConnectedParts parts = vdbtools::findParts(WeldedMesh(tree), monitor);
  const ReferenceParts reference = partsByWalking(mesh);
  ASSERT_EQ(parts.closure.size(), reference.triangles.size());
  ASSERT_EQ(parts.box.size(), reference.triangles.size());
  ASSERT_EQ(parts.of.size(), mesh.triangles.size());
  std::size_t inParts = 0;
  for (std::size_t p = 0; p < reference.triangles.size(); ++p) {
    EXPECT_EQ(parts.closure[p], reference.closure[p]) << "part " << p;
    openvdb::BBoxd box;
    for (const std::size_t t : reference.triangles[p]) {
      EXPECT_EQ(parts.of[t], p) << "triangle " << t;
      for (int c = 0; c < 3; ++c) box.expand(mesh.points[mesh.triangles[t][c]]);
    }
    EXPECT_EQ(parts.box[p], box) << "part " << p;
    inParts += reference.triangles[p].size();
  }
  const auto without = std::count(parts.of.begin(), parts.of.end(), ConnectedParts::kNone);
  EXPECT_EQ(static_cast<std::size_t>(without), mesh.triangles.size() - inParts);
}

TEST(ConnectedParts, AreThoseThatAWalkFinds) {
  const Mesh ball = makeSphere(1, 2), cube = makeCube(1, Vec3d(3, 0, 0));
  Mesh turned = cube;
  std::swap(turned.triangles[3][0], turned.triangles[3][1]);
  Mesh open = cube;
  open.triangles.pop_back();
  for (const Mesh& mesh : {ball, cube, turned, open}) {
    expectPartsOf(mesh);
    expectPartsOf(makeSoup(mesh, 0));  // each triangle with points of its own
  }
}

TEST(ConnectedParts, AreThoseThatAWalkFindsInRandomTriangles) {
  // Few points, so that triangles share edges in all ways: repeated, in one direction, by three and more.
  std::mt19937 random(62);
  std::set<Closure> closures;
  std::size_t most = 0;
  for (int turn = 0; turn < 200; ++turn) {
    const std::uint32_t count = 4 + static_cast<std::uint32_t>(turn % 30);
    Mesh mesh;
    for (std::uint32_t p = 0; p < count; ++p) mesh.points.emplace_back(p % 7, p % 5, p / 9);
    for (int t = 0; t < 1 + turn % 40; ++t) {
      Vec3I triangle;
      for (int c = 0; c < 3; ++c) triangle[c] = static_cast<std::uint32_t>(random() % count);
      mesh.triangles.push_back(triangle);
      // Some triangles twice, in the same direction or the other one, so that parts are closed, too.
      if (random() % 2 == 0) mesh.triangles.push_back(triangle);
      if (random() % 2 == 0) mesh.triangles.emplace_back(triangle[0], triangle[2], triangle[1]);
    }
    expectPartsOf(mesh);
    const ReferenceParts parts = partsByWalking(mesh);
    closures.insert(parts.closure.begin(), parts.closure.end());
    most = std::max(most, parts.triangles.size());
  }
  EXPECT_EQ(closures.size(), 3u);
  EXPECT_GT(most, 5u);
}

TEST(ConnectedParts, MayMeetIfAClosedOneHasABoxThatOverlapsAnother) {
  const Monitor monitor;
  const auto meet = [&monitor](const std::vector<Mesh>& meshes) {
    Mesh all;
    for (const Mesh& mesh : meshes) all = merged(all, mesh);
    const TriangleTree tree(all.points, all.triangles);
    return vdbtools::mayMeet(vdbtools::findParts(WeldedMesh(tree), monitor));
  };
  Mesh open = makeCube(1, Vec3d(0.6, 0.3, 0.2)), openToo = makeCube(1, Vec3d(0.2, 0.1, 0.1));
  open.triangles.pop_back();
  openToo.triangles.pop_back();
  const Mesh cube = makeCube(), away = makeCube(1, Vec3d(1.5, 0, 0)), over = makeCube(1, Vec3d(0.5, 0.4, 0.3)),
             above = makeCube(1, Vec3d(0.5, 0.4, 1.3));
  EXPECT_FALSE(meet({cube}));
  EXPECT_FALSE(meet({cube, away}));
  EXPECT_FALSE(meet({above, cube, away}));
  EXPECT_TRUE(meet({cube, over}));
  EXPECT_TRUE(meet({away, above, over, cube}));
  EXPECT_TRUE(meet({open, cube}));
  EXPECT_FALSE(meet({open, openToo}));
}

}  // namespace
