// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/print/print_job.h"

#include "support/mesh_laws.h"
#include "support/test_meshes.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/distance/mesh_to_sdf.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace {

using openvdb::Vec3d;
using test_meshes::flipped;
using test_meshes::makeBox;
using test_meshes::makeCube;
using test_meshes::makeSphere;
using test_meshes::merged;
using test_meshes::transformed;
using vdbtools::Mesh;
using vdbtools::PrintedPart;
using vdbtools::PrintOptions;

/// Of radius 1, with a hair along y and a fin: thin in one and in two directions, with a tip and a rim.
Mesh hairyBall() {
  Mesh mesh = makeSphere(1, 5);
  for (Vec3d& p : mesh.points) {
    const double angle = std::acos(std::clamp(p.unit()[1], -1.0, 1.0));
    if (angle < 0.05) {
      p = {p[0], p[1] + 2 * (1 - std::pow(angle / 0.05, 4)), p[2]};
    } else if (std::abs(p[2]) < 0.04 && p[0] > 0.4) {
      p[0] += 0.8;
    }
  }
  return mesh;
}

PrintedPart printed(const Mesh& mesh, const PrintOptions& options) {
  vdbtools::Monitor monitor;
  return vdbtools::printedPart(mesh, options, monitor);
}

void expectStands(const PrintedPart& part, double size) {
  EXPECT_EQ(mesh_laws::notClosedManifold(part.mesh), "");
  openvdb::BBoxd box;
  for (const Vec3d& p : part.mesh.points) box.expand(p);
  const Vec3d extents = box.extents();
  EXPECT_NEAR(std::max({extents[0], extents[1], extents[2]}), size, 1e-9 * size);
  EXPECT_NEAR(box.min()[2], 0, 1e-9 * size);
  EXPECT_NEAR(box.min()[0] + box.max()[0], 0, 1e-9 * size);
  EXPECT_NEAR(box.min()[1] + box.max()[1], 0, 1e-9 * size);
  EXPECT_GT(part.volume, 0);
  EXPECT_NEAR(part.volume, mesh_laws::volume(part.mesh), 1e-9 * part.volume);
}

/// The share of a mesh's points that lie farther than @a thickness from the middle of every ball of that diameter in
/// the solid, found without any search: by distances on a lattice, and every node of it. Balls are smaller by the
/// diagonal of half a voxel, as their middles may lie between nodes.
double thinShare(const Mesh& mesh, double thickness) {
  vdbtools::Monitor monitor;
  const double voxel = thickness / 10;
  const auto phi = vdbtools::meshToSdf(
      mesh, {.voxelSize = voxel, .interiorBandWidth = std::numeric_limits<double>::infinity()}, monitor);
  std::size_t thin = 0, looked = 0;
  const auto reach = static_cast<int>(std::floor(thickness / voxel));
  const auto accessor = phi->getConstAccessor();
  for (std::size_t i = 0; i < mesh.points.size(); i += 17) {
    const openvdb::Coord middle = openvdb::Coord::round(mesh.points[i] / voxel);
    bool found = false;
    for (int x = -reach; x <= reach && !found; ++x)
      for (int y = -reach; y <= reach && !found; ++y)
        for (int z = -reach; z <= reach && !found; ++z) {
          const openvdb::Coord node = middle.offsetBy(x, y, z);
          found = (node.asVec3d() * voxel - mesh.points[i]).length() <= thickness &&
                  -accessor.getValue(node) >= thickness / 2 - 0.87 * voxel;
        }
    ++looked;
    thin += !found;
  }
  return static_cast<double>(thin) / static_cast<double>(looked);
}

