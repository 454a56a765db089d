// SPDX-License-Identifier: Apache-2.0
#include "distance/hole_caps.h"
#include "repair/open_shapes.h"
#include "repair/solid_input.h"
#include "support/test_meshes.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/distance/mesh_to_sdf.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/repair/mesh_repair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

namespace {

using namespace test_meshes;
using openvdb::FloatGrid;
using vdbtools::DataError;
using vdbtools::MendOptions;
using vdbtools::MeshReport;
using vdbtools::Monitor;
using vdbtools::Remedy;
using vdbtools::reportMesh;

class Mending : public testing::Test {
 protected:
  static void SetUpTestSuite() { openvdb::initialize(); }
};

/// n x n squares over [-1/2, 1/2]^2, y up.
Mesh heightField(int n, const std::function<double(double, double)>& height) {
  Mesh mesh;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      const double x = double(i) / n - 0.5, z = double(j) / n - 0.5;
      mesh.points.emplace_back(x, height(x, z), z);
    }
  const auto at = [n](int i, int j) { return static_cast<std::uint32_t>(i * (n + 1) + j); };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      mesh.triangles.emplace_back(at(i, j), at(i, j + 1), at(i + 1, j + 1));
      mesh.triangles.emplace_back(at(i, j), at(i + 1, j + 1), at(i + 1, j));
    }
  return mesh;
}

Mesh hills(int n = 24) {
  return heightField(n, [](double x, double z) { return 0.1 * std::sin(8 * x) * std::cos(7 * z) + 0.03 * x; });
}

/// The volume between a height field and the plane below its lowest point: its squares' triangles are prisms.
double volumeBelow(const Mesh& mesh, double depth) {
  double lowest = 1e9, volume = 0;
  for (const Vec3I& t : mesh.triangles)
    for (int c = 0; c < 3; ++c) lowest = std::min(lowest, mesh.points[t[c]][1]);
  for (const Vec3I& t : mesh.triangles) {
    const Vec3d &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
    const double shadow = std::abs((b - a).cross(c - a)[1]) / 2;
    volume += shadow * ((a[1] + b[1] + c[1]) / 3 - lowest + depth);
  }
  return volume;
}

/// The values of what a mesh becomes, on a lattice about its middle.
FloatGrid::Ptr field(const Mesh& mesh, const MendOptions& mend, double voxel, double band = 4) {
  Monitor monitor;
  const vdbtools::SolidSource source = vdbtools::openSolid("test", std::make_shared<const Mesh>(mesh), mend);
  return vdbtools::makeSdfAbout(source.box.getCenter(), *source.solid, vdbtools::sdfBand(voxel, band, band), mend,
                                monitor)
      .grid;
}

double insideVolume(const FloatGrid& grid) {
  double nodes = 0;
  for (auto it = grid.cbeginValueAll(); it; ++it)
    if (*it < 0) nodes += static_cast<double>(it.getVoxelCount());
  return nodes * std::pow(grid.voxelSize()[0], 3);
}

/// The largest difference from @a phi over the active nodes, in voxels.
double largestError(const FloatGrid& grid, const std::function<double(const Vec3d&)>& phi) {
  double largest = 0;
  for (auto it = grid.cbeginValueOn(); it; ++it)
    largest = std::max(largest, std::abs(*it - phi(grid.indexToWorld(it.getCoord()))));
  return largest / grid.voxelSize()[0];
}

Remedy remedyOf(const std::function<void()>& work) {
  try {
    work();
  } catch (const DataError& error) {
    EXPECT_EQ(std::string(error.what()).find("--"), std::string::npos) << error.what();
    return error.remedy();
  }
  ADD_FAILURE() << "was not refused";
  return Remedy::None;
}

