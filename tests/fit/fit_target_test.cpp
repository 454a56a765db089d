// SPDX-License-Identifier: Apache-2.0
// The target of a fit against shapes whose distances are known, and under changes that must not matter.
#include "support/temporary_folder.h"
#include "support/test_fields.h"
#include "support/test_meshes.h"

#include "vdbtools/distance/mesh_to_sdf.h"
#include "vdbtools/fit/fit_target.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/formats/versor_file.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/mesh_files/mesh_writer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstring>
#include <random>
#include <sstream>

namespace {

using namespace vdbtools;
using namespace vdbtools::fit;
using julia::Point;
using openvdb::Vec3d;

const Vec3d kCentre(10, -20, 30);
constexpr double kRadius = 2;  // so the sphere's diameter is 1 in fractal space, and its radius 0.5

std::string objOf(const Mesh& mesh) {
  std::ostringstream obj;
  writeMesh(obj, mesh, {.format = &meshFormat(".obj")});
  return obj.str();
}

FitTarget targetOf(const Mesh& mesh, FitTargetOptions options) {
  const TemporaryFolder folder;
  options.input = folder.write("mesh.obj", objOf(mesh));
  Monitor monitor;
  return makeFitTarget(options, monitor);
}

const FitTarget& sphereTarget() {
  static const FitTarget target =
      targetOf(test_meshes::makeSphere(kRadius, 5, kCentre), {.resolution = 49, .triangles = 2000});
  return target;
}

double length(const Point& x) { return std::sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]); }

Mesh meshOf(const julia::TriangleSurface& surface) {
  Mesh mesh;
  for (const Point& p : surface.points) mesh.points.emplace_back(p[0], p[1], p[2]);
  for (const auto& t : surface.triangles) mesh.triangles.emplace_back(t[0], t[1], t[2]);
  return mesh;
}

TEST(FitTarget, CubeIsAboutTheBox) {
  const FitTarget& target = sphereTarget();
  EXPECT_NEAR(target.space.scale, 2 * kRadius, 1e-9);
  EXPECT_NEAR((target.space.centre - kCentre).length(), 0, 1e-9);
  EXPECT_NEAR(target.cell, 1.2 / 49, 1e-12);
  EXPECT_NEAR(length(target.cubeCentre), 0, 1e-12);
}

TEST(FitTarget, DistancesNearAndFar) {
  const FitTarget& target = sphereTarget();
  std::mt19937 random(1);
  const auto coordinate = [&] { return 2.4 * random() / 4294967295.0 - 1.2; };
  for (int n = 0; n < 20000; ++n) {
    const double x = coordinate(), y = coordinate(), z = coordinate();
    const double exact = length({x, y, z}) - 0.5, phi = target.distance({x, y, z});
    // The mesh's faces lie a hundredth of a cell within the sphere. Farther off, voxels grow to a third of the
    // distance, and round off the medial axis, the sphere's middle.
    const double tolerance = std::abs(exact) < 4 * target.cell     ? 0.05 * target.cell
                             : length({x, y, z}) < 8 * target.cell ? 3 * target.cell
                                                                   : 0.08 * std::abs(exact);
    ASSERT_NEAR(phi, exact, tolerance) << x << ' ' << y << ' ' << z;
    if (std::abs(exact) > 0.05 * target.cell) {
      ASSERT_EQ(target.inside({x, y, z}), exact < 0) << x << ' ' << y << ' ' << z;
    }
  }
}

TEST(FitTarget, DistancesGoOnBeyond) {
  const FitTarget& target = sphereTarget();
  EXPECT_NEAR(target.distance({5, 0, 0}), 4.5, 0.1);
  EXPECT_GE(target.distance({3, 4, 5}), length({3, 4, 5}) - 0.6);
  EXPECT_TRUE(std::isnan(target.distance({NAN, 0, 0})));
}

TEST(FitTarget, LevelsKeepTheFinerValues) {
  const FitTarget& target = sphereTarget();
  ASSERT_GT(target.levels.size(), 2u);
  for (std::size_t l = 1; l < target.levels.size(); ++l)
    for (auto value = target.levels[l - 1]->cbeginValueOn(); value; ++value) {
      const openvdb::Coord node = value.getCoord();
      if ((node[0] | node[1] | node[2]) & 1) continue;
      ASSERT_EQ(target.levels[l]->tree().getValue(node >> 1), *value) << node << " of level " << l - 1;
    }
}

