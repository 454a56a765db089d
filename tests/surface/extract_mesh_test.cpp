// SPDX-License-Identifier: Apache-2.0
// Marching cubes: every configuration of corner signs and random fields give closed 2-manifolds that separate inside
// from outside, with vertices where the field changes sign.
#include "support/mesh_laws.h"
#include "support/test_fields.h"

#include "surface/edge_search.h"
#include "vdbtools/surface/extract_mesh.h"
#include "vdbtools/surface/level_set.h"

#include <gtest/gtest.h>

#include <tbb/global_control.h>

#include <cmath>
#include <functional>
#include <random>

namespace {

using namespace vdbtools;
using openvdb::BBoxd;
using openvdb::Coord;
using openvdb::Vec3d;
using test_fields::NodeEvaluator;
using test_fields::noise;

struct Extracted {
  FractalField field;
  Mesh mesh;
};

Extracted extract(const julia::FieldEvaluator& evaluator, const BBoxd& box, double tolerance = 1e-3,
                  Border border = Border::Cap) {
  Monitor monitor;
  const FieldSource source{evaluator, FractalSpace{}};
  Extracted result;
  result.field = fractalFieldEverywhere(source, {.voxelSize = 1, .box = box}, monitor);
  result.mesh = extractMesh(result.field, source, {.tolerance = tolerance, .border = border}, monitor);
  return result;
}

// Promise: A mesh is "closed, 2-manifold, oriented ..."
TEST(ExtractMesh, AllCornerSignsGiveClosedManifolds) {
  openvdb::initialize();
  for (unsigned signs = 0; signs < 256; ++signs) {
    SCOPED_TRACE(testing::Message() << "corner signs " << signs);
    // Across the corner of eight leaves, so that every neighbour is met.
    const NodeEvaluator evaluator([&](const Coord& node) {
      const Coord c = node - Coord(7);
      const bool corner = c[0] >= 0 && c[0] <= 1 && c[1] >= 0 && c[1] <= 1 && c[2] >= 0 && c[2] <= 1;
      return corner && (signs >> (c[0] + 2 * c[1] + 4 * c[2]) & 1) ? -1.0 : 1.0;
    });
    const Extracted result = extract(evaluator, BBoxd(Vec3d(5), Vec3d(10)));
    EXPECT_EQ(mesh_laws::notClosedManifold(result.mesh), "");
    if (signs == 0)
      EXPECT_TRUE(result.mesh.triangles.empty());
    else
      EXPECT_GT(mesh_laws::volume(result.mesh), 0) << "oriented inward";
  }
}

// Promise: A mesh is "closed, 2-manifold, oriented ..."
TEST(ExtractMesh, RandomFieldsGiveClosedManifolds) {
  for (unsigned seed = 1; seed <= 24; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const double bias = 0.05 * (seed % 12) - 0.3;  // from sparse specks to a sponge with specks of air
    const NodeEvaluator evaluator([&](const Coord& node) { return noise(node, seed) + bias; });
    const Extracted result = extract(evaluator, BBoxd(Vec3d(-9), Vec3d(10)));
    ASSERT_GT(result.mesh.triangles.size(), 100u);
    EXPECT_EQ(mesh_laws::notClosedManifold(result.mesh), "");
  }
}

// Promise of design.md: "Every vertex is within the tolerance of *a* change of sign on its edge"
TEST(ExtractMesh, EveryVertexBracketsAChangeOfSign) {
  for (const double tolerance : {0.1, 1e-3, 1e-7}) {
    const NodeEvaluator evaluator([](const Coord& node) { return noise(node, 99); });
    const Extracted result = extract(evaluator, BBoxd(Vec3d(-9), Vec3d(10)), tolerance, Border::Open);
    ASSERT_GT(result.mesh.points.size(), 1000u);
    for (const Vec3d& point : result.mesh.points) {
      const mesh_laws::OnEdge edge = mesh_laws::onEdge(point, 1);
      ASSERT_GE(edge.axis, 0) << point << " lies on no lattice edge";
      Vec3d before = point, after = point;
      // Not past the edge's ends: the next edge may have a change of its own.
      before[edge.axis] = std::max(point[edge.axis] - tolerance, static_cast<double>(edge.node[edge.axis]));
      after[edge.axis] = std::min(point[edge.axis] + tolerance, edge.node[edge.axis] + 1.0);
      const julia::Point ends[2] = {{before[0], before[1], before[2]}, {after[0], after[1], after[2]}};
      double field[2];
      evaluator.evaluate(ends, field, {});
      EXPECT_NE(field[0] < 0, field[1] < 0) << point << " tolerance " << tolerance;
    }
  }
}

/// F along the edge from 0 to 1 in x. It follows the bracket that its own signs leave, and counts what it is asked.
class WatchedEdge final : public julia::FieldEvaluator {
 public:
  explicit WatchedEdge(std::function<double(double)> value) : mValue(std::move(value)) {}