// Promise of printing.md: Thin parts become as thick as is asked for or are dropped, and "Edges and tips of 60 degrees
//   or more do not count as thin"
TEST(PrintJob, ThickensHairsAndFinsAndLeavesTheRest) {
  const Mesh mesh = hairyBall();
  const PrintedPart plain = printed(mesh, {.size = 60}),
                    thick = printed(mesh, {.size = 60, .minThickness = 3.5, .resolution = 85});
  expectStands(plain, 60);
  expectStands(thick, 60);
  EXPECT_LT(plain.thinnest, 1);
  EXPECT_GT(thinShare(plain.mesh, 3.5), 0.004);
  EXPECT_GT(thick.thinPoints, 0u);
  EXPECT_EQ(thick.thinPlaces, 0u);
  EXPECT_GE(thick.thinnest, 0.97 * 3.5);
  EXPECT_EQ(thinShare(thick.mesh, 3.5), 0);
  // It has its hair still, and little else was added.
  const auto asGiven = [](const PrintedPart& part) { return part.volume / std::pow(part.scale, 3); };
  EXPECT_GT(asGiven(thick), asGiven(plain));
  EXPECT_LT(asGiven(thick), 1.2 * asGiven(plain));
}

// Promise: Thin parts become as thick ...
TEST(PrintJob, DropsWhatIsThin) {
  const Mesh mesh = hairyBall();
  const PrintedPart part =
      printed(mesh, {.size = 60, .minThickness = 3.5, .thin = vdbtools::ThinParts::Drop, .resolution = 85});
  expectStands(part, 60);
  EXPECT_EQ(thinShare(part.mesh, 3.5), 0);
  // The ball alone is as high as it is wide, but for stubs of less than the thickness.
  EXPECT_LT(part.extents[2], 60.001);
  EXPECT_GT(std::min({part.extents[0], part.extents[1], part.extents[2]}), 60 - 3 * 3.5);
  EXPECT_THROW(
      printed(makeBox({0, 0, 0}, {10, 10, 0.1}), {.size = 50, .minThickness = 5, .thin = vdbtools::ThinParts::Drop}),
      vdbtools::DataError);
}

// Promise: Thin parts become as thick ...
TEST(PrintJob, TakesNoEdgeOfACubeForThin) {
  for (const double scale : {1e-3, 1e4}) {
    const PrintedPart part =
        printed(makeCube(scale, Vec3d(300 * scale)), {.size = 20, .minThickness = 2, .resolution = 60});
    expectStands(part, 20);
    EXPECT_EQ(part.thinPoints, 0u);
    EXPECT_EQ(part.thinPlaces, 0u);
    EXPECT_NEAR(part.volume, 8000, 60);
    EXPECT_NEAR(part.scale, 20 / scale, 0.05 / scale);
  }
}

// Promise: Thin parts become as thick ...
TEST(PrintJob, ThickensASheetToTheThickness) {
  const PrintedPart part = printed(makeBox({0, 0, 0}, {10, 0.2, 6}), {.size = 50, .minThickness = 3, .resolution = 80});
  expectStands(part, 50);
  EXPECT_EQ(part.thinPlaces, 0u);
  EXPECT_NEAR(part.extents[2], 3, 0.4);  // y was thin, and is up
}

// Promise: A part is "one closed piece, in millimetres, with z ..."
TEST(PrintJob, CutsAFlatBase) {
  for (const std::optional<double> thickness : {std::optional<double>(), std::optional<double>(3)}) {
    const PrintedPart part =
        printed(makeSphere(1, 4), {.size = 40, .minThickness = thickness, .flatBase = 5, .resolution = 64});
    expectStands(part, 40);
    // A cap of height 5 off a ball of radius 20.
    EXPECT_NEAR(part.extents[2], 35, 0.3);
    EXPECT_NEAR(part.baseArea, M_PI * (20 * 20 - 15 * 15), 0.06 * M_PI * (20 * 20 - 15 * 15));
    EXPECT_EQ(part.thinPlaces, 0u);
  }
}

