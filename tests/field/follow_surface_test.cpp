// SPDX-License-Identifier: Apache-2.0
// The surface in pieces: while F is evaluated, and by following it from seeds. Both are held against the whole field.
#include "support/mesh_laws.h"
#include "support/same_bits.h"
#include "support/test_fields.h"

#include "vdbtools/field/lattice_options.h"
#include "vdbtools/surface/extract_mesh.h"
#include "vdbtools/surface/level_set.h"

#include "julia/quadratic_map.h"
#include "julia/shape_modulus.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <vector>

namespace {

using namespace vdbtools;
using openvdb::BBoxd;
using openvdb::Vec3d;

/// A fractal of a lumpy ball, from target to evaluator.
struct LumpyFractal {
  explicit LumpyFractal(double alpha, unsigned seed = 3) {
    constexpr double kVoxel = 1.0 / 40;
    const ExponentGridOptions options{alpha, 0.0, {3, 20}};
    const auto phi = test_fields::bandGrid(test_fields::lumpy, kVoxel, exteriorReach(options) + 8 * kVoxel);
    exponent = exponentGrid(makeTarget(phi, std::nullopt), FractalSpace{Vec3d(0), 1}, options, monitor);
    const auto map = std::make_shared<julia::ShapeModulus<float>>(
        makeExponentField<float>(exponent), test_fields::randomVersor(seed, 8, 9, true), julia::DropAxis::K);
    evaluator = julia::makeFieldEvaluator<float>(map, {}, exponent.orbit);
  }
  FieldSource source() const { return {*evaluator, exponent.space}; }