// Promise: `--repair`: "a flat opening ..."
TEST_F(Mending, EveryOpenEdgeIsOnOneLoopAndCapsCloseTheMesh) {
  const Mesh sphere = makeSphere(1, 4);
  // Holes that touch in a point, lie apart, or are a single triangle.
  const std::function<bool(const Vec3d&)> drops[] = {
      [](const Vec3d& c) { return c[2] > 0.6 || c[2] < -0.8; },
      [](const Vec3d& c) { return std::abs(c[0]) < 0.3 && std::abs(c[1]) < 0.3; },
      [](const Vec3d& c) { return int(20 * (c[0] + 2)) % 5 == 0 && int(20 * (c[1] + 2)) % 7 == 0; }};
  for (const auto& drop : drops) {
    const Mesh open = withoutTriangles(sphere, drop);
    const std::vector<vdbtools::BoundaryLoop> loops = vdbtools::boundaryLoops(open);
    std::size_t edges = 0;
    Mesh capped = open;
    for (const vdbtools::BoundaryLoop& loop : loops) {
      edges += loop.size();
      const std::size_t before = capped.triangles.size();
      vdbtools::spanLoop(loop, capped.points, capped.triangles);
      EXPECT_EQ(capped.triangles.size() - before, loop.size() - 2);
    }
    EXPECT_EQ(edges, reportMesh(open).openEdges);
    const MeshReport report = reportMesh(capped);
    EXPECT_EQ(report.openEdges, 0U);
    EXPECT_EQ(report.misorientedEdges, 0U) << "caps are oriented as the mesh";
  }
}

// Promise of targets.md: `--repair`: "a flat opening gets a flat cap, and the mesh itself stays where it is"
TEST_F(Mending, AFlatLoopIsSpannedByItsOwnArea) {
  // A star, which no fan covers, as the rim of a cup; more points than are spanned at once, and fewer.
  for (const int points : {40, 900}) {
    Mesh cup;
    double area = 0;
    const auto corner = [&](int i) {
      const double angle = 2 * kPi * i / points, r = 1 + 0.6 * std::cos(5 * angle);
      return Vec3d(r * std::cos(angle), 0, -r * std::sin(angle));
    };
    for (int i = 0; i < points; ++i) cup.points.push_back(corner(i));
    std::vector<std::uint32_t> loop(cup.points.size());
    for (std::uint32_t i = 0; i < loop.size(); ++i) loop[i] = i;
    for (int i = 0; i < points; ++i) area += corner(i).cross(corner((i + 1) % points))[1] / 2;
    vdbtools::spanLoop(loop, cup.points, cup.triangles);
    EXPECT_EQ(cup.triangles.size(), loop.size() - 2);
    EXPECT_NEAR(vdbtools::areaOf(cup.triangles, cup.points), std::abs(area),
                (points > 300 ? 1e-3 : 1e-9) * std::abs(area));
  }
}

TEST_F(Mending, HalfABallIsCappedWhereItIsCut) {
  // Cut flat: points in the plane.
  Mesh half = withoutTriangles(makeSphere(1, 4), [](const Vec3d& c) { return c[1] < 0; });
  for (const vdbtools::BoundaryLoop& loop : vdbtools::boundaryLoops(half))
    for (const std::uint32_t p : loop) half.points[p] = Vec3d(half.points[p][0], 0, half.points[p][2]).unit();
  constexpr double h = 0.04;
  for (const auto& [scale, shift] : {std::pair(1.0, Vec3d(0)), {1000.0, Vec3d(0)}, {1.0, Vec3d(4096, -512, 64)}}) {
    const FloatGrid::Ptr grid = field(transformed(half, scale, shift), {.repair = true}, h * scale);
    EXPECT_NEAR(insideVolume(*grid) / std::pow(scale, 3), 2 * kPi / 3, 0.03 * 2 * kPi / 3);
    const double error = largestError(*grid, [&, s = scale, o = shift](const Vec3d& at) {
      const Vec3d p = (at - o) / s;
      const double rim = (Vec3d(std::hypot(p[0], p[2]) - 1, p[1], 0)).length();
      if (p[1] >= 0 && p.length() > 1) return s * (p.length() - 1);
      if (p[1] >= 0) return -s * std::min(1 - p.length(), p[1]);
      return s * (std::hypot(p[0], p[2]) <= 1 ? -p[1] : rim);
    });
    EXPECT_LT(error, 0.25);
  }
}