  void evaluate(std::span<const julia::Point> points, std::span<double> field, std::span<int>) const override {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double at = points[i][0];
      EXPECT_TRUE(mLow <= at && at <= mHigh) << at << " is not from " << mLow << " to " << mHigh;
      field[i] = mValue(at);
      ((field[i] < 0) == (mValue(0) < 0) ? mLow : mHigh) = at;
      ++mAsked;
    }
  }
  void orbitTraps(std::span<const julia::Point>, std::span<double> nearest) const override {
    std::fill(nearest.begin(), nearest.end(), 0.0);
  }
  void versors(std::span<const julia::Point>, std::span<julia::Quaternion<double>> versors) const override {
    std::fill(versors.begin(), versors.end(), julia::Quaternion<double>::one());
  }
  int asked() const { return mAsked; }

 private:
  std::function<double(double)> mValue;
  mutable double mLow = 0, mHigh = 1;
  mutable int mAsked = 0;
};

// Promise of design.md: The search on an edge stays in its bracket, "and never needs more than two evaluations above
//   bisection"
TEST(ExtractMesh, ASearchKeepsToItsBracketAndTakesAtMostTwoEvaluationsMoreThanBisection) {
  std::mt19937_64 random(5);
  for (int round = 0; round < 200; ++round) {
    const double zero = 1e-3 + 0.998 * std::ldexp(static_cast<double>(random() >> 11), -53);
    const std::function<double(double)> fields[] = {
        [=](double t) { return t - zero; },
        [=](double t) { return t < zero ? -1.0 : 1.0; },
        [=](double t) { return t < zero ? -1e-9 : 1e9; },
        [=](double t) { return std::pow(t - zero, 9); },
        [=](double t) { return std::exp(30 * t) - std::exp(30 * zero); },
        [=](double t) { return t - zero + 0.9 * std::sin(60 * t) * t * (1 - t); },
    };
    for (const auto& value : fields)
      for (const double tolerance : {0.1, 1e-3, 1e-7}) {
        if ((value(0) < 0) == (value(1) < 0)) continue;
        const WatchedEdge evaluator(value);
        const LatticeEdge edge{Coord(0), 0, static_cast<float>(value(0)), static_cast<float>(value(1))};
        const FieldSource source{evaluator, FractalSpace{}};
        searchEdges({edge}, 1, source, tolerance);
        EXPECT_LE(evaluator.asked(), std::ceil(std::log2(1 / (2 * tolerance))) + 2) << zero << ' ' << tolerance;
      }
  }
}