// Promise: A part is "one closed piece, in millimetres, with z ..."
// Promise: Without a thickness and a base ...
// Promise of printing.md: A print drops islands but the largest, and "Cavities, which would trap resin or powder, are
//   filled"; "`--repair` closes larger holes"
TEST(PrintJob, KeepsTheLargestIslandAndFillsCavities) {
  const Mesh ball = makeSphere(1, 3), speck = makeSphere(0.3, 2, {3, 0, 0}),
             cavity = test_meshes::flipped(makeSphere(0.5, 2));
  const Mesh mesh = merged(merged(speck, ball), cavity);
  const PrintedPart part = printed(mesh, {.size = 30});
  expectStands(part, 30);
  EXPECT_EQ(part.islands, 2u);
  EXPECT_EQ(part.keptIslands, 1u);
  EXPECT_EQ(part.cavities, 1u);
  const double ofSpeck = mesh_laws::volume(speck), ofBall = mesh_laws::volume(ball);
  EXPECT_NEAR(part.droppedShare, ofSpeck / (ofSpeck + ofBall), 1e-9);
  EXPECT_NEAR(part.volume, ofBall * std::pow(part.scale, 3), 1e-6 * part.volume);
  EXPECT_EQ(part.mesh.triangles.size(), ball.triangles.size());
  EXPECT_EQ(printed(mesh, {.size = 30, .islands = 2, .resolution = 80}).keptIslands, 2u);
}

// Promise of printing.md: `--tolerance`: "neither mesh is farther than this from the other"
TEST(PrintJob, HasFewerTrianglesWithinATolerance) {
  const Mesh ball = makeSphere(1, 4);
  const PrintedPart part = printed(ball, {.size = 30, .tolerance = 0.2});
  EXPECT_EQ(mesh_laws::notClosedManifold(part.mesh), "");
  EXPECT_LT(part.mesh.triangles.size(), ball.triangles.size() / 4);
}

// Promise: `--tolerance`: "neither mesh ..."
TEST(PrintJob, KeepsItsSizeBaseAndThicknessWithinATolerance) {
  PrintOptions options{.size = 30, .minThickness = 1.5, .flatBase = 3, .resolution = 90};
  const PrintedPart exact = printed(hairyBall(), options);
  options.tolerance = 0.1;
  const PrintedPart part = printed(hairyBall(), options);
  expectStands(part, 30);
  EXPECT_LT(part.mesh.triangles.size(), exact.mesh.triangles.size() / 3);
  EXPECT_NEAR(part.baseArea, exact.baseArea, 0.02 * exact.baseArea);
  EXPECT_EQ(part.thinPlaces, 0u);
}

/// What a command reads from a file with this mesh.
Mesh closedOf(const Mesh& mesh, std::uint64_t resolution, std::size_t* united = nullptr) {
  vdbtools::Monitor monitor;
  return vdbtools::closedMesh(mesh, resolution, false, monitor, united);
}

// Promise of printing.md: "Closed parts that run into each other or stand on each other become one"
TEST(PrintJob, PartsThatRunIntoEachOtherAreOne) {
  const Mesh plate = makeBox({0, 0, 0}, {6, 1, 4}), across = makeBox({1, 0.5, 1}, {2, 5, 2}),
             standing = makeBox({4, 1, 1}, {5, 5, 3});
  const double volume = 24 + 4 + 8;  // half a unit of the box across lies within the plate
  for (const bool insideOut : {false, true}) {
    std::size_t united = 0;
    const Mesh mesh = closedOf(merged(merged(insideOut ? flipped(plate) : plate, across), standing), 120, &united);
    EXPECT_EQ(united, 3u);
    const PrintedPart part = printed(mesh, {.size = 60});
    expectStands(part, 60);
    EXPECT_EQ(part.islands, 1u);
    EXPECT_EQ(part.cavities, 0u);
    EXPECT_NEAR(part.volume, 1000 * volume, 0.01 * 1000 * volume);
  }
}

