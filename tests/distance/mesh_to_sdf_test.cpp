// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/distance/mesh_to_sdf.h"
#include "vdbtools/repair/mesh_repair.h"

#include "support/interrupting.h"
#include "support/test_meshes.h"
#include "vdbtools/base/errors.h"

#include <gtest/gtest.h>
#include <openvdb/tools/GridOperators.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/LevelSetMeasure.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

namespace {

using namespace test_meshes;
using openvdb::Coord;
using openvdb::FloatGrid;
using test_monitors::Interrupting;
using vdbtools::DataError;
using vdbtools::meshToSdf;
using vdbtools::MeshToSdfOptions;
using vdbtools::Monitor;
using vdbtools::repairedMeshToSdf;
using vdbtools::RepairedSdf;

class MeshToSdf : public testing::Test {
 protected:
  static void SetUpTestSuite() { openvdb::initialize(); }
};
using RepairedMeshToSdf = MeshToSdf;

MeshToSdfOptions withVoxelSize(double h, double exterior = 3, double interior = 3) { return {h, exterior, interior}; }

FloatGrid::Ptr convert(const Mesh& mesh, const MeshToSdfOptions& options) {
  Monitor monitor;
  return meshToSdf(mesh, options, monitor);
}

RepairedSdf repaired(const Mesh& mesh, double h, double gap = 0) {
  Monitor monitor;
  return repairedMeshToSdf(mesh, withVoxelSize(h), {gap}, monitor);
}

/// Of the nodes with phi < 0.
double insideVolume(const FloatGrid& grid) {
  double nodes = 0;
  for (auto it = grid.cbeginValueAll(); it; ++it) {
    if (*it < 0) nodes += static_cast<double>(it.getVoxelCount());
  }
  return nodes * std::pow(grid.voxelSize()[0], 3);
}

/// The largest difference, in voxels, from @a phi over the active nodes.
double largestError(const FloatGrid& grid, const std::function<double(const Vec3d&)>& phi) {
  double largest = 0;
  for (auto it = grid.cbeginValueOn(); it; ++it) {
    largest = std::max(largest, std::abs(*it - phi(grid.indexToWorld(it.getCoord()))));
  }
  return largest / grid.voxelSize()[0];
}

/// Every node, tile and background the same, bit for bit; values of @a b times @a scale, @a b moved by @a shift.
testing::AssertionResult sameField(const FloatGrid& a, const FloatGrid& b, float scale = 1, const Coord& shift = {}) {
  if (a.activeVoxelCount() != b.activeVoxelCount()) {
    return testing::AssertionFailure() << a.activeVoxelCount() << " and " << b.activeVoxelCount() << " active nodes";
  }
  if (a.background() != scale * b.background()) return testing::AssertionFailure() << "backgrounds differ";
  const auto other = b.getConstAccessor();
  std::uint64_t seen = 0;
  for (auto it = a.cbeginValueAll(); it; ++it, ++seen) {
    const Coord at = it.getCoord() - shift;
    if (*it != scale * other.getValue(at) || it.isValueOn() != other.isValueOn(at)) {
      return testing::AssertionFailure() << it.getCoord() << ": " << *it << " and " << scale * other.getValue(at);
    }
  }
  std::uint64_t values = 0;
  for (auto it = b.cbeginValueAll(); it; ++it) ++values;
  if (values != seen) return testing::AssertionFailure() << seen << " and " << values << " values";
  return testing::AssertionSuccess();
}

/// The text of the DataError that @a work ends with, which offers @a remedy and names no option of the command line.
std::string refusal(const std::function<void()>& work, std::optional<vdbtools::Remedy> remedy = {}) {
  try {
    work();
  } catch (const DataError& error) {
    if (remedy) {
      EXPECT_EQ(error.remedy(), *remedy) << error.what();
    }
    EXPECT_EQ(std::string(error.what()).find("--"), std::string::npos) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "was not refused";
  return {};
}

// Promise: A node "has the distance ..."
TEST_F(MeshToSdf, SphereIsTheDistanceToASphere) {
  constexpr double h = 0.04;
  const Vec3d center(0.3, -1.7, 2.2);
  const FloatGrid::Ptr grid = convert(makeSphere(1, 5, center), withVoxelSize(h));
  EXPECT_EQ(grid->getGridClass(), openvdb::GRID_LEVEL_SET);
  EXPECT_EQ(grid->getName(), "phi");
  EXPECT_TRUE(grid->transform().isLinear());
  EXPECT_EQ(grid->indexToWorld(Coord(0)), Vec3d(0));
  EXPECT_DOUBLE_EQ(grid->voxelSize()[0], h);
  EXPECT_FLOAT_EQ(grid->background(), static_cast<float>(3 * h));
  // The chords of the faces are 0.001 off the sphere at most, and OpenVDB's renormalisation moves values a little.
  EXPECT_LT(largestError(*grid, [&](const Vec3d& p) { return (p - center).length() - 1; }), 0.25);
  EXPECT_NEAR(insideVolume(*grid), 4 * kPi / 3, 0.01 * 4 * kPi / 3);
  EXPECT_NEAR(openvdb::tools::levelSetArea(*grid), 4 * kPi, 0.02 * 4 * kPi);
  EXPECT_FLOAT_EQ(grid->tree().getValue(Coord::round(center / h)), static_cast<float>(-3 * h)) << "flood filled";
}

TEST_F(MeshToSdf, GradientHasUnitLength) {
  const FloatGrid::Ptr grid = convert(makeSphere(1, 5), withVoxelSize(0.04, 4, 4));
  const auto length = openvdb::tools::magnitude(*openvdb::tools::gradient(*grid));
  const auto phi = grid->getConstAccessor();
  int nodes = 0;
  double worst = 0;
  for (auto it = length->cbeginValueOn(); it; ++it) {
    if (std::abs(phi.getValue(it.getCoord())) > 2.5 * 0.04) continue;  // the stencil leaves the band
    ++nodes;
    worst = std::max(worst, std::abs(*it - 1.0));
  }
  EXPECT_GT(nodes, 10000);
  EXPECT_LT(worst, 0.15);
}

// Promise: A node "has the distance ..."
TEST_F(MeshToSdf, CubeIsTheDistanceToACube) {
  constexpr double h = 0.05;
  const FloatGrid::Ptr grid = convert(makeCube(2, Vec3d(0.011)), withVoxelSize(h));
  const auto distance = [](const Vec3d& p) {
    const Vec3d q = Vec3d(std::abs(p[0] - 0.011), std::abs(p[1] - 0.011), std::abs(p[2] - 0.011)) - Vec3d(1);
    const Vec3d out(std::max(q[0], 0.0), std::max(q[1], 0.0), std::max(q[2], 0.0));
    return out.length() + std::min(std::max({q[0], q[1], q[2]}), 0.0);
  };
  EXPECT_LT(largestError(*grid, distance), 0.35);
  EXPECT_NEAR(insideVolume(*grid), 8, 24 * h / 2);
}

// Nor does rounding decide which side they are on.
TEST_F(MeshToSdf, NodesOnTheSurfaceAreNotInside) {
  for (const double first : {0.0, 0.7, -3.5, 100.1})
    for (const int steps : {7, 12, 20}) {
      const double h = 0.7 / steps;
      const Vec3d low(first, 2 * first, 0.7);
      const FloatGrid::Ptr grid = convert(makeBox(low, low + Vec3d(2.1, 0.7, 1.4)), withVoxelSize(h, 3, 2 * steps));
      const double inside = (3 * steps - 1) * (steps - 1) * (2 * steps - 1);
      EXPECT_NEAR(insideVolume(*grid) / (h * h * h), inside, 1e-6) << first << ' ' << steps;
    }
}

TEST_F(MeshToSdf, BandsAreAsWideAsAskedFor) {
  constexpr double h = 0.05;
  const Mesh sphere = makeSphere(1, 4);
  const auto extremes = [](const FloatGrid& grid) {
    std::pair<double, double> range{0, 0};
    for (auto it = grid.cbeginValueOn(); it; ++it) {
      range = {std::min(range.first, double{*it}), std::max(range.second, double{*it})};
    }
    return range;
  };
  const auto [low, high] = extremes(*convert(sphere, withVoxelSize(h, 6, 2)));
  EXPECT_NEAR(high / h, 6, 0.3);
  EXPECT_NEAR(low / h, -2, 0.3);
  const FloatGrid::Ptr whole = convert(sphere, withVoxelSize(h, 3, std::numeric_limits<double>::infinity()));
  EXPECT_NEAR(extremes(*whole).first, -1, h);
  EXPECT_LT(largestError(*whole, [](const Vec3d& p) { return p.length() - 1; }), 0.25);
  for (auto it = whole->cbeginValueAll(); it; ++it) {
    ASSERT_TRUE(std::isfinite(*it)) << it.getCoord();
    if (*it < 0) {
      ASSERT_TRUE(it.isValueOn()) << it.getCoord() << ": the whole inside has distances";
    }
  }
}

// Promise: A closed mesh "may be oriented ..."
TEST_F(MeshToSdf, OrientationDoesNotMatter) {
  const Mesh sphere = makeSphere(1, 4);
  const FloatGrid::Ptr outward = convert(sphere, withVoxelSize(0.05));
  const FloatGrid::Ptr inward = convert(flipped(sphere), withVoxelSize(0.05));
  EXPECT_NEAR(insideVolume(*inward), insideVolume(*outward), 1e-3);
  EXPECT_LT(largestError(*inward, [](const Vec3d& p) { return p.length() - 1; }), 0.15);
}

// Promise: "the same for a target of any ..."
TEST_F(MeshToSdf, ScaleDoesNotMatter) {
  const Mesh sphere = makeSphere(1, 4);
  const FloatGrid::Ptr grid = convert(sphere, withVoxelSize(0.0625));
  for (const double scale : {std::ldexp(1.0, -12), std::ldexp(1.0, 20)}) {
    const FloatGrid::Ptr scaled = convert(transformed(sphere, scale, Vec3d(0)), withVoxelSize(0.0625 * scale));
    EXPECT_TRUE(sameField(*scaled, *grid, static_cast<float>(scale))) << scale;
  }
}

// Promise: "the same for a target of any ..."
TEST_F(MeshToSdf, PlaceDoesNotMatter) {
  constexpr double h = 0.0625;
  Mesh sphere = makeSphere(1, 4);
  for (Vec3d& p : sphere.points) {
    for (int c = 0; c < 3; ++c) p[c] = std::ldexp(std::round(std::ldexp(p[c], 24)), -24);  // the shift shall be exact
  }
  const FloatGrid::Ptr grid = convert(sphere, withVoxelSize(h));
  const Coord shift(4096 * 10000, -4096, 4096 * 20000);
  const FloatGrid::Ptr far = convert(transformed(sphere, 1, shift.asVec3d() * h), withVoxelSize(h));
  EXPECT_TRUE(sameField(*far, *grid, 1, shift));
  EXPECT_EQ(far->evalActiveVoxelBoundingBox().min(), grid->evalActiveVoxelBoundingBox().min() + shift);
}

TEST_F(MeshToSdf, SameFieldForAnyNumberOfThreads) {
  const Mesh mesh = hasBunny() ? bunny() : makeSphere(1, 6);
  for (const MeshToSdfOptions& options : {withVoxelSize(0.02), withVoxelSize(0.04, 12, 8)}) {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const FloatGrid::Ptr serial = convert(mesh, options);
    for (const std::size_t threads : {2U, 2U, 4U}) {
      const tbb::global_control many(tbb::global_control::max_allowed_parallelism, threads);
      EXPECT_TRUE(sameField(*convert(mesh, options), *serial)) << threads << " threads";
    }
  }
}

// Promise of targets.md: A closed mesh "may be oriented either way, cross itself, have inner walls, and consist of many
//   parts"
TEST_F(MeshToSdf, AcceptsClosedMeshesOfEveryKind) {
  const Mesh boxes = merged(makeCube(1), makeCube(1, Vec3d(0.5)));
  EXPECT_NEAR(insideVolume(*convert(boxes, withVoxelSize(0.03))), 2 - 0.125, 0.08);
  const Mesh half = merged(makeCube(1), flipped(makeCube(1, Vec3d(3, 0, 0))));
  EXPECT_NEAR(insideVolume(*convert(half, withVoxelSize(0.03))), 2, 0.15) << "its signed volume is 0";
  const Mesh shell = merged(makeSphere(1, 4), flipped(makeSphere(0.9, 4)));
  EXPECT_GT(insideVolume(*convert(shell, withVoxelSize(0.04))), 1.1);
  const Mesh plate = makeBox(Vec3d(0), Vec3d(1, 1, 0.05));
  EXPECT_NEAR(insideVolume(*convert(plate, withVoxelSize(0.02))), 0.05, 0.025);
  Mesh wall = makeCube(2);
  wall.points.insert(wall.points.end(), {Vec3d(0.013, -0.9, -0.9), Vec3d(0.013, 0.9, -0.9), Vec3d(0.013, 0.9, 0.9)});
  wall.triangles.emplace_back(8, 9, 10);
  EXPECT_NEAR(insideVolume(*convert(wall, withVoxelSize(0.05))), 8, 0.7);
  EXPECT_NEAR(insideVolume(*convert(makeSoup(makeSphere(1, 4), 0), withVoxelSize(0.05))), 4 * kPi / 3, 0.05);
}

TEST_F(MeshToSdf, RefusesALeakWithNumbersAndAWayOut) {
  const Mesh holed = withoutTriangles(makeSphere(1, 5), [](const Vec3d& c) { return c[2] > 0.98; });
  const std::string text = refusal([&] { convert(holed, withVoxelSize(0.02)); }, vdbtools::Remedy::RepairMesh);
  const vdbtools::MeshReport report = vdbtools::reportMesh(holed);
  EXPECT_NE(text.find(std::to_string(report.openEdges) + " open edges"), std::string::npos) << text;
  EXPECT_NE(text.find("inside volume"), std::string::npos) << text;
  EXPECT_NE(text.find("0.02"), std::string::npos) << text;
  // What leaks at one voxel size may hold at a coarser one.
  EXPECT_NEAR(insideVolume(*convert(holed, withVoxelSize(0.25))), 4 * kPi / 3, 1);
  // A sheet, and a closed body with an open one beside it.
  refusal(
      [&] { convert(withoutTriangles(makeSphere(), [](const Vec3d& c) { return c[2] > 0; }), withVoxelSize(0.05)); });
  refusal([&] { convert(merged(makeSphere(), transformed(holed, 1, Vec3d(3, 0, 0))), withVoxelSize(0.02)); });
}

TEST_F(MeshToSdf, RefusesWhatIsThinnerThanAVoxel) {
  const std::string text =
      refusal([] { convert(makeBox(Vec3d(0.01), Vec3d(0.9, 0.9, 0.03)), withVoxelSize(0.1)); }, vdbtools::Remedy::None);
  EXPECT_NE(text.find("finer"), std::string::npos) << text;
}

TEST_F(MeshToSdf, RefusesOptionsOutOfTheirDomain) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const MeshToSdfOptions& options :
       {withVoxelSize(0), withVoxelSize(-1), withVoxelSize(nan), withVoxelSize(infinity), withVoxelSize(1e-300),
        withVoxelSize(1e-5), withVoxelSize(0.1, 1), withVoxelSize(0.1, infinity), withVoxelSize(0.1, nan),
        withVoxelSize(0.1, 3, 0.5), withVoxelSize(0.1, 3, nan), withVoxelSize(1e-6), withVoxelSize(1e-4),
        withVoxelSize(0.001, 3, infinity)}) {
    EXPECT_THROW(convert(makeCube(2), options), std::invalid_argument)
        << options.voxelSize << " " << options.exteriorBandWidth << " " << options.interiorBandWidth;
  }
  EXPECT_THROW(convert(makeCube(2, Vec3d(1e9, 0, 0)), withVoxelSize(0.1)), std::invalid_argument);
  EXPECT_THROW(convert(Mesh(), withVoxelSize(0.1)), DataError);
  Mesh flat;
  flat.points = {Vec3d(0), Vec3d(1), Vec3d(2)};
  flat.triangles = {{0, 1, 2}};
  EXPECT_THROW(convert(flat, withVoxelSize(0.1)), DataError);
}

