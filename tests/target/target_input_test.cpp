// SPDX-License-Identifier: Apache-2.0
// The distances of a target in a band: the same bits, however much wider the distances are that it is taken from. The
// voxels that they have if nobody chose them.
#include "support/temporary_folder.h"
#include "support/test_fields.h"
#include "support/test_meshes.h"

#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/target/target_input.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace vdbtools;
using namespace test_meshes;
using openvdb::FloatGrid;
using openvdb::Vec3d;

class BandOfATarget : public testing::Test {
 protected:
  BandOfATarget() { openvdb::initialize(); }

  static TargetOptions optionsOf(const Mesh& mesh, const MendOptions& mend) {
    TargetOptions options;
    options.mesh = std::make_shared<const Mesh>(mesh);
    options.input.path = "mesh";
    options.sdfVoxels = VoxelChoice{.resolution = 21.3};
    options.mend = mend;
    return options;
  }

  /// Leaves, tiles, background, active nodes and all values.
  static void expectSame(const Target& a, const Target& b) {
    ASSERT_EQ(a.phi->background(), b.phi->background());
    ASSERT_EQ(a.phi->voxelSize(), b.phi->voxelSize());
    for (const Vec3d& at : {Vec3d(0), Vec3d(31, -17, 5)}) ASSERT_EQ(a.phi->indexToWorld(at), b.phi->indexToWorld(at));
    ASSERT_TRUE(a.phi->tree().hasSameTopology(b.phi->tree()));
    auto other = b.phi->cbeginValueAll();
    for (auto value = a.phi->cbeginValueAll(); value; ++value, ++other) ASSERT_EQ(*value, *other) << value.getCoord();
    EXPECT_EQ(a.denseBox, b.denseBox);
    EXPECT_EQ(a.repairMoved, b.repairMoved);
  }

  /// Bands of all widths of some, from distances for all that hold them.
  void expectOneBandFor(const TargetInput& input) {
    std::mt19937 random(3);
    const double longest = input.box().extents()[input.box().maxExtent()];
    std::vector<BandWidths> widths;
    constexpr int kWidths = 4;
    for (int i = 0; i < kWidths; ++i)
      widths.push_back({longest * static_cast<double>(random() % 1000) / 4000,
                        longest * static_cast<double>(random() % 1000) / 4000, i == 2});
    int compared = 0;
    for (const BandWidths& narrow : widths) {
      const Target alone = input.band(input.distances(narrow, mMonitor), narrow, mMonitor);
      for (BandWidths wide : widths) {
        wide.exterior += narrow.exterior;
        wide.interior += narrow.interior;
        wide.wholeInside |= narrow.wholeInside;
        ASSERT_TRUE(wide.holds(narrow));
        expectSame(input.band(input.distances(wide, mMonitor), narrow, mMonitor), alone);
        ++compared;
      }
    }
    EXPECT_EQ(compared, kWidths * kWidths);
  }

  TemporaryFolder mFolder;
  Monitor mMonitor;
};

// Promise of design.md: "A scene therefore gets a band of its own widths, to the bit, however much wider the distances
//   are that it is cut out of"
TEST_F(BandOfATarget, OfMeshes) {
  const Mesh two = merged(makeSphere(1, 3), makeSphere(0.4, 3, Vec3d(1.2, 0.3, 0.1)));
  for (const Mesh& mesh : {two, makeSoup(makeSphere(1, 4, Vec3d(7, 0, -2)), 0.01), makeCube()})
    expectOneBandFor(*openTarget(optionsOf(mesh, {}), mMonitor));
}

// Promise: "A scene therefore gets a band ..."
TEST_F(BandOfATarget, OfMendedMeshes) {
  const auto top = [](const Vec3d& at) { return at[1] > 0.5; };
  const Mesh open = withoutTriangles(makeSphere(1, 3), top);
  expectOneBandFor(*openTarget(optionsOf(open, {.repair = true}), mMonitor));
  expectOneBandFor(*openTarget(optionsOf(open, {.repair = true, .gap = 1.8}), mMonitor));
  expectOneBandFor(*openTarget(optionsOf(open, {.thicken = 0.3}), mMonitor));
}

// A repair that moves the surface far says the same of it in each band.
// Promise: "A scene therefore gets a band ..."
TEST_F(BandOfATarget, OfMeshesWithPartsThatBoundNothing) {
  const Mesh sheet =
      withoutTriangles(makeSphere(0.3, 3, Vec3d(0, 1.5, 0)), [](const Vec3d& at) { return at[1] > 1.3; });
  expectOneBandFor(*openTarget(
      optionsOf(merged(withoutTriangles(makeSphere(1, 4), [](const Vec3d& at) { return at[0] > 0.95; }), sheet),
                {.repair = true}),
      mMonitor));
}

// Promise: "A scene therefore gets a band ..."
TEST_F(BandOfATarget, OfVdbs) {
  for (const FloatGrid::Ptr& grid :
       {test_fields::bandGrid(test_fields::lumpy, 0.04, 0.12, 0.12),
        test_fields::denseGrid(test_fields::lumpy, 0.06,
                               openvdb::CoordBBox(openvdb::Coord(-12), openvdb::Coord(12)))}) {
    TargetOptions options;
    options.input.path = mFolder.path() / "target.vdb";
    std::ofstream(options.input.path, std::ios::binary) << encodeVdb({grid}, {});
    expectOneBandFor(*openTarget(options, mMonitor));
  }
}

