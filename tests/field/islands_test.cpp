// SPDX-License-Identifier: Apache-2.0
// Islands: the same as OpenVDB's segments, whatever tiles and threads there are; and the mesh without them is the mesh
// from before without their triangles.
#include "support/mesh_laws.h"
#include "support/speck_fields.h"

#include "vdbtools/exponent/exponent_grid.h"
#include "vdbtools/field/islands.h"
#include "vdbtools/surface/extract_mesh.h"
#include "vdbtools/surface/level_set.h"

#include "julia/shape_modulus.h"

#include <gtest/gtest.h>

#include <openvdb/tools/LevelSetUtil.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>

namespace {

using namespace vdbtools;
using openvdb::BBoxd;
using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::FloatTree;
using openvdb::Index;
using openvdb::Vec3d;
using test_fields::boxOf;
using test_fields::longestSide;
using test_fields::monitor;
using test_fields::NodeEvaluator;
using test_fields::noise;
using test_fields::speck;
using test_fields::specks;

FractalField evaluatedEverywhere(const julia::FieldEvaluator& evaluator, const CoordBBox& domain) {
  const BBoxd box(domain.min().asVec3d(), domain.max().asVec3d());
  return fractalFieldEverywhere({evaluator, {}}, {.voxelSize = 1, .box = box}, monitor);
}

/// A field of chosen inside nodes.
FractalField fieldOf(const std::vector<Coord>& inside, double voxelSize = 1) {
  FractalField field;
  field.field = FloatGrid::create(1.0f);
  field.field->setTransform(openvdb::math::Transform::createLinearTransform(voxelSize));
  for (const Coord& node : inside) field.field->tree().setValue(node, -0.5f);
  return field;
}

FractalField copyOf(const FractalField& field) {
  FractalField copy = field;
  copy.field = field.field->deepCopy();
  return copy;
}

IslandReport drop(FractalField& field, const IslandOptions& options) { return dropIslands(field, options, monitor); }

/// In the order of (x, y, z), as Coord compares.
using Nodes = std::vector<Coord>;

Nodes insideNodes(const FractalField& field, const CoordBBox& box) {
  Nodes nodes;
  const auto values = field.field->getConstAccessor();
  for (auto node = box.begin(); node; ++node)
    if (values.getValue(*node) < 0) nodes.push_back(*node);
  return nodes;
}

/// By OpenVDB, in the order of their ranks.
std::vector<Nodes> segments(const Nodes& inside) {
  openvdb::BoolTree mask(false);
  for (const Coord& node : inside) mask.setValueOn(node);
  std::vector<openvdb::BoolTree::Ptr> parts;
  openvdb::tools::segmentActiveVoxels(mask, parts);
  std::vector<Nodes> islands;
  for (const auto& part : parts) {
    Nodes& nodes = islands.emplace_back();
    for (auto node = part->cbeginValueOn(); node; ++node) nodes.push_back(node.getCoord());
    std::sort(nodes.begin(), nodes.end());
  }
  std::sort(islands.begin(), islands.end(), [](const Nodes& a, const Nodes& b) {
    return a.size() != b.size() ? a.size() > b.size() : a.front() < b.front();
  });
  return islands;
}

Nodes unionOf(const std::vector<Nodes>& islands) {
  Nodes all;
  for (const Nodes& island : islands) all.insert(all.end(), island.begin(), island.end());
  std::sort(all.begin(), all.end());
  return all;
}

/// Everything that must hold of a field from which all but @a kept were dropped.
void expectKept(const FractalField& before, const FractalField& after, const IslandReport& report,
                const std::vector<Nodes>& all, const std::vector<Nodes>& kept, const CoordBBox& box) {
  EXPECT_EQ(report.islands, all.size());
  EXPECT_EQ(report.keptIslands, kept.size());
  const Nodes left = unionOf(kept);
  EXPECT_EQ(report.droppedNodes, unionOf(all).size() - left.size());
  EXPECT_EQ(insideNodes(after, box), left);
  EXPECT_TRUE(after.field->tree().hasSameTopology(before.field->tree()));
  const auto old = before.field->getConstAccessor(), now = after.field->getConstAccessor();
  for (auto node = box.begin(); node; ++node) {
    const float value = now.getValue(*node);
    if (old.getValue(*node) < 0 && !(value < 0)) {
      ASSERT_GT(value, 0) << *node;
    } else {
      ASSERT_EQ(value, old.getValue(*node)) << *node;
    }
  }
}

// Sparse specks, a sponge about to hang together (at 0.31 of the nodes), and one that does, with specks in its holes.
constexpr double kIslandDensities[] = {0.02, 0.15, 0.25, 0.31, 0.4, 0.6};

// Promise: "keep only the N largest" ...
TEST(Islands, AreOpenVdbsSegments) {
  openvdb::initialize();
  // Across the corners of leaves, and of the largest nodes below the root.
  for (const Coord& middle : {Coord(0), Coord(68, -60, 4100)}) {
    unsigned seed = 0;
    for (const double density : kIslandDensities) {
      SCOPED_TRACE(testing::Message() << "density " << density << " about " << middle);
      const CoordBBox domain(middle.offsetBy(-11), middle.offsetBy(13));
      const FractalField field = evaluatedEverywhere(specks(density, ++seed), domain);
      CoordBBox box = domain;
      box.expand(10);
      const std::vector<Nodes> all = segments(insideNodes(field, box));
      ASSERT_GT(all.size(), 3u);
      for (const std::size_t largest : {std::size_t(1), std::size_t(2), std::size_t(7), all.size() / 2, all.size() - 1,
                                        all.size(), all.size() + 9}) {
        SCOPED_TRACE(testing::Message() << "largest " << largest << " of " << all.size());
        FractalField after = copyOf(field);
        const IslandReport report = drop(after, {.largest = largest});
        const auto end = all.begin() + static_cast<std::ptrdiff_t>(std::min(largest, all.size()));
        expectKept(field, after, report, all, {all.begin(), end}, box);
      }
      for (int size = 1; size <= longestSide(all.front()); size += 1 + size / 4) {
        SCOPED_TRACE(testing::Message() << "size " << size);
        FractalField after = copyOf(field);
        const IslandReport report = drop(after, {.minSize = static_cast<double>(size)});
        std::vector<Nodes> kept = all;
        std::erase_if(kept, [&](const Nodes& island) { return longestSide(island) < size; });
        expectKept(field, after, report, all, kept, box);
      }
    }
  }
}

TEST(Islands, WithoutOptionsAreCountedOnly) {
  const CoordBBox domain(Coord(-9), Coord(9));
  const FractalField field = evaluatedEverywhere(specks(0.2, 3), domain);
  FractalField after = copyOf(field);
  const std::vector<Nodes> all = segments(insideNodes(field, domain));
  expectKept(field, after, drop(after, {}), all, all, domain);
}

TEST(Islands, OfChosenSizeStayInAnyUnits) {
  // Rods of 1 to 30 nodes along each axis in turn, and thresholds as a user types them: 29 voxels of 0.29 are a little
  // less than 8.41 in doubles.
  Nodes rods;
  for (int length = 1; length <= 30; ++length)
    for (int i = 0; i < length; ++i) {
      Coord node(0, 40 * (length % 6), 40 * (length / 6));
      node[length % 3] += i;
      rods.push_back(node);
    }
  for (const int thousandths : {1, 7, 29, 100, 290, 3300})
    for (int length = 1; length <= 30; ++length) {
      SCOPED_TRACE(testing::Message() << length << " voxels of " << thousandths << "/1000");
      const double size = length * thousandths / 1000.0;
      FractalField field = fieldOf(rods, thousandths / 1000.0);
      EXPECT_EQ(drop(field, {.minSize = size}).keptIslands, 31u - static_cast<unsigned>(length));
      if (length < 30) {
        EXPECT_EQ(drop(field, {.minSize = size * 1.001}).keptIslands, 30u - static_cast<unsigned>(length));
      }
    }
}

// Promise: "keep only the N largest" ...
TEST(Islands, TheLargestAreThoseOfTheLargeEnough) {
  Nodes nodes;
  for (auto node = CoordBBox(Coord(5), Coord(7)).begin(); node; ++node) nodes.push_back(*node);
  const Nodes compact = nodes;
  Nodes rod, shorter;
  for (int i = 0; i < 6; ++i) rod.emplace_back(i, 20, 20);
  for (int i = 0; i < 5; ++i) shorter.emplace_back(20, i, 20);
  for (const Nodes& more : {rod, shorter}) nodes.insert(nodes.end(), more.begin(), more.end());
  const CoordBBox box(Coord(-8), Coord(31));
  FractalField byCount = fieldOf(nodes), bySize = fieldOf(nodes);
  drop(byCount, {.largest = 1});
  EXPECT_EQ(insideNodes(byCount, box), compact);
  drop(bySize, {.largest = 1, .minSize = 4});
  EXPECT_EQ(insideNodes(bySize, box), rod);
}

TEST(Islands, DoNotJoinAcrossDiagonals) {
  for (const Coord& step : {Coord(1, 1, 0), Coord(1, 0, -1), Coord(0, 1, 1), Coord(1, 1, 1), Coord(-1, 1, 1)})
    for (const Coord& node : {Coord(3), Coord(7), Coord(127), Coord(0)}) {
      FractalField field = fieldOf({node, node + step});
      EXPECT_EQ(drop(field, {}).islands, 2u) << node << " " << step;
    }
  for (int axis = 0; axis < 3; ++axis)
    for (const int at : {3, 7, 127, 4095, -1}) {
      Coord node(2, 2, 2), next(2, 2, 2);
      node[axis] = at;
      next[axis] = at + 1;
      FractalField field = fieldOf({node, next});
      EXPECT_EQ(drop(field, {}).islands, 1u) << node << " " << next;
    }
}

TEST(Islands, TilesAreShortForTheirNodes) {
  // Four nodes of 16^3 tiles, random: outside, inside, or a leaf of specks; one inside tile as large as those; none.
  const CoordBBox box(Coord(-128, -128, 0), Coord(255, 127, 127));
  FractalField sparse = fieldOf({});
  FloatTree& tree = sparse.field->tree();
  tree.addTile(2, Coord(0), -1.0f, false);
  for (int x = box.min()[0]; x <= box.max()[0]; x += 8)
    for (int y = box.min()[1]; y <= box.max()[1]; y += 8)
      for (int z = box.min()[2]; z <= box.max()[2]; z += 8) {
        const Coord origin(x, y, z), large = origin & ~127;
        if (large == Coord(0) || large == Coord(-128, -128, 0)) continue;
        const double kind = noise(origin, 77);
        if (kind < 0.2) continue;
        if (kind < 0.55) {
          tree.addTile(1, origin, -1.0f, false);
        } else {
          for (auto node = CoordBBox::createCube(origin, 8).begin(); node; ++node)
            tree.setValue(*node, static_cast<float>(speck(*node, 0.3, 12)));
        }
      }
  const FractalField dense = copyOf(sparse);
  for (int x = box.min()[0]; x <= box.max()[0]; x += 8)
    for (int y = box.min()[1]; y <= box.max()[1]; y += 8)
      for (int z = box.min()[2]; z <= box.max()[2]; z += 8) dense.field->tree().touchLeaf({x, y, z});
  ASSERT_GT(dense.field->tree().leafCount(), 2 * tree.leafCount());

  // All sizes that make a difference among the larger ones, which are those with tiles.
  for (const IslandOptions options : {IslandOptions{.largest = 1},
                                      IslandOptions{.largest = 2},
                                      {.largest = 60},
                                      {.minSize = 8},
                                      {.minSize = 9},
                                      {.minSize = 30},
                                      {.minSize = 129}}) {
    SCOPED_TRACE(testing::Message() << options.largest << " largest, " << options.minSize << " across");
    FractalField a = copyOf(sparse), b = copyOf(dense);
    const IslandReport inTiles = drop(a, options), inNodes = drop(b, options);
    EXPECT_EQ(inTiles.islands, inNodes.islands);
    EXPECT_EQ(inTiles.keptIslands, inNodes.keptIslands);
    EXPECT_EQ(inTiles.droppedNodes, inNodes.droppedNodes);
    EXPECT_GT(inTiles.islands, 1000u);
    EXPECT_LT(inTiles.keptIslands, inTiles.islands);
    EXPECT_TRUE(a.field->tree().hasSameTopology(tree));
    const auto value = a.field->getConstAccessor();
    for (auto leaf = b.field->tree().cbeginLeaf(); leaf; ++leaf)
      for (auto node = leaf->cbeginValueAll(); node; ++node)
        ASSERT_EQ(value.getValue(node.getCoord()), *node) << node.getCoord();
  }
}

TEST(Islands, ReachThroughTilesOfTheRoot) {
  constexpr int kTile = 4096;
  const FractalField start = fieldOf({Coord(-1, 5, 5), Coord(-3, 5, 5)});
  FloatTree& tree = start.field->tree();
  for (const Coord& tile : {Coord(0), Coord(kTile, 0, 0), Coord(0, 0, 2 * kTile)}) tree.addTile(3, tile, -1.0f, false);
  tree.addTile(1, Coord(2 * kTile, 8, 16), -1.0f, false);
  for (const int y : {kTile, 2 * kTile - 128, 2 * kTile}) tree.addTile(2, Coord(128, y, 256), -1.0f, false);
  constexpr std::uint64_t kTileNodes = 1ull << 36, kPairNodes = 2 << 21;
  FractalField field = copyOf(start);
  IslandReport report = drop(field, {.largest = 1});
  EXPECT_EQ(report.islands, 4u);
  EXPECT_EQ(report.droppedNodes, 1 + kTileNodes + kPairNodes);
  const auto value = [&](int x, int y, int z) { return field.field->tree().getValue({x, y, z}); };
  for (const float kept :
       {value(-1, 5, 5), value(9, 9, 9), value(5000, 9, 9), value(8195, 9, 17), value(128, 4100, 300)})
    EXPECT_LT(kept, 0);
  for (const float dropped : {value(-3, 5, 5), value(9, 9, 9000), value(128, 8191, 256), value(128, 8192, 256)})
    EXPECT_GT(dropped, 0);

  field = copyOf(start);
  report = drop(field, {.minSize = 2 * kTile + 1 + 8});
  EXPECT_EQ(report.keptIslands, 1u);
  field = copyOf(start);
  EXPECT_THROW(drop(field, {.minSize = 2 * kTile + 1 + 9}), DataError);
}

// ---- what the mesh makes of it

using Corner = std::array<double, 3>;
using Triangle = std::array<Corner, 3>;

Triangle triangleAt(const Mesh& mesh, const openvdb::Vec3I& indices) {
  Triangle triangle;
  for (int k = 0; k < 3; ++k) {
    const Vec3d& p = mesh.points[indices[k]];
    triangle[static_cast<std::size_t>(k)] = {p[0], p[1], p[2]};
  }
  return triangle;
}

std::vector<Triangle> trianglesOf(const Mesh& mesh) {
  std::vector<Triangle> triangles;
  for (const openvdb::Vec3I& indices : mesh.triangles) triangles.push_back(triangleAt(mesh, indices));
  return triangles;
}

std::size_t componentsOf(const Mesh& mesh) {
  std::vector<std::size_t> parents(mesh.points.size());
  std::iota(parents.begin(), parents.end(), 0);
  const auto root = [&](std::size_t point) {
    while (parents[point] != point) point = parents[point] = parents[parents[point]];
    return point;
  };
  std::size_t count = parents.size();
  for (const openvdb::Vec3I& t : mesh.triangles)
    for (int k = 1; k < 3; ++k) {
      const std::size_t a = root(t[0]), b = root(t[k]);
      count -= a != b;
      parents[a] = b;
    }
  return count;
}

/// The closed surfaces of an island: one about it and one in each bubble, and there are as many as pieces of its
/// complement. Where the inside joins through 6 neighbours, the outside does through 18.
std::size_t surfacesOf(const Nodes& island) {
  CoordBBox box = boxOf(island);
  box.expand(1);
  const std::set<Coord> inside(island.begin(), island.end());
  std::set<Coord> seen;
  std::size_t count = 0;
  for (auto start = box.begin(); start; ++start) {
    if (inside.contains(*start) || !seen.insert(*start).second) continue;
    ++count;
    Nodes front{*start};
    while (!front.empty()) {
      const Coord node = front.back();
      front.pop_back();
      for (auto step = CoordBBox(Coord(-1), Coord(1)).begin(); step; ++step) {
        const Coord next = node + *step;
        const bool corner = (*step)[0] && (*step)[1] && (*step)[2];
        if (!corner && box.isInside(next) && !inside.contains(next) && seen.insert(next).second) front.push_back(next);
      }
    }
  }
  return count;
}

TEST(Islands, EachHasItsOwnTrianglesInEveryCell) {
  for (unsigned signs = 1; signs < 256; ++signs) {
    SCOPED_TRACE(testing::Message() << "corner signs " << signs);
    const auto meshOf = [](const Nodes& nodes) {
      const NodeEvaluator evaluator(
          [&](const Coord& node) { return std::find(nodes.begin(), nodes.end(), node) != nodes.end() ? -1.0 : 1.0; });
      const CoordBBox domain(Coord(5), Coord(10));
      return extractMesh(evaluatedEverywhere(evaluator, domain), {evaluator, {}}, {}, monitor);
    };
    Nodes corners;
    for (int corner = 0; corner < 8; ++corner)
      if (signs >> corner & 1) corners.emplace_back(7 + (corner & 1), 7 + (corner >> 1 & 1), 7 + (corner >> 2 & 1));
    std::vector<Triangle> together = trianglesOf(meshOf(corners)), apart;
    for (const Nodes& island : segments(corners))
      for (const Triangle& triangle : trianglesOf(meshOf(island))) apart.push_back(triangle);
    std::sort(together.begin(), together.end());
    std::sort(apart.begin(), apart.end());
    EXPECT_EQ(together, apart);
  }
}

// Promise: "keep only the N largest" ...
TEST(Islands, TheMeshOfTheRestIsTheRestOfTheMesh) {
  unsigned seed = 40;
  for (const Border border : {Border::Cap, Border::Open})
    for (const double density : kIslandDensities) {
      const NodeEvaluator evaluator = specks(density, ++seed);
      const CoordBBox domain(Coord(-9), Coord(10));
      const FractalField field = evaluatedEverywhere(evaluator, domain);
      const FieldSource source{evaluator, {}};
      const Mesh before = extractMesh(field, source, {.border = border}, monitor);
      const std::vector<Nodes> all = segments(insideNodes(field, domain));
      std::map<Coord, std::size_t> rank;
      for (std::size_t i = 0; i < all.size(); ++i)
        for (const Coord& node : all[i]) rank[node] = i;
      // Each point lies on an edge with one end inside.
      std::vector<std::size_t> pointRank;
      for (const Vec3d& point : before.points) {
        const mesh_laws::OnEdge edge = mesh_laws::onEdge(point, 1);
        Coord end = edge.node;
        ++end[edge.axis];
        ASSERT_NE(rank.contains(edge.node), rank.contains(end)) << point;
        pointRank.push_back(rank.at(rank.contains(end) ? end : edge.node));
      }
      for (const std::size_t largest : {std::size_t(1), std::size_t(2), all.size() / 3 + 1, all.size()}) {
        SCOPED_TRACE(testing::Message() << "density " << density << ", seed " << seed << ", " << largest << " of "
                                        << all.size());
        FractalField rest = copyOf(field);
        drop(rest, {.largest = largest});
        const Mesh after = extractMesh(rest, source, {.border = border}, monitor);
        std::vector<Vec3d> points;
        for (std::size_t i = 0; i < before.points.size(); ++i)
          if (pointRank[i] < largest) points.push_back(before.points[i]);
        std::vector<Triangle> triangles;
        for (const openvdb::Vec3I& t : before.triangles) {
          for (int k = 1; k < 3; ++k) ASSERT_EQ(pointRank[t[0]], pointRank[t[k]]) << "a triangle of two islands";
          if (pointRank[t[0]] < largest) triangles.push_back(triangleAt(before, t));
        }
        EXPECT_EQ(after.points, points);
        EXPECT_EQ(trianglesOf(after), triangles);
        if (border == Border::Open) continue;
        EXPECT_EQ(mesh_laws::notClosedManifold(after), "");
        std::size_t surfaces = 0;
        for (std::size_t i = 0; i < std::min(largest, all.size()); ++i) surfaces += surfacesOf(all[i]);
        EXPECT_EQ(componentsOf(after), surfaces);
      }
    }
}

/// Leaves where the surface is, tiles elsewhere.
FractalField shellField(const test_fields::Distance& distance, const CoordBBox& domain) {
  FractalField field = fieldOf({});
  field.domain = field.window = domain;
  constexpr double kReach = 8.5;  // half a leaf's diagonal, and an edge
  for (int x = domain.min()[0] & ~7; x <= domain.max()[0]; x += 8)
    for (int y = domain.min()[1] & ~7; y <= domain.max()[1]; y += 8)
      for (int z = domain.min()[2] & ~7; z <= domain.max()[2]; z += 8) {
        const Coord origin(x, y, z);
        if (std::abs(distance(origin.asVec3d() + Vec3d(3.5))) > kReach) continue;
        for (auto node = CoordBBox::createCube(origin, 8).begin(); node; ++node)
          field.field->tree().setValue(*node, static_cast<float>(distance((*node).asVec3d())));
      }
  openvdb::tools::signedFloodFillWithValues(field.field->tree(), 1.0f, -1.0f);
  return field;
}

std::uint64_t insideCount(const FractalField& field) {
  std::uint64_t count = 0;
  for (auto value = field.field->tree().cbeginValueAll(); value; ++value)
    if (*value < 0) count += value.getVoxelCount();
  return count;
}

TEST(Islands, LargeOnesGoWithAllTheirTiles) {
  // A ball around a tile of 128^3, a hollow one with another in its middle, and a rod that is longer than either.
  const auto ball = [](const Vec3d& x, const Vec3d& middle, double radius) { return (x - middle).length() - radius; };
  const auto distance = [&](const Vec3d& x) {
    const double solid = ball(x, Vec3d(64.2), 121.3), core = ball(x, Vec3d(64, 250, 64), 12.3);
    const double hollow = std::abs(ball(x, Vec3d(64, 250, 64), 45)) - 15.3;
    const double rod = Vec3d(std::max(0.0, std::abs(x[0] - 64) - 130), x[1] + 66, x[2] - 64).length() - 2.3;
    return std::min({solid, core, hollow, rod});
  };
  const FractalField field = shellField(distance, {Coord(-80, -70, -60), Coord(210, 320, 190)});
  ASSERT_EQ(field.field->tree().getValueDepth(Coord(64)), 1) << "no tile of 128^3";
  const NodeEvaluator evaluator([&](const Coord& node) { return distance(node.asVec3d()); });
  const auto meshOf = [&](const FractalField& of) { return extractMesh(of, {evaluator, {}}, {}, monitor); };
  ASSERT_EQ(componentsOf(meshOf(field)), 5u);

  struct {
    const char* name;
    IslandOptions options;
    std::uint64_t kept;
    std::size_t surfaces;
    std::vector<Vec3d> outside, inside;
  } const cases[] = {
      {"the ball", {.largest = 1}, 1, 1, {Vec3d(64, 250, 64), Vec3d(64, 205, 64), Vec3d(64, -66, 64)}, {Vec3d(64)}},
      {"and the hollow one", {.largest = 2}, 2, 3, {Vec3d(64, 250, 64), Vec3d(64, -66, 64)}, {Vec3d(64, 205, 64)}},
      {"and its core", {.largest = 3}, 3, 4, {Vec3d(64, -66, 64)}, {Vec3d(64, 250, 64)}},
      {"the rod", {.minSize = 250}, 1, 1, {Vec3d(64), Vec3d(0), Vec3d(64, 205, 64)}, {Vec3d(64, -66, 64)}},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.name);
    FractalField rest = copyOf(field);
    const IslandReport report = drop(rest, c.options);
    EXPECT_EQ(report.islands, 4u);
    EXPECT_EQ(report.keptIslands, c.kept);
    for (const Vec3d& x : c.outside) EXPECT_GT(rest.field->tree().getValue(Coord::round(x)), 0) << x;
    for (const Vec3d& x : c.inside) EXPECT_LT(rest.field->tree().getValue(Coord::round(x)), 0) << x;
    const Mesh mesh = meshOf(rest);
    EXPECT_EQ(mesh_laws::notClosedManifold(mesh), "");
    EXPECT_EQ(componentsOf(mesh), c.surfaces);
    EXPECT_EQ(report.droppedNodes, insideCount(field) - insideCount(rest));
  }
}

