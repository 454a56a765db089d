// SPDX-License-Identifier: Apache-2.0
// Crumbs: those of a plain flood over a dense array, whatever boxes, windows, layers and threads show of the lattice.
#include "support/mesh_laws.h"
#include "support/speck_fields.h"

#include "vdbtools/field/crumbs.h"
#include "vdbtools/field/fractal_field.h"
#include "vdbtools/field/lattice_options.h"
#include "vdbtools/search/solid_meter.h"
#include "vdbtools/surface/extract_mesh.h"
#include "vdbtools/surface/level_set.h"

#include "julia/shape_modulus.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <tuple>
#include <vector>

namespace {

using namespace vdbtools;
using openvdb::BBoxd;
using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::Vec3d;
using test_fields::longestSide;
using test_fields::monitor;
using test_fields::NodeEvaluator;
using test_fields::noise;
using test_fields::specks;

FieldPlan planOf(const CoordBBox& domain) {
  FieldPlan plan = planBox({.voxelSize = 1, .box = BBoxd(domain.min().asVec3d(), domain.max().asVec3d())});
  plan.crumbs.emplace();
  return plan;
}

/// The same domain, of which these nodes are evaluated.
FieldPlan planOf(const CoordBBox& domain, const CoordBBox& window) {
  FieldPlan plan =
      planBox({.voxelSize = 1, .box = BBoxd(domain.min().asVec3d(), domain.max().asVec3d()), .window = window});
  plan.crumbs.emplace();
  return plan;
}

FractalField evaluatedAsPlanned(const julia::FieldEvaluator& evaluator, const FieldPlan& plan) {
  return evaluateField(plan, {evaluator, {}}, {}, monitor);
}

bool isInside(const julia::FieldEvaluator& evaluator, const Coord& node) {
  const julia::Point point{double(node[0]), double(node[1]), double(node[2])};
  double value = 0;
  evaluator.evaluate({&point, 1}, {&value, 1}, {});
  return value < 0;
}

/// The islands of all nodes in a box, by a flood from node to node.
std::vector<std::vector<Coord>> islandsIn(const julia::FieldEvaluator& evaluator, const CoordBBox& box) {
  std::map<Coord, bool> left;
  for (auto node = box.begin(); node; ++node)
    if (isInside(evaluator, *node)) left[*node] = true;
  std::vector<std::vector<Coord>> islands;
  while (!left.empty()) {
    std::vector<Coord> island = {left.begin()->first};
    left.erase(left.begin());
    for (std::size_t i = 0; i < island.size(); ++i)
      for (const Coord& step :
           {Coord(1, 0, 0), Coord(-1, 0, 0), Coord(0, 1, 0), Coord(0, -1, 0), Coord(0, 0, 1), Coord(0, 0, -1)})
        if (const auto at = left.find(island[i] + step); at != left.end()) {
          island.push_back(at->first);
          left.erase(at);
        }
    islands.push_back(std::move(island));
  }
  return islands;
}

struct Expected {
  std::set<Coord> inside;  ///< of the domain
  CrumbReport dropped;
};

/// @param isKept  of an island as small as a crumb
template <class IsKept>
Expected expectedOf(const julia::FieldEvaluator& evaluator, const CoordBBox& domain, const IsKept& isKept) {
  // An island that reaches from the domain to the end of this is longer than a crumb.
  CoordBBox around = domain;
  around.expand(kCrumb + 1);
  Expected expected;
  for (const std::vector<Coord>& island : islandsIn(evaluator, around)) {
    const bool kept = longestSide(island) > kCrumb || isKept(island);
    std::uint64_t within = 0;
    for (const Coord& node : island)
      if (domain.isInside(node)) {
        ++within;
        if (kept) expected.inside.insert(node);
      }
    if (kept || within == 0) continue;
    ++expected.dropped.crumbs;
    expected.dropped.nodes += within;
  }
  return expected;
}

Expected expectedOf(const julia::FieldEvaluator& evaluator, const CoordBBox& domain) {
  return expectedOf(evaluator, domain, [](const std::vector<Coord>&) { return false; });
}

void expectSame(const FractalField& field, const CoordBBox& nodes, const std::set<Coord>& inside) {
  const auto values = field.field->getConstAccessor();
  for (auto node = nodes.begin(); node; ++node) ASSERT_EQ(values.getValue(*node) < 0, inside.contains(*node)) << *node;
}

// Sparse specks, a sponge about to hang together (at 0.31 of the nodes), and one that does, with specks in its holes.
constexpr double kCrumbDensities[] = {0.02, 0.15, 0.22, 0.27, 0.31, 0.4};

// Promise: Crumbs, "pieces of at most ..."
TEST(Crumbs, AreTheSmallIslandsOfADenseFlood) {
  unsigned seed = 0;
  std::uint64_t large = 0;
  for (const Coord& middle : {Coord(0), Coord(68, -60, 4100)})
    for (const double density : kCrumbDensities) {
      SCOPED_TRACE(testing::Message() << "density " << density << " about " << middle);
      const NodeEvaluator evaluator = specks(density, ++seed);
      const CoordBBox domain(middle.offsetBy(-13), middle.offsetBy(11));
      const Expected expected = expectedOf(evaluator, domain);
      const FractalField field = evaluatedAsPlanned(evaluator, planOf(domain));
      expectSame(field, domain, expected.inside);
      EXPECT_EQ(field.crumbs.value().crumbs, expected.dropped.crumbs);
      EXPECT_EQ(field.crumbs.value().nodes, expected.dropped.nodes);
      EXPECT_GT(expected.dropped.crumbs, 20u);
      large += expected.inside.size();
    }
  EXPECT_GT(large, 10000u);
}

// Promise: Crumbs, "pieces of at most ..."
TEST(Crumbs, AreAsLongAsTheLongestAndNoLonger) {
  // Rods along each axis at all places in their blocks.
  for (int axis = 0; axis < 3; ++axis)
    for (int begin = 0; begin < 8; ++begin)
      for (const int length : {1, kCrumb - 1, kCrumb, kCrumb + 1, 2 * kCrumb}) {
        const auto isRod = [&](const Coord& node) {
          const int at = node[axis] - begin;
          return node[(axis + 1) % 3] == 5 && node[(axis + 2) % 3] == -8 && at >= 0 && at < length;
        };
        const NodeEvaluator evaluator([&](const Coord& node) { return isRod(node) ? -1.0 : 1.0; });
        const FractalField field = evaluatedAsPlanned(evaluator, planOf({Coord(-12), Coord(26)}));
        EXPECT_EQ(field.crumbs->crumbs, length <= kCrumb ? 1u : 0u) << axis << ' ' << begin << ' ' << length;
        EXPECT_EQ(field.crumbs->nodes, length <= kCrumb ? static_cast<unsigned>(length) : 0u);
      }
}

// Promise: Crumbs are "those of the whole ..."
TEST(Crumbs, OfWindowsAreThoseOfTheWholeAndAddUp) {
  std::mt19937 random(20261124);
  const CoordBBox domain(Coord(-17, -9, -21), Coord(20, 19, 16));
  for (const double density : kCrumbDensities) {
    SCOPED_TRACE(density);
    const NodeEvaluator evaluator = specks(density, static_cast<unsigned>(100 * density));
    const Expected expected = expectedOf(evaluator, domain);
    // Cuts at random places, between blocks and through them.
    std::vector<CoordBBox> tiles = {domain};
    for (int i = 0; i < 5; ++i) {
      const int axis = static_cast<int>(random() % 3);
      std::vector<CoordBBox> cut;
      for (const CoordBBox& tile : tiles) {
        const int sides = tile.dim()[axis];
        if (sides < 2 || random() % 4 == 0) {
          cut.push_back(tile);
          continue;
        }
        const int at = tile.min()[axis] + 1 + static_cast<int>(random() % static_cast<unsigned>(sides - 1));
        CoordBBox low = tile, high = tile;
        low.max()[axis] = at - 1;
        high.min()[axis] = at;
        cut.push_back(low);
        cut.push_back(high);
      }
      tiles = cut;
    }
    CrumbReport sum;
    for (const CoordBBox& tile : tiles) {
      CoordBBox window = tile;
      window.expand(static_cast<int>(random() % 6));
      FieldPlan plan = planOf(domain, window);
      plan.crumbs->counted = tile;
      const FractalField field = evaluatedAsPlanned(evaluator, plan);
      expectSame(field, plan.window, expected.inside);
      sum += field.crumbs.value();
    }
    EXPECT_EQ(sum.crumbs, expected.dropped.crumbs);
    EXPECT_EQ(sum.nodes, expected.dropped.nodes);
  }
}

// Promise: Crumbs, "pieces of at most ..."
TEST(Crumbs, StayWhereTheTargetDecidesANode) {
  const CoordBBox domain(Coord(-14), Coord(15));
  const auto exponent = openvdb::FloatGrid::create(1.0f);
  const auto decided = [](const Coord& node) { return noise(node, 77) < -0.8; };
  for (auto node = CoordBBox(Coord(-30), Coord(30)).begin(); node; ++node)
    exponent->tree().setValue(*node, decided(*node) ? -3.0f : -0.5f);
  for (const double density : {0.15, 0.27}) {
    const NodeEvaluator evaluator = specks(density, 5);
    const Expected expected = expectedOf(evaluator, domain, [&](const std::vector<Coord>& island) {
      return std::any_of(island.begin(), island.end(), decided);
    });
    FieldPlan plan = planOf(domain);
    plan.crumbs = CrumbRule{.exponent = exponent, .decided = -2};
    const FractalField field = evaluatedAsPlanned(evaluator, plan);
    expectSame(field, domain, expected.inside);
    EXPECT_EQ(field.crumbs->crumbs, expected.dropped.crumbs);
    EXPECT_GT(expected.inside.size(), 50u);
    EXPECT_GT(expected.dropped.crumbs, 50u);
  }
}

// What lies beyond is not known there, and a piece may belong to something larger.
// Promise: Crumbs, "pieces of at most ..."
TEST(Crumbs, StayAtTheBorderOfWhatIsKnown) {
  const CoordBBox domain(Coord(-14), Coord(15));
  const NodeEvaluator evaluator = specks(0.2, 9);
  CoordBBox within = domain;
  within.expand(-1);
  const std::vector<std::vector<Coord>> islands = islandsIn(evaluator, domain);
  std::set<Coord> inside;
  for (const std::vector<Coord>& island : islands)
    if (longestSide(island) > kCrumb ||
        std::any_of(island.begin(), island.end(), [&](const Coord& node) { return !within.isInside(node); }))
      inside.insert(island.begin(), island.end());
  FieldPlan plan = planOf(domain);
  plan.whole = domain;
  const FractalField field = evaluatedAsPlanned(evaluator, plan);
  expectSame(field, domain, inside);
  EXPECT_GT(field.crumbs->crumbs, 100u);
}

/// A fractal of a lumpy ball, with dust.
struct DustyFractal {
  DustyFractal() {
    constexpr double kVoxel = 1.0 / 40;
    const ExponentGridOptions options{12.0, -0.01, {3, 20}};
    const auto phi = test_fields::bandGrid(test_fields::lumpy, kVoxel, exteriorReach(options) + 8 * kVoxel);
    exponent = exponentGrid(makeTarget(phi, std::nullopt), FractalSpace{Vec3d(0), 1}, options, monitor);
    const auto map = std::make_shared<julia::ShapeModulus<float>>(
        makeExponentField<float>(exponent), test_fields::randomVersor(3, 8, 9, true), julia::DropAxis::K);
    evaluator = julia::makeFieldEvaluator<float>(map, {}, exponent.orbit);
  }
  FieldSource source() const { return {*evaluator, exponent.space}; }
  FieldPlan plan(const std::optional<BBoxd>& box = {}, double voxelSize = 1.0 / 90) const {
    FieldPlan plan = planShell(exponent, {.voxelSize = voxelSize, .box = box});
    plan.crumbs = CrumbRule{.exponent = exponent.grid, .decided = exponent.shellOfNodes.lower};
    return plan;
  }