TEST(FitTarget, AdaptiveCellsFillTheCube) {
  for (const double bandWidth : {2.0, 3.0, 5.0}) {
    const std::vector<julia::FitCell> cells = adaptiveCells(sphereTarget(), bandWidth);
    const double cube = std::pow(2 * 49, 3), ball = 4 * test_meshes::kPi / 3 * std::pow(0.5 / sphereTarget().cell, 3);
    double all = 0, within = 0;
    for (const julia::FitCell& cell : cells) {
      all += cell.volume;
      if (cell.phi < 0) within += cell.volume;
      EXPECT_NEAR(cell.phi, sphereTarget().distance(cell.x), 0.02 * sphereTarget().cell + 0.05 * std::abs(cell.phi));
    }
    EXPECT_NEAR(all, cube, 0.03 * cube) << bandWidth;
    EXPECT_NEAR(within, ball, 0.03 * ball) << bandWidth;
    EXPECT_LT(static_cast<double>(cells.size()), 0.1 * cube) << bandWidth;
  }
}

TEST(FitTarget, DenseCellsAreTheFinestNodes) {
  const FitTarget& target = sphereTarget();
  const std::vector<julia::FitCell> cells = denseCells(target, 49);
  ASSERT_EQ(cells.size(), 49u * 49u * 49u);
  EXPECT_NEAR(cells[0].x[0], -0.6 + target.cell / 2, 1e-12);
  EXPECT_NEAR(cells[1].x[2] - cells[0].x[2], target.cell, 1e-12);
  EXPECT_EQ(cells[1].x[0], cells[0].x[0]);
  for (const julia::FitCell& cell : cells) {
    const openvdb::FloatGrid& finest = *target.levels[0];
    const auto node = openvdb::Coord::round(finest.worldToIndex(target.space.toWorld(cell.x)));
    if (finest.tree().isValueOn(node)) {
      EXPECT_NEAR(cell.phi, finest.tree().getValue(node) / target.space.scale, 1e-6);
    }
  }
  double within = 0;
  for (const julia::FitCell& cell : denseCells(target, 20)) within += cell.phi < 0 ? cell.volume : 0;
  EXPECT_NEAR(within * std::pow(target.cell, 3), test_meshes::kPi / 6, 0.03);
}

TEST(FitTarget, SurfaceIsClosedAndNearTheSphere) {
  const Mesh mesh = meshOf(sphereTarget().surface);
  const MeshReport report = reportMesh(mesh);
  EXPECT_LE(report.triangles, 2000u);
  EXPECT_GE(report.triangles, 1900u);
  EXPECT_TRUE(report.closed());
  EXPECT_EQ(report.degenerateFaces, 0u);
  EXPECT_EQ(report.components, 1u);
  EXPECT_NEAR(report.volume, test_meshes::kPi / 6, 0.02);
  for (const Vec3d& p : mesh.points) EXPECT_NEAR(p.length(), 0.5, 0.5 * sphereTarget().cell);
  EXPECT_NO_THROW(julia::requireValid(sphereTarget().surface));
}

TEST(FitTarget, OffsetPointsAreAtTheirDistance) {
  const FitTarget& target = sphereTarget();
  for (const double distance : {-2 * target.cell, 0.0, 2 * target.cell, 10 * target.cell}) {
    const std::vector<Point> points = offsetPoints(target, 300, distance, 7);
    EXPECT_EQ(points.size(), 300u);
    for (const Point& x : points) {
      EXPECT_NEAR(target.distance(x), distance, 0.1 * target.cell);
      EXPECT_NEAR(length(x), 0.5 + distance, 0.5 * target.cell);
    }
  }
  EXPECT_FALSE(movedTo(target, {0.49, 0, 0}, -0.8)) << "a sphere of 0.5 has no inner offset of 0.8";
}