TEST(Islands, OfAFractalLeaveAMeshAndALevelSet) {
  ExponentGridOptions options{.alpha = Control(6.0), .beta = Control(0.0)};
  constexpr double kPhiVoxel = 1.0 / 40;
  const auto phi = test_fields::bandGrid(test_fields::lumpy, kPhiVoxel, exteriorReach(options) + 6 * kPhiVoxel);
  const ExponentGrid exponent =
      exponentGrid(makeTarget(phi, std::nullopt), FractalSpace{Vec3d(0), 1}, options, monitor);
  const auto evaluator = julia::makeFieldEvaluator<double>(
      std::make_shared<julia::ShapeModulus<double>>(makeExponentField<double>(exponent),
                                                    test_fields::randomVersor(17, 8, 9, true), julia::DropAxis::K),
      {0, julia::DropAxis::K}, exponent.orbit);
  const FieldSource source{*evaluator, exponent.space};
  FractalField field = fractalField(source, exponent, {.voxelSize = 1.0 / 80}, monitor);
  std::set<Corner> before;
  for (const Vec3d& p : extractMesh(field, source, {}, monitor).points) before.insert({p[0], p[1], p[2]});
  CoordBBox box = field.domain;
  box.expand(2);
  const std::vector<Nodes> all = segments(insideNodes(field, box));
  const IslandReport report = drop(field, {.largest = 3});
  EXPECT_EQ(report.islands, all.size());
  EXPECT_GT(report.islands, 20u) << "not much of a test";
  const Mesh mesh = extractMesh(field, source, {}, monitor);
  EXPECT_EQ(mesh_laws::notClosedManifold(mesh), "");
  EXPECT_EQ(componentsOf(mesh), surfacesOf(all[0]) + surfacesOf(all[1]) + surfacesOf(all[2]));
  for (const Vec3d& p : mesh.points) ASSERT_TRUE(before.contains({p[0], p[1], p[2]})) << p;
  const auto surface = levelSet(field, mesh, monitor);
  EXPECT_EQ(checkSurface(*surface).failure, "");
  for (auto node = box.begin(); node; ++node)
    ASSERT_EQ(surface->tree().getValue(*node) < 0, field.field->tree().getValue(*node) < 0) << *node;
}