  Monitor monitor;
  ExponentGrid exponent;
  std::unique_ptr<julia::FieldEvaluator> evaluator;
};

Mesh collected(const auto& make) {
  Mesh mesh;
  MeshCollector collector(mesh);
  const MeshCounts counts = make(collector);
  EXPECT_EQ(counts.points, mesh.points.size());
  EXPECT_EQ(counts.triangles, mesh.triangles.size());
  return mesh;
}

using Positions = std::set<std::tuple<double, double, double>>;
Positions positions(const Mesh& mesh) {
  Positions all;
  for (const Vec3d& p : mesh.points) all.insert({p[0], p[1], p[2]});
  return all;
}

// Promise: A mesh that is written while ...
TEST(StreamMesh, IsTheMeshOfTheWholeField) {
  LumpyFractal fractal(20);
  for (const auto& box :
       {std::optional<BBoxd>(), std::optional(BBoxd(Vec3d(-0.2, -0.5, 0.0), Vec3d(0.25, 0.11, 0.43)))})
    for (const Border border : {Border::Cap, Border::Open}) {
      const FieldPlan plan = planShell(fractal.exponent, {.voxelSize = 1.0 / 60, .box = box});
      const ExtractMeshOptions options{.border = border};
      Mesh whole = extractMesh(evaluateField(plan, fractal.source(), {}, fractal.monitor), fractal.source(), options,
                               fractal.monitor);
      ASSERT_GT(whole.triangles.size(), 1000u);
      computeNormals(whole);
      for (const std::size_t threads : {1u, 4u}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        const Mesh streamed = collected(
            [&](MeshSink& sink) { return streamMesh(plan, fractal.source(), options, sink, fractal.monitor); });
        EXPECT_EQ(streamed.points, whole.points);
        EXPECT_EQ(streamed.normals, whole.normals);
        EXPECT_EQ(streamed.triangles, whole.triangles);
      }
    }
}

/// Every value of a grid, also of its tiles, and which are active.
struct GridContent {
  explicit GridContent(const openvdb::FloatGrid& grid) {
    for (auto value = grid.cbeginValueAll(); value; ++value) {
      nodes.push_back(value.getBoundingBox());
      values.push_back(*value);
      active.push_back(value.isValueOn());
    }
  }
  std::vector<openvdb::CoordBBox> nodes;
  std::vector<float> values;
  std::vector<bool> active;
};

/// The level set that is made on the way has the bits of the one that is made of the whole field and its whole mesh.
void expectLevelSetOfWhole(const FieldPlan& plan, const FieldSource& source) {
  Monitor monitor;
  const FractalField field = evaluateField(plan, source, {}, monitor);
  const CappedMesh capped = extractCappedMesh(field, source, 1e-3, monitor);
  ASSERT_GT(capped.mesh.triangles.size(), 500u);
  const auto whole = levelSet(field, capped.mesh, monitor);
  const GridContent expected(*whole);
  ASSERT_GT(std::count_if(expected.values.begin(), expected.values.end(), [](float d) { return d < 0; }), 100);
  const law_tests::KeepInstructionSet keep;
  for (const julia::InstructionSet set : julia::availableInstructionSets())
    for (const std::size_t threads : {1u, 4u}) {
      SCOPED_TRACE(testing::Message() << julia::nameOf(set) << ", " << threads << " threads");
      julia::setInstructionSet(set);
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      Mesh mesh;
      MeshCollector collector(mesh);
      const StreamedSurface streamed = streamSurface(plan, source, 1e-3, false, collector, monitor);
      EXPECT_EQ(mesh.points, capped.mesh.points);
      EXPECT_EQ(mesh.triangles, capped.mesh.triangles);
      ASSERT_TRUE(streamed.levelSet);
      const GridContent content(*streamed.levelSet);
      EXPECT_EQ(content.nodes, expected.nodes);
      EXPECT_EQ(content.active, expected.active);
      EXPECT_EQ(law_tests::bitsOf(content.values), law_tests::bitsOf(expected.values));
      EXPECT_EQ(streamed.levelSet->background(), whole->background());
      EXPECT_EQ(streamed.levelSet->transform(), whole->transform());
      EXPECT_EQ(streamed.levelSet->getName(), whole->getName());
      EXPECT_EQ(checkSurface(*streamed.levelSet).failure, "");
    }
}

// Promise of design.md: Distances made layer by layer are those to the whole mesh, "the same to the bit"
TEST(StreamSurface, ItsLevelSetIsThatOfTheWholeField) {
  for (const double alpha : {6.0, 20.0}) {
    LumpyFractal fractal(alpha);
    // At the finer one, proofs leave out blocks beside the surface.
    expectLevelSetOfWhole(planShell(fractal.exponent, {.voxelSize = alpha < 10 ? 1.0 / 60 : 1.0 / 110}),
                          fractal.source());
    // Caps, where the box cuts the set.
    const BBoxd box(Vec3d(-0.2, -0.5, 0.0), Vec3d(0.25, 0.11, 0.43));
    expectLevelSetOfWhole(planShell(fractal.exponent, {.voxelSize = 1.0 / 60, .box = box}), fractal.source());
  }
}

// Promise: Distances made layer by layer ...
TEST(StreamSurface, PiecesMayLieFarApartAndBlocksBesideThemMayBeLeftOut) {
  const std::vector<Vec3d> middles = {{-200.5, 3, 0}, {-163.1, 0, 5}, {7.3, -60, 0}, {7.9, 80.2, 0}, {40, 0, 90.7}};
  const double radius = 11.3;
  const auto value = [&](const Vec3d& at) {
    double least = 1e9;
    for (const Vec3d& middle : middles) least = std::min(least, (at - middle).length() - radius);
    return least;
  };
  const test_fields::NodeEvaluator evaluator([&](const openvdb::Coord& node) { return value(node.asVec3d()); });
  FieldPlan plan;
  plan.domain = plan.window = plan.whole = openvdb::CoordBBox(openvdb::Coord(-230), openvdb::Coord(120));
  plan.voxelSize = 1;
  plan.blocks = std::make_shared<openvdb::MaskTree>();
  // The blocks that the surfaces cross, or lie within a node of, and no other.
  const openvdb::CoordBBox blocks(plan.domain.min() >> 3, plan.domain.max() >> 3);
  for (auto block = blocks.begin(); block; ++block) {
    bool inside = false, outside = false;
    for (int k = 0; k < 10 * 10 * 10; ++k) {
      const double at = value(((*block << 3).offsetBy(k / 100 - 1, k / 10 % 10 - 1, k % 10 - 1)).asVec3d());
      (at < 0 ? inside : outside) = true;
    }
    if (inside && outside) plan.blocks->setValueOn(*block);
  }
  ASSERT_GT(plan.blocks->activeVoxelCount(), 100u);
  expectLevelSetOfWhole(plan, {evaluator, FractalSpace{}});
}

TEST(StreamMesh, ItsProgressEndsAtAll) {
  /// Adds up the steps of each phase.
  class Counter final : public Monitor {
   public:
    void begin(const Phase& phase, std::uint64_t total) override {
      mPhase = &phases[phase.text()];
      mPhase->total = total;
    }
    void advance(std::uint64_t steps) override { mPhase->done += steps; }
    struct Phase {
      std::uint64_t total = 0;
      std::atomic<std::uint64_t> done{0};
    };
    std::map<std::string, Phase> phases;

   private:
    Phase* mPhase = nullptr;
  };
  // Of a map whose proofs decide many blocks.
  const auto map = std::make_shared<julia::QuadraticMap<double>>(julia::Quaternion<double>{-0.2, 0.6, 0.2, 0.2});
  const auto evaluator = julia::makeFieldEvaluator<double>(map, {}, {.maxIterations = 8});
  const FieldPlan plan = planBox({.voxelSize = 1.0 / 50, .box = BBoxd(Vec3d(-2), Vec3d(2))});
  Counter counter;
  Mesh mesh;
  MeshCollector collector(mesh);
  const MeshCounts counts = streamMesh(plan, {*evaluator, {}}, {}, collector, counter);
  EXPECT_LT(counts.evaluatedNodes, 200u * 200 * 200 / 2) << "nothing was proved";
  ASSERT_TRUE(counter.phases.contains("surface"));
  for (const auto& [name, phase] : counter.phases) EXPECT_EQ(phase.done, phase.total) << name;
}

TEST(StreamMesh, ATriangleUsesNoPointBeforeItsFirst) {
  LumpyFractal fractal(20);
  struct Checker final : MeshSink {
    std::uint64_t points = 0, first = 0;
    void addPoints(const PointBatch& batch) override {
      EXPECT_EQ(batch.positions.size(), batch.normals.size());
      for (const openvdb::Vec3s& normal : batch.normals) EXPECT_NEAR(normal.length(), 1, 1e-5);
      points += batch.positions.size();
    }
    void addTriangles(std::span<const openvdb::Vec3I> triangles, std::uint64_t firstPoint) override {
      EXPECT_GE(firstPoint, first);
      first = firstPoint;
      for (const openvdb::Vec3I& triangle : triangles)
        for (int k = 0; k < 3; ++k) {
          ASSERT_GE(triangle[k], first);
          ASSERT_LT(triangle[k], points);
        }
    }
  } checker;
  const FieldPlan plan = planShell(fractal.exponent, {.voxelSize = 1.0 / 60});
  streamMesh(plan, fractal.source(), {}, checker, fractal.monitor);
  EXPECT_GT(checker.first, 0u) << "the writer could forget nothing";
}

// Promise: `--follow`: "What it finds ..."
TEST(FollowSurface, FindsNearlyAllAndNothingElse) {
  for (const double alpha : {12.0, 40.0}) {
    SCOPED_TRACE(alpha);
    LumpyFractal fractal(alpha);
    const FieldPlan plan = planShell(fractal.exponent, {.voxelSize = 1.0 / 100});
    const Mesh exact =
        extractMesh(evaluateField(plan, fractal.source(), {}, fractal.monitor), fractal.source(), {}, fractal.monitor);
    const Positions all = positions(exact);
    for (const int stride : {64, 8, 2}) {
      SCOPED_TRACE(stride);
      FollowReport report;
      const FractalField field =
          followSurface(plan, fractal.source(), {}, {.seedStride = stride}, report, fractal.monitor);
      const Mesh mesh = extractMesh(field, fractal.source(), {}, fractal.monitor);
      EXPECT_EQ(mesh_laws::notClosedManifold(mesh), "");
      const Positions found = positions(mesh);
      EXPECT_TRUE(std::includes(all.begin(), all.end(), found.begin(), found.end()));
      EXPECT_LE(report.visitedBlocks, report.shellBlocks);
      EXPECT_EQ(report.foundVertices, mesh.points.size());
      const double missed = 1 - static_cast<double>(found.size()) / static_cast<double>(all.size());
      // The probes are a sample: within a few per cent of the truth.
      EXPECT_NEAR(report.missedShare(), missed, 0.03);
      if (stride == 2) {
        EXPECT_LT(missed, 0.005);
      }
    }
  }
}

// Promise: `--follow`: "What it finds ..."
TEST(FollowSurface, LooksAtASmallPartOfALargeShell) {
  LumpyFractal fractal(12);
  const FieldPlan plan = planShell(fractal.exponent, {.voxelSize = 1.0 / 200});
  FollowReport report;
  followSurface(plan, fractal.source(), {}, {}, report, fractal.monitor);
  EXPECT_LT(report.visitedBlocks, report.shellBlocks / 3);
}

// Promise: `--follow`: "What it finds ..."
TEST(FollowSurface, IsClosedInABoxThatCutsTheSet) {
  const auto map = std::make_shared<julia::QuadraticMap<double>>(julia::Quaternion<double>{-0.2, 0.6, 0.2, 0.2});
  const auto evaluator = julia::makeFieldEvaluator<double>(map, {}, {.maxIterations = 8});
  const FieldSource source{*evaluator, {}};
  Monitor monitor;
  const FieldPlan plan = planBox({.voxelSize = 1.0 / 50, .box = BBoxd(Vec3d(-0.9, -0.8, -0.7), Vec3d(0.4, 0.5, 0.6))});
  FollowReport report;
  const FractalField field = followSurface(plan, source, {}, {}, report, monitor);
  const Mesh mesh = extractMesh(field, source, {.border = Border::Cap}, monitor);
  EXPECT_GT(mesh.triangles.size(), 1000u);
  EXPECT_EQ(mesh_laws::notClosedManifold(mesh), "");
  EXPECT_EQ(report.foundVertices, mesh.points.size());
}

TEST(FollowSurface, RefusesAStride) {
  LumpyFractal fractal(40);
  const FieldPlan plan = planShell(fractal.exponent, {.voxelSize = 1.0 / 20});
  FollowReport report;
  for (const int stride : {-1, 0, 3, 12, 128})
    EXPECT_THROW(followSurface(plan, fractal.source(), {}, {.seedStride = stride}, report, fractal.monitor),
                 std::invalid_argument)
        << stride;
}

}  // namespace