// Where a cloud has a hole, coarse voxels close it and fine ones do not.
TEST_F(BandOfATarget, TheSurveyOfACloudEnclosesWhatTheDistancesEnclose) {
  const Mesh sphere = makeSphere(1, 5);
  int open = 0, closed = 0;
  for (const double hole : {0.05, 0.16, 0.22, 0.28, 0.34, 0.5}) {
    Mesh cloud;
    for (const Vec3d& point : sphere.points)
      if (std::hypot(point[0], point[1]) > hole || point[2] < 0) cloud.points.push_back(point);
    TargetOptions options = optionsOf(cloud, {.pointsRadius = 0.15});
    options.sdfVoxels = VoxelChoice{.resolution = 60};
    const std::unique_ptr<const TargetInput> input = openTarget(options, mMonitor);
    const FloatGrid::ConstPtr fine = input->distances({0.1, 0.1, true}, mMonitor).phi,
                              coarse = input->coarseDistances(mMonitor).phi;
    const auto at = [](const FloatGrid& grid) {
      return grid.tree().getValue(openvdb::Coord::round(grid.worldToIndex(Vec3d(0))));
    };
    EXPECT_EQ(at(*fine) < 0, at(*coarse) < 0) << hole;
    ++(at(*fine) < 0 ? closed : open);
  }
  EXPECT_GT(open, 0);
  EXPECT_GT(closed, 0);
}

class ChosenSdfResolution : public BandOfATarget {
 protected:
  static TargetOptions boxOf(const Vec3d& sides) {
    TargetOptions options = optionsOf(makeBox(sides * -0.5, sides * 0.5), {});
    options.sdfVoxels.reset();
    return options;
  }
  double chosenFor(const Vec3d& sides) {
    return openTarget(boxOf(sides), mMonitor)->chosenSdfResolution(mMonitor).value();
  }
};

// Promise of options.md: "`auto`, the default, takes 200 voxels along the longest side, or as many as give thin parts 8
//   voxels"
TEST_F(ChosenSdfResolution, ThinPartsHaveEightVoxels) {
  EXPECT_EQ(chosenFor(Vec3d(1)), kUsualSdfResolution);
  EXPECT_EQ(chosenFor(Vec3d(1, 0.7, 0.5)), kUsualSdfResolution);
  for (const double thin : {0.01, 0.013}) {
    const double chosen = chosenFor(Vec3d(1, thin, thin));
    // A corner of a square rod is nearer to its edges than to its deepest line.
    EXPECT_GT(chosen * thin, 8 * 0.95) << thin;
    EXPECT_LT(chosen * thin, 8 * 1.4) << thin;
    EXPECT_EQ(std::remainder(chosen, 10), 0) << thin;
    EXPECT_NEAR(chosenFor(Vec3d(1000, 1000 * thin, 1000 * thin)), chosen, 10) << thin;
  }
}

// Promise of design.md: "no more than 400,000 on the surface, a limit that is the same on every machine"
TEST_F(ChosenSdfResolution, TheSurfaceHasNoMoreVoxelsThanTheLimit) {
  constexpr double kThin = 0.01, kArea = 3 * (2 + 4 * kThin);
  TargetOptions options = boxOf(Vec3d(1));
  Mesh plates;
  for (const double z : {-0.4, 0.0, 0.4})
    plates = merged(plates, makeBox(Vec3d(-0.5, -0.5, z), Vec3d(0.5, 0.5, z + kThin)));
  options.mesh = std::make_shared<const Mesh>(plates);
  const double chosen = openTarget(options, mMonitor)->chosenSdfResolution(mMonitor).value();
  EXPECT_GT(chosen, kUsualSdfResolution);
  EXPECT_NEAR(kArea * chosen * chosen, 400'000, 0.1 * 400'000);
}

// Promise: "`auto`, the default, takes ..."
TEST_F(ChosenSdfResolution, DistancesHaveTheVoxelsOfTheSameNumberGiven) {
  TargetOptions options = boxOf(Vec3d(1, 0.015, 0.02));
  const std::unique_ptr<const TargetInput> chooses = openTarget(options, mMonitor);
  options.sdfVoxels = VoxelChoice{.resolution = chooses->chosenSdfResolution(mMonitor)};
  const std::unique_ptr<const TargetInput> given = openTarget(options, mMonitor);
  EXPECT_EQ(given->chosenSdfResolution(mMonitor), std::nullopt);
  const BandWidths widths{0.02, 0.02, false};
  expectSame(chooses->distances(widths, mMonitor), given->distances(widths, mMonitor));
  const auto survey = [&](const TargetInput& input) {
    return makeTarget(std::const_pointer_cast<FloatGrid>(input.coarseDistances(mMonitor).phi), input.box());
  };
  expectSame(survey(*chooses), survey(*given));
}

}  // namespace