// Promise of targets.md: The program says "how far the surface moved" by a repair, and what it capped
TEST_F(Mending, RepairSaysWhatItCapped) {
  Monitor monitor;
  const Mesh holed = withoutTriangles(makeSphere(1, 4), [](const Vec3d& c) { return std::abs(c[2]) > 0.8; });
  const vdbtools::RepairedSdf result = vdbtools::repairedMeshToSdf(holed, {.voxelSize = 0.05}, {}, monitor);
  EXPECT_EQ(result.caps, 2U);
  EXPECT_NEAR(result.closedGap, 1.2, 0.15);
  EXPECT_LT(result.moved, 0.05);
  // The sides of a gap are not holes: it is bridged, and both halves become one ball.
  const auto apart = [](double gap) {
    const Mesh top = withoutTriangles(makeSphere(1, 4), [](const Vec3d& c) { return c[1] < 0; });
    const Mesh bottom = withoutTriangles(makeSphere(1, 4), [](const Vec3d& c) { return c[1] >= 0; });
    return merged(transformed(top, 1, Vec3d(0, gap / 2, 0)), transformed(bottom, 1, Vec3d(0, -gap / 2, 0)));
  };
  const vdbtools::RepairedSdf ball = vdbtools::repairedMeshToSdf(apart(0.1), {.voxelSize = 0.025}, {}, monitor);
  EXPECT_EQ(ball.caps, 0U);
  EXPECT_LT(ball.grid->tree().getValue(openvdb::Coord(0)), 0) << "inside of the gap";
  EXPECT_EQ(vdbtools::repairedMeshToSdf(apart(1), {.voxelSize = 0.05}, {}, monitor).caps, 2U);
}

TEST_F(Mending, RepairOfWhatIsNoSolidPointsElsewhere) {
  Monitor monitor;
  const auto repair = [&](const Mesh& mesh) { vdbtools::repairedMeshToSdf(mesh, {.voxelSize = 0.02}, {}, monitor); };
  Mesh triangle{.points = {Vec3d(0), Vec3d(1, 0, 0), Vec3d(0, 1, 0)}, .triangles = {{0, 1, 2}}};
  const Mesh holed = withoutTriangles(hills(), [](const Vec3d& c) { return std::hypot(c[0], c[2]) < 0.2; });
  const Mesh two = merged(hills(), transformed(hills(), 1, Vec3d(3, 1, 0)));
  for (const Mesh& sheet : {triangle, hills(), holed, two})
    EXPECT_EQ(remedyOf([&] { repair(sheet); }), Remedy::SolidifySheet) << sheet.triangles.size();
  vdbtools::MeshToSdfOptions options{.voxelSize = 0.02};
  EXPECT_EQ(remedyOf([&] { vdbtools::meshToSdf(hills(), options, monitor); }), Remedy::SolidifySheet);
}