// ---- and how it behaves

TEST(Islands, DroppingTwiceChangesNothing) {
  const FractalField field = evaluatedEverywhere(specks(0.25, 8), {Coord(-20), Coord(20)});
  for (const IslandOptions options : {IslandOptions{.largest = 4}, {.minSize = 3}, {.largest = 9, .minSize = 2}}) {
    FractalField once = copyOf(field);
    const IslandReport first = drop(once, options);
    FractalField twice = copyOf(once);
    const IslandReport second = drop(twice, options);
    EXPECT_EQ(second.islands, first.keptIslands);
    EXPECT_EQ(second.keptIslands, first.keptIslands);
    EXPECT_EQ(second.droppedNodes, 0u);
    for (auto node = field.domain.begin(); node; ++node)
      ASSERT_EQ(once.field->tree().getValue(*node), twice.field->tree().getValue(*node)) << *node;
  }
}

TEST(Islands, ThreadsDoNotMatter) {
  const FractalField field = evaluatedEverywhere(specks(0.3, 21), {Coord(-40), Coord(40)});
  FractalField results[2];
  IslandReport reports[2];
  for (const std::size_t threads : {1u, 2u}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    results[threads - 1] = copyOf(field);
    reports[threads - 1] = drop(results[threads - 1], {.largest = 100, .minSize = 2});
  }
  EXPECT_EQ(reports[0].islands, reports[1].islands);
  EXPECT_EQ(reports[0].droppedNodes, reports[1].droppedNodes);
  for (auto node = field.domain.begin(); node; ++node)
    ASSERT_EQ(results[0].field->tree().getValue(*node), results[1].field->tree().getValue(*node)) << *node;
}

