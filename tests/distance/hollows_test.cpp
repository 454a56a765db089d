// SPDX-License-Identifier: Apache-2.0
// Solids with closed parts inside, beside the exact distances to what they bound.
#include "distance/mesh_conversion.h"
#include "repair/solid_input.h"
#include "support/test_meshes.h"

#include "vdbtools/distance/mesh_to_sdf.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

namespace {

using namespace test_meshes;
using openvdb::FloatGrid;
using vdbtools::Hollows;
using vdbtools::MeshToSdfOptions;
using vdbtools::Monitor;
using vdbtools::PartCounts;

using DistanceTo = std::function<double(const Vec3d&)>;

constexpr double kFineVoxel = 0.03;
constexpr double kToTheMiddle = std::numeric_limits<double>::infinity();

MeshToSdfOptions hollowBand(Hollows hollows, double exterior = 6, double interior = kToTheMiddle) {
  return {.voxelSize = kFineVoxel, .exteriorBandWidth = exterior, .interiorBandWidth = interior, .hollows = hollows};
}

DistanceTo toBall(double radius, const Vec3d& centre = Vec3d(0)) {
  return [=](const Vec3d& p) { return (p - centre).length() - radius; };
}
DistanceTo differenceOf(const DistanceTo& solid, const DistanceTo& hollow) {
  return [=](const Vec3d& p) { return std::max(solid(p), -hollow(p)); };
}
DistanceTo unionOf(const DistanceTo& a, const DistanceTo& b) {
  return [=](const Vec3d& p) { return std::min(a(p), b(p)); };
}

/// A torus about the z axis.
Mesh makeTorus(double ring, double tube) {
  constexpr std::uint32_t kAlong = 160, kAround = 80;
  Mesh mesh;
  for (std::uint32_t i = 0; i < kAlong; ++i)
    for (std::uint32_t k = 0; k < kAround; ++k) {
      const double a = 2 * kPi * i / kAlong, b = 2 * kPi * k / kAround, r = ring + tube * std::cos(b);
      mesh.points.emplace_back(r * std::cos(a), r * std::sin(a), tube * std::sin(b));
      const std::uint32_t i2 = (i + 1) % kAlong, k2 = (k + 1) % kAround;
      mesh.triangles.emplace_back(i * kAround + k, i2 * kAround + k, i2 * kAround + k2);
      mesh.triangles.emplace_back(i * kAround + k, i2 * kAround + k2, i * kAround + k2);
    }
  return mesh;
}
DistanceTo toTorus(double ring, double tube) {
  return [=](const Vec3d& p) { return std::hypot(std::hypot(p[0], p[1]) - ring, p[2]) - tube; };
}

Mesh mergedAll(const std::vector<Mesh>& meshes) {
  Mesh result;
  for (const Mesh& mesh : meshes) result = merged(result, mesh);
  return result;
}

/// Balls whose triangles lie within a fortieth of a voxel of them.
Mesh fineSphere(double radius, const Vec3d& centre = Vec3d(0)) { return makeSphere(radius, 5, centre); }

/// The largest error over the active nodes, voxels.
double worstInVoxels(const FloatGrid& phi, const DistanceTo& exact) {
  double most = 0;
  for (auto value = phi.cbeginValueOn(); value; ++value)
    most = std::max(
        most, std::abs(static_cast<double>(*value) - exact(phi.indexToWorld(value.getCoord()))) / phi.voxelSize()[0]);
  return most;
}

/// Whether all nodes have the same values and states, tiles included.
void expectSameBand(const FloatGrid& a, const FloatGrid& b) {
  EXPECT_EQ(a.background(), b.background());
  ASSERT_TRUE(a.tree().hasSameTopology(b.tree()));
  auto other = b.tree().cbeginValueAll();
  for (auto value = a.tree().cbeginValueAll(); value; ++value, ++other) ASSERT_EQ(*value, *other) << value.getCoord();
}

class HollowSolids : public testing::Test {
 protected:
  static void SetUpTestSuite() { openvdb::initialize(); }