// Promise: "Every vertex is within the tolerance ..."
TEST(ExtractMesh, EveryCrossingEdgeOfTheDomainHasItsVertex) {
  const NodeEvaluator evaluator([](const Coord& node) { return noise(node, 7) + 0.2; });
  const openvdb::CoordBBox domain(Coord(-9), Coord(10));
  const Extracted result = extract(evaluator, BBoxd(Vec3d(-9), Vec3d(10)), 1e-3, Border::Open);
  std::size_t crossings = 0;
  for (auto node = domain.begin(); node; ++node)
    for (int axis = 0; axis < 3; ++axis) {
      Coord end = *node;
      ++end[axis];
      if (domain.isInside(end) && (noise(*node, 7) + 0.2 < 0) != (noise(end, 7) + 0.2 < 0)) ++crossings;
    }
  EXPECT_EQ(result.mesh.points.size(), crossings);
}

// Promise: "With `--box` it ends at the box" ...
TEST(ExtractMesh, OpenEdgesLieOnTheDomainsBorderOnly) {
  const NodeEvaluator evaluator([](const Coord& node) { return noise(node, 3); });
  const Extracted result = extract(evaluator, BBoxd(Vec3d(-9), Vec3d(10)), 1e-3, Border::Open);
  const auto edges = mesh_laws::directedEdges(result.mesh);
  std::size_t open = 0;
  for (const auto& [edge, count] : edges) {
    ASSERT_EQ(count, 1);
    if (edges.contains({edge.second, edge.first})) continue;
    ++open;
    bool onBorder = false;
    for (int axis = 0; axis < 3; ++axis)
      for (const double face : {-9.0, 10.0})
        onBorder =
            onBorder || (result.mesh.points[edge.first][axis] == face && result.mesh.points[edge.second][axis] == face);
    EXPECT_TRUE(onBorder) << result.mesh.points[edge.first] << " " << result.mesh.points[edge.second];
  }
  EXPECT_GT(open, 0u);
}

// Promise of design.md: "neither tiles nor threads nor batches leave a trace" in a mesh
TEST(ExtractMesh, TheMeshOfPartIsPartOfTheMesh) {
  const NodeEvaluator evaluator([](const Coord& node) { return noise(node, 5); });
  const Extracted whole = extract(evaluator, BBoxd(Vec3d(-9), Vec3d(10)), 1e-3, Border::Open);
  const Extracted part = extract(evaluator, BBoxd(Vec3d(-3, -5, 1), Vec3d(8, 9, 10)), 1e-3, Border::Open);
  std::set<std::tuple<double, double, double>> points;
  for (const Vec3d& p : whole.mesh.points) points.insert({p[0], p[1], p[2]});
  for (const Vec3d& p : part.mesh.points) EXPECT_TRUE(points.contains({p[0], p[1], p[2]})) << p;
}

TEST(ExtractMesh, WithoutItsCapsACappedMeshIsTheOpenOne) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const NodeEvaluator evaluator([&](const Coord& node) { return noise(node, seed) + 0.1 * seed - 0.2; });
    const FieldSource source{evaluator, FractalSpace{}};
    // Also domains that are thin, down to one node.
    for (const BBoxd& box : {BBoxd(Vec3d(-9), Vec3d(10)), BBoxd(Vec3d(-3, -5, 1), Vec3d(8, 9, 2)),
                             BBoxd(Vec3d(0, 0, 0), Vec3d(1, 1, 1)), BBoxd(Vec3d(-9, -9, 3.75), Vec3d(9, 9, 4.25))}) {
      Monitor monitor;
      const FractalField field = fractalFieldEverywhere(source, {.voxelSize = 1, .box = box}, monitor);
      const Mesh open = extractMesh(field, source, {.border = Border::Open}, monitor);
      const CappedMesh capped = extractCappedMesh(field, source, 1e-3, monitor);
      const Mesh whole = extractMesh(field, source, {.border = Border::Cap}, monitor);
      EXPECT_EQ(capped.mesh.points, whole.points);
      EXPECT_EQ(capped.mesh.triangles, whole.triangles);
      ASSERT_EQ(capped.onCap.size(), whole.points.size());
      const Mesh derived = withoutCaps(capped);
      EXPECT_EQ(derived.points, open.points) << seed << ' ' << box;
      EXPECT_EQ(derived.triangles, open.triangles) << seed << ' ' << box;
    }
  }
}