// Promise: "Closed parts that run ..."
TEST(PrintJob, AThinPartThatStandsOnAnotherIsKept) {
  // It has less than a thousandth of the volume, and stands on less than a three-hundredth of its own surface.
  const Mesh mesh = closedOf(merged(makeBox({0, 0, 0}, {10, 2, 10}), makeBox({5, 2, 5}, {5.12, 12, 5.12})), 200);
  const PrintedPart part = printed(mesh, {.size = 60});
  EXPECT_EQ(part.islands, 1u);
  EXPECT_GT(part.extents[2], 59);
}

// Promise: "Closed parts that run ..."
TEST(PrintJob, BlocksThatStandOnEachOtherAreOne) {
  Mesh wall;
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 2; ++y) wall = merged(wall, makeBox(Vec3d(x, y, 0), Vec3d(x + 1, y + 1, 1)));
  std::size_t united = 0;
  const PrintedPart part = printed(closedOf(wall, 90, &united), {.size = 30});
  EXPECT_EQ(united, 6u);
  EXPECT_EQ(part.islands, 1u);
  EXPECT_NEAR(part.volume, 6000, 0.02 * 6000);
}

// Promise of printing.md: "A tiny part that hardly touches another one is dropped as an island"
TEST(PrintJob, ATinyPartThatHardlyTouchesChangesNothing) {
  const Mesh large = makeBox({0, 0, 0}, {10, 10, 10}), tiny = makeBox({9.9, 9.9, 9.9}, {10.6, 10.6, 10.6});
  std::size_t united = 1;
  const Mesh mesh = closedOf(merged(large, tiny), 60, &united);
  EXPECT_EQ(united, 0u);
  EXPECT_EQ(mesh.triangles, merged(large, tiny).triangles);
  const PrintedPart part = printed(mesh, {.size = 60});
  EXPECT_EQ(part.islands, 2u);
  EXPECT_NEAR(part.volume, 60 * 60 * 60, 1e-6 * 60 * 60 * 60);
}

// Promise of printing.md: "Parts that are inside out are turned"
TEST(PrintJob, TurnsPartsThatAreInsideOutAndFillsHollows) {
  const Mesh box = makeBox({0, 0, 0}, {4, 4, 4}), beside = makeBox({6, 0, 0}, {9, 3, 3});
  const Mesh hollow = flipped(makeBox({1, 1, 1}, {3, 3, 3}));
  for (const bool first : {false, true})
    for (const bool second : {false, true}) {
      const Mesh solid = merged(box, hollow);
      const Mesh given = merged(first ? flipped(solid) : solid, second ? flipped(beside) : beside);
      const Mesh mesh = closedOf(given, 60);
      EXPECT_EQ(mesh.points, given.points);
      const PrintedPart part = printed(mesh, {.size = 90, .islands = 2, .resolution = 90});
      EXPECT_EQ(part.islands, 2u);
      EXPECT_EQ(part.cavities, 1u);
      EXPECT_EQ(part.droppedShare, 0);
      EXPECT_NEAR(part.volume, 1000 * (64 + 27), 0.01 * 1000 * (64 + 27));
    }
}

// Promise: A print drops islands but ...
TEST(PrintJob, RefusesWhatIsNotClosedAndClosesItOnRequest) {
  const Mesh open = test_meshes::withoutTriangles(makeSphere(1, 4), [](const Vec3d& p) { return p[1] > 0.995; });
  EXPECT_THROW(printed(open, {.size = 30}), vdbtools::DataError);
  EXPECT_THROW(printed(makeCube(), {.size = -1}), std::invalid_argument);
  EXPECT_THROW(printed(makeCube(), {.size = 10, .minThickness = 9}), std::invalid_argument);
  vdbtools::Monitor monitor;
  const Mesh closed = vdbtools::closedMesh(open, 60, true, monitor);
  EXPECT_EQ(mesh_laws::notClosedManifold(closed), "");
  expectStands(printed(closed, {.size = 30}), 30);
}

}  // namespace