TEST(Islands, AllTooSmallIsAnError) {
  const FractalField field = fieldOf({Coord(0), Coord(1, 0, 0), Coord(5)}, 0.25);
  FractalField after = copyOf(field);
  try {
    drop(after, {.minSize = 0.6});
    ADD_FAILURE() << "nothing thrown";
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find("0.5 across, and the smallest that was to be kept is 0.6"),
              std::string::npos)
        << error.what();
  }
  const CoordBBox box(Coord(-8), Coord(8));
  EXPECT_EQ(insideNodes(after, box), insideNodes(field, box)) << "half done";
}

TEST(Islands, OfNothingAreNone) {
  FractalField empty = fieldOf({});
  EXPECT_EQ(drop(empty, {.largest = 1, .minSize = 5}).islands, 0u);
}

TEST(Islands, RefuseASize) {
  FractalField field = fieldOf({Coord(0)});
  for (const double size : {-1.0, -1e-300, std::nan(""), double(INFINITY)}) {
    try {
      drop(field, {.minSize = size});
      ADD_FAILURE() << size;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find("smallest size"), std::string::npos) << error.what();
    }
  }
}

TEST(Islands, StopWhenAsked) {
  struct Cancelled final : Monitor {
    bool cancelled() const override { return true; }
  } cancelled;
  FractalField field = fieldOf({Coord(0), Coord(1, 0, 0), Coord(5)});
  EXPECT_THROW(dropIslands(field, {.largest = 1}, cancelled), Interrupted);
  EXPECT_EQ(insideNodes(field, {Coord(-8), Coord(8)}).size(), 3u) << "half done";
}

}  // namespace