// Promise: "neither tiles nor threads ..."
TEST(ExtractMesh, ThreadsDoNotMatter) {
  const NodeEvaluator evaluator([](const Coord& node) { return noise(node, 11); });
  Mesh meshes[2];
  for (const int threads : {1, 2}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    meshes[threads - 1] = extract(evaluator, BBoxd(Vec3d(-20), Vec3d(20))).mesh;
  }
  EXPECT_EQ(meshes[0].points, meshes[1].points);
  EXPECT_EQ(meshes[0].triangles, meshes[1].triangles);
}

TEST(ExtractMesh, RefusesATolerance) {
  const NodeEvaluator evaluator([](const Coord&) { return 1.0; });
  for (const double tolerance : {0.0, -1.0, 0.6, std::nan("")})
    EXPECT_THROW(extract(evaluator, BBoxd(Vec3d(0), Vec3d(2)), tolerance), std::invalid_argument) << tolerance;
}

TEST(ComputeNormals, PointAwayFromTheMiddleOfABall) {
  const NodeEvaluator evaluator([](const Coord& node) { return node.asVec3d().length() - 8; });
  Extracted result = extract(evaluator, BBoxd(Vec3d(-12), Vec3d(12)));
  computeNormals(result.mesh);
  ASSERT_EQ(result.mesh.normals.size(), result.mesh.points.size());
  for (std::size_t i = 0; i < result.mesh.points.size(); ++i) {
    const Vec3d normal(result.mesh.normals[i]);
    EXPECT_NEAR(normal.length(), 1, 1e-6);
    EXPECT_GT(normal.dot(result.mesh.points[i].unit()), 0.9);
  }
}

TEST(MeshOfLevelSet, IsTheBallOfADistance) {
  const auto ball = [](const Vec3d& x) { return x.length() - 1; };
  Monitor monitor;
  // Narrow and dense, the latter cut off by its border: both closed, in world space.
  const double h = 0.05;
  const auto narrow = test_fields::bandGrid([](const Vec3d& x) { return x.length() - 0.5; }, h, 0.15, 0.15);
  const Mesh mesh = meshOfLevelSet(*narrow, monitor);
  EXPECT_EQ(mesh_laws::notClosedManifold(mesh), "");
  // A polyhedron inscribed to second order: relative errors of (h/r)^2.
  const double ratio = h / 0.5;
  EXPECT_NEAR(mesh_laws::volume(mesh) / (4 * M_PI / 3 * 0.125), 1, ratio * ratio);
  const auto dense = test_fields::denseGrid(ball, 0.1, {Coord(-15), Coord(15)}, Vec3d(100, 0, -7));
  const auto centred = test_fields::denseGrid(ball, 0.1, {Coord(-15), Coord(15)});
  centred->setTransform(dense->transformPtr());
  const Mesh moved = meshOfLevelSet(*centred, monitor);
  EXPECT_EQ(mesh_laws::notClosedManifold(moved), "");
  Vec3d middle(0);
  for (const Vec3d& p : moved.points) middle += p / static_cast<double>(moved.points.size());
  EXPECT_NEAR((middle - Vec3d(100, 0, -7)).length(), 0, 1e-6);
}

TEST(MeshOfLevelSet, AMirroredGridStillFacesOutward) {
  const auto grid = test_fields::denseGrid([](const Vec3d& x) { return x.length() - 1; }, 0.1, {Coord(-15), Coord(15)});
  grid->setTransform(openvdb::math::Transform::createLinearTransform(
      openvdb::Mat4R(-0.1, 0., 0., 0., 0., 0.1, 0., 0., 0., 0., 0.1, 0., 0., 0., 0., 1.)));
  Monitor monitor;
  EXPECT_GT(mesh_laws::volume(meshOfLevelSet(*grid, monitor)), 4);
}