TEST_F(MeshToSdf, StopsWhenCancelled) {
  for (const int after : {0, 3, 8}) {
    Interrupting first(after + 1);
    EXPECT_THROW(meshToSdf(makeSphere(), withVoxelSize(0.05), first), vdbtools::Interrupted) << after;
    Interrupting second(after + 1);
    EXPECT_THROW(repairedMeshToSdf(makeSphere(), withVoxelSize(0.05), {}, second), vdbtools::Interrupted) << after;
  }
}

// Promise: `--repair`: "a flat opening ..."
TEST_F(RepairedMeshToSdf, LeavesAWholeMeshAsItIs) {
  const Mesh sphere = makeSphere(1, 4);
  const RepairedSdf result = repaired(sphere, 0.05);
  EXPECT_TRUE(sameField(*result.grid, *convert(sphere, withVoxelSize(0.05))));
  EXPECT_LT(result.moved, 0.1 * 0.05);
  EXPECT_DOUBLE_EQ(result.closedGap, 0.1);
  const Mesh boxes = merged(makeCube(1), makeCube(1, Vec3d(0.5)));
  EXPECT_TRUE(sameField(*repaired(boxes, 0.04).grid, *convert(boxes, withVoxelSize(0.04)))) << "their groove stays";
}

TEST_F(RepairedMeshToSdf, ASphereWithAHoleIsASphereAgain) {
  constexpr double h = 0.04;
  constexpr double hole = 0.15;  // its radius
  const Mesh holed =
      withoutTriangles(makeSphere(1, 5), [](const Vec3d& c) { return std::hypot(c[0], c[1]) < hole && c[2] > 0; });
  refusal([&] { convert(holed, withVoxelSize(h)); });
  const RepairedSdf result = repaired(holed, h);
  EXPECT_GE(result.closedGap, 2 * hole - 4 * h);
  EXPECT_LE(result.closedGap, 0.5);
  EXPECT_LT(result.moved, 1.5 * h);
  EXPECT_NEAR(insideVolume(*result.grid), 4 * kPi / 3, 0.03 * 4 * kPi / 3);
  // Away from the lid it is the field of the whole sphere.
  const FloatGrid::Ptr whole = convert(makeSphere(1, 5), withVoxelSize(h));
  const auto expected = whole->getConstAccessor();
  double worst = 0;
  for (auto it = result.grid->cbeginValueOn(); it; ++it) {
    const Vec3d p = result.grid->indexToWorld(it.getCoord());
    if (std::hypot(p[0], p[1]) < hole + 6 * h && p[2] > 0) continue;
    worst = std::max(worst, std::abs(double{*it} - double{expected.getValue(it.getCoord())}));
  }
  EXPECT_LT(worst, 0.01 * h);
}