// Promise: `--repair`, `--solidify`, `--thicken` and `--points-radius` ...
// Promise: Terrain: "Up is the axis ..."
TEST_F(Mending, TerrainBecomesABlock) {
  const double depth = 0.2;
  const Mesh whole = hills();
  const Mesh holed = withoutTriangles(whole, [](const Vec3d& c) { return std::hypot(c[0], c[2]) < 0.2; });
  for (const Mesh& terrain : {whole, holed, flipped(whole)}) {
    const Mesh block = vdbtools::solidified(terrain, {.depth = depth}, false);
    const MeshReport report = reportMesh(block);
    EXPECT_TRUE(report.closed());
    EXPECT_NEAR(report.volume, volumeBelow(terrain, depth), 1e-9) << "oriented outward, with shafts below holes";
    EXPECT_NEAR(report.box.extents()[1], reportMesh(terrain).box.extents()[1] + depth, 1e-12);
    EXPECT_NEAR(insideVolume(*field(terrain, {.solidify = vdbtools::SolidifyOptions{.depth = depth}}, 0.01)),
                report.volume, 0.02);
  }
  const Mesh filled = vdbtools::solidified(holed, {.depth = depth}, true);
  EXPECT_TRUE(reportMesh(filled).closed());
  EXPECT_GT(reportMesh(filled).volume, volumeBelow(holed, depth) + 0.1 * depth) << "repair caps the hole";
}

// Promise of targets.md: Terrain: "Up is the axis along which the mesh shows the largest area, and down is the opposite
//   direction", `--solidify z:0.2` names it, and "Holes in the terrain become shafts"
TEST_F(Mending, TheAxisThatIsUp) {
  for (int axis = 0; axis < 3; ++axis) {
    Mesh turned = hills();
    for (Vec3d& p : turned.points) p = axis == 0 ? Vec3d(p[1], p[2], p[0]) : axis == 2 ? Vec3d(p[2], p[0], p[1]) : p;
    const Mesh found = vdbtools::solidified(turned, {.depth = 0.3}, false);
    const Mesh told = vdbtools::solidified(turned, {.depth = 0.3, .up = axis}, false);
    EXPECT_EQ(found.points, told.points) << axis;
    EXPECT_NEAR(std::abs(reportMesh(found).volume), volumeBelow(hills(), 0.3), 1e-9) << axis;
  }
  EXPECT_THROW(vdbtools::solidified(makeCube(), {.depth = 1}, false), DataError) << "nothing is open";
}

// Promise: Terrain: "Up is the axis ..."
TEST_F(Mending, AnOverhangingMeshGetsABaseBelowItsRimOnly) {
  // A ball with a flat opening at the bottom: a plinth of the opening's width.
  const Mesh open = withoutTriangles(makeSphere(1, 4), [](const Vec3d& c) { return c[1] < -0.8; });
  const Mesh block = vdbtools::solidified(open, {.depth = 0.5, .up = 1}, false);
  EXPECT_TRUE(reportMesh(block).closed());
  double widest = 0;
  for (const Vec3I& t : block.triangles)
    for (int c = 0; c < 3; ++c)
      if (const Vec3d& p = block.points[t[c]]; p[1] < -1.2) widest = std::max(widest, std::hypot(p[0], p[2]));
  EXPECT_GT(widest, 0.5);
  EXPECT_LT(widest, 0.7) << "the equator has no base";
}

// Promise: `--repair`, `--solidify`, `--thicken` and `--points-radius` ...
TEST_F(Mending, AThickenedSheetIsWhatLiesNearIt) {
  Mesh square{.points = {Vec3d(-1, 0, -1), Vec3d(1, 0, -1), Vec3d(1, 0, 1), Vec3d(-1, 0, 1)},
              .triangles = {{0, 1, 2}, {0, 2, 3}}};
  constexpr double r = 0.15, h = 0.03;
  for (const Vec3d& shift : {Vec3d(0), Vec3d(5000, -300, 7)}) {
    const FloatGrid::Ptr grid = field(transformed(square, 1, shift), {.thicken = 2 * r}, h);
    const double error = largestError(*grid, [&](const Vec3d& at) {
      const Vec3d p = at - shift;
      const Vec3d off(std::max(std::abs(p[0]) - 1, 0.0), p[1], std::max(std::abs(p[2]) - 1, 0.0));
      return off.length() - r;
    });
    EXPECT_LT(error, 0.2);
  }
}