  ExponentGrid exponent;
  std::unique_ptr<julia::FieldEvaluator> evaluator;
};

const BBoxd kBox(Vec3d(-0.2, -0.5, 0.0), Vec3d(0.25, 0.11, 0.43));

// Promise: Distances made layer by layer ...
// Promise of design.md: Crumbs are "those of the whole lattice": in streams, boxes and windows, with `--follow` and
//   `--exhaustive`
TEST(Crumbs, AreDroppedFromAStreamedMeshAsFromAHeldOne) {
  const DustyFractal fractal;
  for (const auto& box : {std::optional<BBoxd>(), std::optional(kBox)})
    for (const Border border : {Border::Cap, Border::Open}) {
      const FieldPlan plan = fractal.plan(box);
      const ExtractMeshOptions options{.border = border};
      const FractalField field = evaluateField(plan, fractal.source(), {}, monitor);
      EXPECT_GT(field.crumbs.value().crumbs, 20u) << "not much of a test";
      Mesh whole = extractMesh(field, fractal.source(), options, monitor);
      if (border == Border::Cap) {
        EXPECT_EQ(mesh_laws::notClosedManifold(whole), "");
      }
      computeNormals(whole);
      for (const std::size_t threads : {1u, 4u}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        Mesh streamed;
        MeshCollector collector(streamed);
        const MeshCounts counts = streamMesh(plan, fractal.source(), options, collector, monitor);
        EXPECT_EQ(streamed.points, whole.points);
        EXPECT_EQ(streamed.normals, whole.normals);
        EXPECT_EQ(streamed.triangles, whole.triangles);
        EXPECT_EQ(counts.crumbs.value().crumbs, field.crumbs->crumbs);
        EXPECT_EQ(counts.crumbs->nodes, field.crumbs->nodes);
      }
      if (border == Border::Open) continue;
      SolidMeter meter;
      const auto surface = streamSurface(plan, fractal.source(), options.tolerance, false, meter, monitor).levelSet;
      const auto expected = levelSet(field, whole, monitor);
      EXPECT_TRUE(surface->tree().hasSameTopology(expected->tree()));
      for (auto value = expected->cbeginValueAll(); value; ++value)
        ASSERT_EQ(surface->tree().getValue(value.getCoord()), *value) << value.getCoord();
    }
}

// Promise: Crumbs are "those of the whole ..."
TEST(Crumbs, LeaveABoxTheWholeCutOut) {
  const DustyFractal fractal;
  const FractalField whole = evaluateField(fractal.plan(), fractal.source(), {}, monitor);
  // The box's border goes through crumbs.
  std::mt19937 random(7);
  for (int i = 0; i < 4; ++i) {
    const Vec3d shift = Vec3d(random() % 9, random() % 9, random() % 9) / 90;
    const FieldPlan plan = fractal.plan(BBoxd(kBox.min() + shift, kBox.max() + shift));
    const FractalField part = evaluateField(plan, fractal.source(), {}, monitor);
    const auto inPart = part.field->getConstAccessor(), inWhole = whole.field->getConstAccessor();
    for (auto node = part.domain.begin(); node; ++node)
      ASSERT_EQ(inPart.getValue(*node) < 0, inWhole.getValue(*node) < 0) << *node;
  }
}

// Promise: Crumbs are "those of the whole ..."
TEST(Crumbs, TheExhaustiveFieldHasTheSameOnes) {
  const DustyFractal fractal;
  FieldPlan every = planExhaustive(fractal.exponent, {.voxelSize = 1.0 / 90});
  every.crumbs = fractal.plan().crumbs;
  const FractalField fast = evaluateField(fractal.plan(), fractal.source(), {}, monitor),
                     slow = evaluateField(every, fractal.source(), {.everyNode = true}, monitor);
  EXPECT_EQ(fast.crumbs->crumbs, slow.crumbs->crumbs);
  EXPECT_EQ(fast.crumbs->nodes, slow.crumbs->nodes);
  for (auto node = fast.domain.begin(); node; ++node)
    ASSERT_EQ(fast.field->tree().getValue(*node) < 0, slow.field->tree().getValue(*node) < 0) << *node;
}

// Promise: Crumbs are "those of the whole ..."
TEST(Crumbs, AreDroppedFromWhatIsFollowed) {
  const DustyFractal fractal;
  const FieldPlan plan = fractal.plan();
  FieldPlan all = plan;
  all.crumbs.reset();
  const FractalField whole = evaluateField(plan, fractal.source(), {}, monitor),
                     withCrumbs = evaluateField(all, fractal.source(), {}, monitor);
  FollowReport report;
  const FractalField followed =
      followSurface(plan, fractal.source(), {}, {.seedStride = 1, .probes = 10}, report, monitor);
  std::uint64_t crumbs = 0;
  for (auto node = whole.domain.begin(); node; ++node) {
    ASSERT_EQ(followed.field->tree().getValue(*node) < 0, whole.field->tree().getValue(*node) < 0) << *node;
    if (withCrumbs.field->tree().getValue(*node) < 0 && !(whole.field->tree().getValue(*node) < 0)) ++crumbs;
  }
  EXPECT_EQ(crumbs, whole.crumbs->nodes);
  EXPECT_EQ(followed.crumbs->crumbs, whole.crumbs->crumbs);
  EXPECT_FALSE(withCrumbs.crumbs.has_value());
}

}  // namespace