  void expectDistances(const Mesh& mesh, const DistanceTo& exact, const PartCounts& counts) {
    PartCounts found;
    const FloatGrid::Ptr phi = meshToSdf(mesh, hollowBand(Hollows::Keep), mMonitor, &found);
    EXPECT_LT(worstInVoxels(*phi, exact), 0.05);
    EXPECT_EQ(found, counts) << found.intersecting << ' ' << found.hollows << ' ' << found.inner;
    // Beyond the bands each node has its side.
    for (auto value = phi->cbeginValueOff(); value; ++value) {
      if (!value.isVoxelValue()) continue;
      ASSERT_EQ(*value < 0, exact(phi->indexToWorld(value.getCoord())) < 0) << value.getCoord();
    }
  }

  Monitor mMonitor;
};

// Promise of targets.md: `--hollows keep`: "A part bounds a hollow if the number is 0 just inside of it, and a part in
//   a hollow is a solid again, to any depth"; `fill` fills hollows
TEST_F(HollowSolids, AnInnerPartIsACavityWhereTheWindingNumberIsZero) {
  const Mesh outer = fineSphere(1), inner = fineSphere(0.5);
  const DistanceTo shell = differenceOf(toBall(1), toBall(0.5));
  for (const Mesh& mesh : {merged(outer, flipped(inner)), merged(flipped(outer), inner), merged(flipped(inner), outer)})
    expectDistances(mesh, shell, {.hollows = 1});
  for (const Mesh& mesh : {merged(outer, inner), merged(flipped(outer), flipped(inner))})
    expectDistances(mesh, toBall(1), {.inner = 1});
  // From the corners of a soup that are not welded it is the same.
  expectDistances(makeSoup(merged(outer, flipped(inner)), 0), shell, {.hollows = 1});
}

// Promise: `--hollows keep`: "A part ..."
TEST_F(HollowSolids, FilledTheyAreWhatTheOuterPartIsAlone) {
  const Mesh outer = fineSphere(1);
  const FloatGrid::Ptr solid = meshToSdf(outer, hollowBand(Hollows::Fill, 4, 4), mMonitor);
  for (const auto& [mesh, counts] :
       {std::pair(merged(outer, flipped(fineSphere(0.5))), PartCounts{.hollows = 1}),
        std::pair(merged(outer, fineSphere(0.5)), PartCounts{.inner = 1}),
        std::pair(mergedAll({outer, flipped(fineSphere(0.7)), fineSphere(0.4)}), PartCounts{.hollows = 1})}) {
    PartCounts found;
    expectSameBand(*meshToSdf(mesh, hollowBand(Hollows::Fill, 4, 4), mMonitor, &found), *solid);
    EXPECT_EQ(found, counts) << found.intersecting << ' ' << found.hollows << ' ' << found.inner;
  }
}

TEST_F(HollowSolids, WithoutAHollowKeepChangesNothing) {
  for (const Mesh& mesh :
       {fineSphere(1), merged(fineSphere(1), fineSphere(0.5)), merged(fineSphere(1), fineSphere(0.7, Vec3d(0.8, 0, 0))),
        merged(fineSphere(0.5), flipped(fineSphere(0.5, Vec3d(2, 0, 0))))})
    expectSameBand(*meshToSdf(mesh, hollowBand(Hollows::Keep, 4, 4), mMonitor),
                   *meshToSdf(mesh, hollowBand(Hollows::Fill, 4, 4), mMonitor));
}

// Promise: `--hollows keep`: "A part ..."
TEST_F(HollowSolids, LevelsAlternate) {
  const DistanceTo three = unionOf(differenceOf(toBall(1.2), toBall(0.9)), toBall(0.6)),
                   four = differenceOf(three, toBall(0.3));
  const Mesh first = fineSphere(1.2), second = flipped(fineSphere(0.9)), third = fineSphere(0.6),
             fourth = flipped(fineSphere(0.3));
  expectDistances(mergedAll({first, second, third}), three, {.hollows = 1});
  expectDistances(mergedAll({fourth, second, first, third}), four, {.hollows = 2});
  expectDistances(flipped(mergedAll({first, second, third, fourth})), four, {.hollows = 2});
  // Winding numbers 1, 2, 1, 0: only the last one is a cavity.
  expectDistances(mergedAll({first, fineSphere(0.9), flipped(third), fourth}), differenceOf(toBall(1.2), toBall(0.3)),
                  {.hollows = 1, .inner = 2});
}

TEST_F(HollowSolids, CavitiesOfAnyShapeAndNumber) {
  expectDistances(merged(fineSphere(1), flipped(makeTorus(0.55, 0.2))), differenceOf(toBall(1), toTorus(0.55, 0.2)),
                  {.hollows = 1});
  const Vec3d a(0.5, 0.1, 0.2), b(-0.4, -0.3, 0.1), c(0, 0.3, -0.6);
  expectDistances(mergedAll({fineSphere(1), flipped(fineSphere(0.25, a)), flipped(fineSphere(0.3, b)),
                             flipped(fineSphere(0.2, c))}),
                  differenceOf(toBall(1), unionOf(unionOf(toBall(0.25, a), toBall(0.3, b)), toBall(0.2, c))),
                  {.hollows = 3});
  // A hollow in one of two solids beside each other, and in the union of two.
  expectDistances(mergedAll({fineSphere(0.8), flipped(fineSphere(0.4)), fineSphere(0.5, Vec3d(2, 0, 0))}),
                  unionOf(differenceOf(toBall(0.8), toBall(0.4)), toBall(0.5, Vec3d(2, 0, 0))), {.hollows = 1});
}

// Promise: `--hollows keep`: "A part ..."
TEST_F(HollowSolids, PartsThatCrossAreOneSurface) {
  const Vec3d aside(0.5, 0, 0);
  PartCounts found;
  // The cavity lies in both of the solids, whose union it is in.
  FloatGrid::Ptr phi = meshToSdf(mergedAll({fineSphere(1), fineSphere(1, aside), flipped(fineSphere(0.3, aside / 2))}),
                                 hollowBand(Hollows::Keep), mMonitor, &found);
  EXPECT_EQ(found, (PartCounts{.intersecting = 2, .inner = 1})) << "the winding number in it is 1";
  const auto at = [&phi](const Vec3d& p) { return phi->tree().getValue(openvdb::Coord::round(phi->worldToIndex(p))); };
  EXPECT_LT(at(aside / 2), 0.0F);
  // In one of them it is a cavity.
  phi = meshToSdf(mergedAll({fineSphere(1), fineSphere(1, aside * 2), flipped(fineSphere(0.2, Vec3d(-0.5, 0, 0)))}),
                  hollowBand(Hollows::Keep), mMonitor, &found);
  EXPECT_EQ(found, (PartCounts{.intersecting = 2, .hollows = 1}));
  EXPECT_GT(at(Vec3d(-0.5, 0, 0)), 0.0F);
  // Two that cross are one cavity.
  const Vec3d left(-0.2, 0, 0), right(0.2, 0, 0);
  phi = meshToSdf(mergedAll({fineSphere(1), flipped(fineSphere(0.3, left)), flipped(fineSphere(0.3, right))}),
                  hollowBand(Hollows::Keep), mMonitor, &found);
  EXPECT_EQ(found, (PartCounts{.intersecting = 2, .hollows = 1}));
  for (const Vec3d& p : {left, right, Vec3d(0), Vec3d(-0.4, 0, 0)}) EXPECT_GT(at(p), 0.0F) << p;
  EXPECT_LT(at(Vec3d(0, 0.6, 0)), 0.0F);
}

TEST_F(HollowSolids, APartThatCrossesTheOuterOneIsNoHollow) {
  const Mesh outer = makeBox(Vec3d(-1), Vec3d(1));
  for (const Mesh& inner : {makeBox(Vec3d(0.2, -0.3, -0.3), Vec3d(1.3, 0.3, 0.3)),   // crosses
                            makeBox(Vec3d(0.2, -0.3, -0.3), Vec3d(1, 0.3, 0.3))}) {  // touches with a face
    PartCounts found;
    const Mesh mesh = merged(outer, flipped(inner));
    const FloatGrid::Ptr kept = meshToSdf(mesh, hollowBand(Hollows::Keep, 4, 4), mMonitor, &found);
    EXPECT_EQ(found, (PartCounts{.intersecting = 2}));
    expectSameBand(*kept, *meshToSdf(mesh, hollowBand(Hollows::Fill, 4, 4), mMonitor));
  }
}

TEST_F(HollowSolids, OpenPartsAndPartsOfNoOrientationDecideNothing) {
  const Mesh outer = fineSphere(1), inner = flipped(fineSphere(0.5));
  Mesh sheet;
  sheet.points = {{-0.7, 0, 0}, {0.7, 0, 0}, {0, 0.7, 0}};
  sheet.triangles = {Vec3I(0, 1, 2)};
  // A sheet that passes through the wall of the cavity is part of neither.
  expectDistances(mergedAll({outer, sheet, inner}), differenceOf(toBall(1), toBall(0.5)),
                  {.intersecting = 2, .hollows = 1});
  Mesh mixed = outer;
  std::swap(mixed.triangles[7][0], mixed.triangles[7][1]);
  expectDistances(merged(mixed, inner), toBall(1), {.inner = 1});
  mixed = inner;
  std::swap(mixed.triangles[7][0], mixed.triangles[7][1]);
  expectDistances(merged(outer, mixed), toBall(1), {.inner = 1});
}

TEST_F(HollowSolids, ANarrowerBandIsThatOfTheWiderOne) {
  const Mesh mesh = mergedAll({fineSphere(1.2), flipped(fineSphere(0.9)), fineSphere(0.6)});
  const FloatGrid::Ptr wide = meshToSdf(mesh, hollowBand(Hollows::Keep, 9, kToTheMiddle), mMonitor);
  for (const auto& [exterior, interior] : {std::pair{2.5, 3.0}, {6.0, 2.0}, {2.0, 7.5}, {3.0, kToTheMiddle}}) {
    const MeshToSdfOptions options = hollowBand(Hollows::Keep, exterior, interior);
    expectSameBand(*vdbtools::narrowed(wide, options), *meshToSdf(mesh, options, mMonitor));
  }
}

TEST_F(HollowSolids, MendedShapesHaveThemToo) {
  const auto made = [&](const Mesh& mesh, const vdbtools::MendOptions& mend) {
    return vdbtools::makeSdf(mesh, vdbtools::sdfBand(kFineVoxel, 4, 4), mend, mMonitor);
  };
  // An outer ball with a hole, which is capped.
  const Mesh open = withoutTriangles(fineSphere(1), [](const Vec3d& c) { return c[2] > 0.9; });
  const Mesh mesh = merged(open, flipped(fineSphere(0.5)));
  const vdbtools::MeshSdf repaired = made(mesh, {.repair = true, .hollows = Hollows::Keep});
  EXPECT_EQ(repaired.caps, 1U);
  EXPECT_EQ(repaired.parts, (PartCounts{.hollows = 1}));
  EXPECT_GT(repaired.grid->tree().getValue(openvdb::Coord(0)), 0.0F);
  EXPECT_LT(made(mesh, {.repair = true}).grid->tree().getValue(openvdb::Coord(0)), 0.0F);
  // Everything near a closed surface, and what it encloses or not.
  const vdbtools::MeshSdf plate = made(fineSphere(1), {.thicken = 0.2, .hollows = Hollows::Keep});
  EXPECT_EQ(plate.parts, (PartCounts{.hollows = 1}));
  EXPECT_LT(worstInVoxels(*plate.grid, differenceOf(toBall(1.1), toBall(0.9))), 0.1);
  EXPECT_LT(worstInVoxels(*made(fineSphere(1), {.thicken = 0.2}).grid, toBall(1.1)), 0.1);
}

}  // namespace