// Promise: `--repair`, `--solidify`, `--thicken` and `--points-radius` ...
TEST_F(Mending, PointsBecomeBalls) {
  Mesh points;
  points.points = {Vec3d(0), Vec3d(1.5, 0, 0), Vec3d(0, 1, 0)};
  constexpr double r = 0.4, h = 0.04;
  // Within, the union's distance is that to the nearest ball's sphere only where balls do not meet.
  points.points.pop_back();
  const FloatGrid::Ptr grid = field(points, {.pointsRadius = r}, h);
  EXPECT_LT(largestError(*grid,
                         [&](const Vec3d& p) {
                           return std::min((p - points.points[0]).length(), (p - points.points[1]).length()) - r;
                         }),
            0.1);
  // Samples of a sphere, where they are close, are a solid ball.
  Mesh shell;
  shell.points = makeSphere(1, 4).points;
  EXPECT_NEAR(insideVolume(*field(shell, {.pointsRadius = 0.1}, 0.04)), 4 * kPi / 3 * std::pow(1.1, 3), 0.15);
  Mesh one;
  one.points = {Vec3d(7, -3, 2)};
  EXPECT_NEAR(insideVolume(*field(one, {.pointsRadius = 0.5}, 0.02)), 4 * kPi / 3 / 8, 0.01);
}

// Promise of targets.md: "`info` reports the spacing of the points"
TEST_F(Mending, TheSpacingOfPoints) {
  std::vector<Vec3d> line;
  for (int i = 0; i < 1000; ++i) line.emplace_back(0.25 * i, 3, 4);
  line.emplace_back(1e6, 0, 0);
  EXPECT_DOUBLE_EQ(vdbtools::pointSpacing(line), 0.25);
  EXPECT_EQ(vdbtools::pointSpacing({}), 0);
  EXPECT_EQ(vdbtools::pointSpacing({Vec3d(1)}), 0);
}

// Promise of targets.md: A plate "has to be two voxels of `--sdf-resolution` thick", or it is refused
TEST_F(Mending, OptionsOutOfTheirDomain) {
  const vdbtools::OptionTable table(vdbtools::mendOptionSpecs());
  const auto parse = [&](const vdbtools::Recipe& recipe) {
    return vdbtools::parseMendOptions(vdbtools::RecipeReader(recipe, table));
  };
  for (const char* value : {"", "0", "-1", "nan", "inf", "w:1", "y:", "y:0", "y:1:2", ":1", "deep"})
    EXPECT_THROW(parse({{"solidify", value}}), std::invalid_argument) << value;
  for (const char* name : {"thicken", "points-radius"})
    for (const char* value : {"", "0", "-1", "nan", "inf", "x"})
      EXPECT_THROW(parse({{name, value}}), std::invalid_argument) << name << ' ' << value;
  EXPECT_THROW(parse({{"thicken", "1"}, {"solidify", "1"}}), std::invalid_argument);
  EXPECT_THROW(parse({{"hollows", "drop"}}), std::invalid_argument);
  const MendOptions options = parse({{"solidify", "z:0.5"}, {"repair", "true"}});
  EXPECT_EQ(options.solidify->up, 2);
  EXPECT_EQ(options.solidify->depth, 0.5);
  // Different options are kept apart.
  EXPECT_NE(vdbtools::mendText(options), vdbtools::mendText(parse({{"solidify", "0.5"}, {"repair", "true"}})));
  EXPECT_NE(vdbtools::mendText(parse({{"thicken", "1"}})), vdbtools::mendText(parse({{"points-radius", "1"}})));
  EXPECT_NE(vdbtools::mendText(parse({{"hollows", "keep"}})), vdbtools::mendText(parse({})));
  EXPECT_THROW(vdbtools::requireResolved({.thicken = 0.1}, 0.06), std::invalid_argument);
  EXPECT_NO_THROW(vdbtools::requireResolved({.thicken = 0.1}, 0.05));
}

}  // namespace