TEST(MeshOfLevelSet, RefusesAGridWithoutASurface) {
  Monitor monitor;
  EXPECT_THROW(meshOfLevelSet(*openvdb::FloatGrid::create(1), monitor), DataError);
  const auto broken = openvdb::FloatGrid::create(1);
  broken->tree().setValue(Coord(0), std::nanf(""));
  EXPECT_THROW(meshOfLevelSet(*broken, monitor), DataError);
}

// A thick shell: its hollow is outside, though no flood from outside reaches it.
// Promise of targets.md: Distances of `sdf` of a VDB "are exact for that surface at any distance", "at its own voxels,
//   with its own signs"
TEST(Redistanced, IsExactAtAnyWidthAndKeepsTheSigns) {
  const auto shell = [](const Vec3d& x) { return std::abs(x.length() - 0.4) - 0.15; };
  const double h = 0.025, reach = 10 * h;
  Monitor monitor;
  const auto narrow = test_fields::bandGrid(shell, h, 3 * h, 3 * h);
  const openvdb::FloatGrid::Ptr wide = redistanced(*narrow, 10, monitor);
  EXPECT_EQ(wide->transform(), narrow->transform());
  EXPECT_FLOAT_EQ(wide->background(), static_cast<float>(reach));
  // The mesh is inscribed in spheres of radii of 0.25 and more.
  const double sagitta = h * h / 0.25;
  std::size_t known = 0;
  for (auto value = wide->cbeginValueOn(); value; ++value) {
    const double exact = shell(wide->indexToWorld(value.getCoord()));
    ASSERT_NEAR(*value, exact, sagitta) << value.getCoord();
    ASSERT_EQ(*value < 0, narrow->tree().getValue(value.getCoord()) < 0) << value.getCoord();
    ++known;
  }
  std::size_t within = 0;
  for (auto node = openvdb::CoordBBox(Coord(-40), Coord(40)).begin(); node; ++node)
    within += shell(wide->indexToWorld(*node)) < reach;
  EXPECT_NEAR(static_cast<double>(known), static_cast<double>(within), 0.02 * static_cast<double>(within));
  EXPECT_NEAR(wide->tree().getValue(Coord(0)), reach, sagitta) << "in the hollow";
  EXPECT_GT(wide->tree().getValue(Coord(300)), 0);
  EXPECT_EQ(checkSurface(*wide).failure, "");
}

TEST(Redistanced, RefusesWhatItCannotMeasure) {
  Monitor monitor;
  const auto ball = test_fields::bandGrid([](const Vec3d& x) { return x.length() - 0.5; }, 0.05, 0.15, 0.15);
  EXPECT_THROW(redistanced(*ball, 1, monitor), std::invalid_argument);
  EXPECT_THROW(redistanced(*openvdb::FloatGrid::create(1), 3, monitor), DataError);
  const auto flat = ball->deepCopy();
  flat->setTransform(openvdb::math::Transform::createLinearTransform(
      openvdb::Mat4R(0.1, 0., 0., 0., 0., 0.05, 0., 0., 0., 0., 0.1, 0., 0., 0., 0., 1.)));
  EXPECT_THROW(redistanced(*flat, 3, monitor), DataError);
}

TEST(MeshOfLevelSet, TilesOfOneSignTakeNoMemory) {
  Monitor monitor;
  for (const float value : {0.5f, 0.0f, -0.5f}) {
    const auto grid = openvdb::FloatGrid::create(value);
    grid->tree().addTile(2, openvdb::Coord(0), value, true);  // 4096^3 voxels, which no machine of these days holds
    try {
      meshOfLevelSet(*grid, monitor);
      FAIL() << value;
    } catch (const DataError& error) {
      EXPECT_NE(std::string(error.what()).find("no surface"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