TEST_F(RepairedMeshToSdf, ASmallHoleIsClosedToWithinAVoxel) {
  constexpr double h = 0.04;
  const Mesh holed =
      withoutTriangles(makeSphere(1, 5), [](const Vec3d& c) { return std::hypot(c[0], c[1]) < 0.06 && c[2] > 0; });
  refusal([&] { convert(holed, withVoxelSize(0.02)); });
  const RepairedSdf result = repaired(holed, h, 0.16);
  EXPECT_DOUBLE_EQ(result.closedGap, 0.16);
  EXPECT_LT(largestError(*result.grid, [](const Vec3d& p) { return p.length() - 1; }), 1);
}

TEST_F(RepairedMeshToSdf, ASoupOfLooseTriangles) {
  constexpr double h = 0.04;
  for (const double jitter : {0.2, 1.0}) {
    const RepairedSdf result = repaired(makeSoup(makeSphere(1, 4), jitter * h), h);
    EXPECT_NEAR(insideVolume(*result.grid), 4 * kPi / 3, 4 * kPi * jitter * h + 0.02) << jitter;
    EXPECT_LT(largestError(*result.grid, [](const Vec3d& p) { return p.length() - 1; }), 2 * jitter + 0.5) << jitter;
  }
}

// Promise: A closed mesh "may be oriented ..."
TEST_F(RepairedMeshToSdf, InnerWallsDoNotCount) {
  Mesh wall = makeCube(2);
  wall.points.insert(wall.points.end(), {Vec3d(0.013, -0.9, -0.9), Vec3d(0.013, 0.9, -0.9), Vec3d(0.013, 0.9, 0.9),
                                         Vec3d(0.013, -0.9, 0.9)});
  wall.triangles.emplace_back(8, 9, 10);
  wall.triangles.emplace_back(8, 10, 11);
  const RepairedSdf result = repaired(wall, 0.05);
  EXPECT_NEAR(insideVolume(*result.grid), 8, 0.7);
  EXPECT_LT(result.moved, 0.05);
}