TEST(FitTarget, SameForAnyThreads) {
  std::vector<FitTarget> targets;
  for (const std::size_t threads : {1u, 2u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    targets.push_back(targetOf(test_meshes::makeCube(3), {.resolution = 32, .triangles = 500}));
  }
  EXPECT_EQ(targets[0].surface.points, targets[1].surface.points);
  EXPECT_EQ(targets[0].surface.triangles, targets[1].surface.triangles);
  std::vector<julia::FitCell> cells[2];
  for (const std::size_t t : {0u, 1u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, t + 1);
    cells[t] = adaptiveCells(targets[t]);
    const std::vector<julia::FitCell> dense = denseCells(targets[t], 32);
    cells[t].insert(cells[t].end(), dense.begin(), dense.end());
  }
  ASSERT_EQ(cells[0].size(), cells[1].size());
  EXPECT_EQ(std::memcmp(cells[0].data(), cells[1].data(), cells[0].size() * sizeof(julia::FitCell)), 0);
  EXPECT_EQ(offsetPoints(targets[0], 100, 0.1, 3), offsetPoints(targets[1], 100, 0.1, 3));
}

TEST(FitTarget, VdbIsLikeItsMesh) {
  const TemporaryFolder folder;
  const Mesh mesh = test_meshes::makeSphere(kRadius, 5, kCentre);
  Monitor monitor;
  const auto phi = meshToSdf(mesh, {.voxelSize = 0.04}, monitor);
  const auto path = folder.write("sphere.vdb", encodeVdb({phi}, {}));
  const FitTarget target = makeFitTarget({.input = path, .resolution = 49, .triangles = 2000}, monitor);
  EXPECT_NEAR(target.space.scale, sphereTarget().space.scale, 0.01);
  for (const julia::FitCell& cell : adaptiveCells(sphereTarget()))
    ASSERT_NEAR(target.distance(cell.x), cell.phi, 0.1 * target.cell + 0.05 * std::abs(cell.phi));
}

TEST(FitTarget, CavitiesOfAVdbStayAndThoseOfAMeshAreAsAskedFor) {
  constexpr double kHollow = 1.2;  // the radius of the cavity
  const Mesh shell = test_meshes::merged(test_meshes::makeSphere(kRadius, 4, kCentre),
                                         test_meshes::flipped(test_meshes::makeSphere(kHollow, 4, kCentre)));
  const TemporaryFolder folder;
  Monitor monitor;
  const auto phi = meshToSdf(shell, {.voxelSize = 0.05, .hollows = Hollows::Keep}, monitor);
  const auto vdb = folder.write("shell.vdb", encodeVdb({phi}, {}));
  FitTargetOptions options{.resolution = 40, .triangles = 2000};
  const auto expect = [](const FitTarget& target, bool isHollow) {
    const double within = 2 * target.cell * target.space.scale;
    for (const double radius : {0.0, 0.5, 1.0, 1.4, 1.6, 1.8, 2.2, 2.4}) {
      const Point x = target.space.toFractal(kCentre + Vec3d(0.6, 0, -0.8) * radius);
      const double wanted = isHollow ? std::max(radius - kRadius, kHollow - radius) : radius - kRadius;
      EXPECT_NEAR(target.distance(x) * target.space.scale, wanted, within + 0.05 * std::abs(wanted)) << radius;
    }
  };
  options.input = vdb;
  const FitTarget ofVdb = makeFitTarget(options, monitor);
  expect(ofVdb, true);
  EXPECT_TRUE(ofVdb.facts.empty());
  const FitTarget filled = targetOf(shell, options);
  expect(filled, false);
  EXPECT_EQ(filled.facts.at("julia_hollows_filled"), "1");
  options.mend.hollows = Hollows::Keep;
  const FitTarget kept = targetOf(shell, options);
  expect(kept, true);
  EXPECT_EQ(kept.facts.at("julia_hollows_kept"), "1");
}

TEST(FitTarget, SpaceIsTheFractals) {
  // An angle: its box's middle is outside, and the deepest node depends on the lattice.
  const Mesh angle =
      test_meshes::merged(test_meshes::makeBox({0, 0, 0}, {1, 1, 0.06}), test_meshes::makeBox({0, 0, 0}, {0.1, 1, 1}));
  const TemporaryFolder folder;
  const auto path = folder.write("angle.obj", objOf(angle));
  Monitor monitor;
  const auto map = folder.write("map.json", rationalToJson(test_fields::randomVersor(1, 3, 4, true), "", {}));
  const Scene scene = makeScene(
      parseFractalOptions({{"input", path.string()}, {"map", "rational"}, {"rational", map.string()}}), monitor);
  const FitTarget target = makeFitTarget({.input = path, .resolution = 40}, monitor);
  EXPECT_EQ(target.space.centre, scene.field.space.centre);
  EXPECT_EQ(target.space.scale, scene.field.space.scale);
  EXPECT_NEAR(length(target.cubeCentre), (Vec3d(0.5) - target.space.centre).length(), 1e-6);
}

TEST(FitTarget, ThinPlateKeepsItsInside) {
  const double cell = 1.2 / 60;
  const FitTarget target = targetOf(test_meshes::makeBox({0, 0, 0}, {1, 1, 2 * cell}), {.resolution = 60});
  double within = 0;
  for (const julia::FitCell& c : adaptiveCells(target)) within += c.phi < 0 ? c.volume : 0;
  EXPECT_NEAR(within * cell * cell * cell, 2 * cell, 0.3 * 2 * cell);
  const MeshReport report = reportMesh(meshOf(target.surface));
  EXPECT_TRUE(report.closed());
  EXPECT_EQ(report.components, 1u);
  EXPECT_NEAR(report.volume, 2 * cell, 0.3 * 2 * cell);
  EXPECT_TRUE(offsetPoints(target, 50, -2 * cell, 1).empty());
}

// A plate that is not in the middle of its box: the nodes of some coarse level are all outside it.
TEST(FitTarget, ThinPartsBetweenTheNodesOfCoarseLevels) {
  const Mesh shape = test_meshes::merged(test_meshes::makeBox({-1, -0.5, -0.25}, {1, 0.5, 0.25}),
                                         test_meshes::makeSphere(0.25, 3, {0.5, 0, 0.5}));
  for (const int resolution : {32, 33, 34}) {
    const FitTarget target = targetOf(shape, {.resolution = resolution, .triangles = 100});
    EXPECT_TRUE(target.inside({0, 0, -0.05})) << resolution;
    for (const Point& x : {Point{0, 0.5, 0}, Point{1, 1, 1}, Point{-1, -1, -1}})
      EXPECT_GT(target.distance(x), 0.05) << resolution;
  }
}

TEST(FitTarget, BunnySurfaceIsClosed) {
  if (!test_meshes::hasBunny()) GTEST_SKIP() << "no bunny here";
  Monitor monitor;
  const FitTarget target = makeFitTarget({.input = test_meshes::bunnyPath(), .resolution = 64}, monitor);
  const MeshReport report = reportMesh(meshOf(target.surface));
  EXPECT_TRUE(report.closed());
  EXPECT_EQ(report.degenerateFaces, 0u);
  EXPECT_LE(report.triangles, 5000u);
  EXPECT_GT(report.volume, 0);
  for (const Vec3d& p : meshOf(target.surface).points)
    EXPECT_LT(std::abs(target.distance({p[0], p[1], p[2]})), 0.6 * target.cell);
}

TEST(FitTarget, RefusesBadOptions) {
  const TemporaryFolder folder;
  const auto path = folder.write("cube.obj", objOf(test_meshes::makeCube()));
  Monitor monitor;
  for (const int resolution : {7, 1001})
    EXPECT_THROW(makeFitTarget({.input = path, .resolution = resolution}, monitor), std::invalid_argument);
  EXPECT_THROW(makeFitTarget({.input = path, .triangles = 99}, monitor), std::invalid_argument);
  EXPECT_THROW(makeFitTarget({.input = path, .smooth = -1}, monitor), std::invalid_argument);
  EXPECT_THROW(makeFitTarget({.input = folder.path() / "none.obj"}, monitor), MissingInputError);
  const auto open = folder.write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_THROW(makeFitTarget({.input = open}, monitor), DataError);
  EXPECT_THROW(adaptiveCells(sphereTarget(), 6), std::invalid_argument);
  EXPECT_THROW(denseCells(sphereTarget(), 0), std::invalid_argument);
}

}  // namespace