TEST_F(RepairedMeshToSdf, AnOpenBowlIsCappedOrClosedByAGapAsWideAsItself) {
  const Mesh bowl = withoutTriangles(makeSphere(1, 4), [](const Vec3d& c) { return c[2] > 0; });
  EXPECT_NEAR(insideVolume(*repaired(bowl, 0.05).grid), 2 * kPi / 3, 0.1);
  const std::string text = refusal([&] { repaired(bowl, 0.05, 0.2); });
  EXPECT_NE(text.find("open edges"), std::string::npos) << text;
  const Mesh narrow = withoutTriangles(makeSphere(1, 4), [](const Vec3d& c) { return c[2] > 0.85; });
  refusal([&] { repaired(narrow, 0.05, 0.2); });
  EXPECT_GT(insideVolume(*repaired(narrow, 0.05, 1.4).grid), 0.8 * 4 * kPi / 3);
}

TEST_F(RepairedMeshToSdf, RefusesAnAbsurdGap) {
  Monitor monitor;
  for (const double gap : {-1.0, 100.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(repairedMeshToSdf(makeSphere(), withVoxelSize(0.1), {gap}, monitor), std::invalid_argument) << gap;
  }
}

TEST_F(RepairedMeshToSdf, TheBunnyWithALargeHole) {
  if (!hasBunny()) GTEST_SKIP() << bunnyPath() << " is not installed";
  const Mesh holed = withoutTriangles(bunny(), [](const Vec3d& c) { return (c - Vec3d(0, 0.3, 0.6)).length() < 0.3; });
  ASSERT_GT(bunny().triangles.size() - holed.triangles.size(), 300U);
  refusal([&] { convert(holed, withVoxelSize(0.01)); }, vdbtools::Remedy::RepairMesh);
  const RepairedSdf result = repaired(holed, 0.02);
  EXPECT_NEAR(insideVolume(*result.grid), 1.5998, 0.03 * 1.5998);
  EXPECT_LT(result.moved, 2 * 0.02);
}

}  // namespace
