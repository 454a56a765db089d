// SPDX-License-Identifier: Apache-2.0
// VDBs as targets: a ball is the same target in every kind of grid that says where it is.
#include "support/temporary_folder.h"

#include "vdbtools/base/memory.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/target/target_input.h"

#include <openvdb/tools/SignedFloodFill.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>

namespace {

using namespace vdbtools;
using openvdb::BBoxd;
using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::Mat4d;
using openvdb::Vec3d;
using openvdb::math::Transform;

constexpr double kVoxel = 0.05;
using Values = std::function<double(double distance)>;

class VolumeTarget : public testing::Test {
 protected:
  VolumeTarget() { openvdb::initialize(); }

  static Transform::Ptr cubes(double voxel = kVoxel) { return Transform::createLinearTransform(voxel); }
  static Transform::Ptr boxes(const Vec3d& sides) {
    Mat4d matrix = Mat4d::identity();
    matrix.postScale(sides);
    return Transform::createLinearTransform(matrix);
  }
  static Transform::Ptr turned(Transform::Ptr transform, double angle = 0.7) {
    transform->postRotate(angle, openvdb::math::Z_AXIS);
    return transform;
  }

  /// The values of a ball of radius 1 at the nodes of a box around it: at all, or those that are not the background.
  template <class Grid = FloatGrid>
  static typename Grid::Ptr gridOf(Transform::Ptr transform, double background, const Values& values,
                                   const Vec3d& centre = Vec3d(0), bool dense = false) {
    auto grid = Grid::create(static_cast<typename Grid::ValueType>(background));
    grid->setTransform(transform);
    grid->setName("ball");
    constexpr double kMargin = 1.4;
    const BBoxd at = transform->worldToIndex(BBoxd(centre - Vec3d(kMargin), centre + Vec3d(kMargin)));
    auto accessor = grid->getAccessor();
    for (auto node = CoordBBox(Coord::floor(at.min()), Coord::ceil(at.max())).begin(); node; ++node) {
      const auto value =
          static_cast<typename Grid::ValueType>(values((grid->indexToWorld(*node) - centre).length() - 1));
      if (dense || value != grid->background()) accessor.setValue(*node, value);
    }
    return grid;
  }
  static FloatGrid::Ptr denseOf(Transform::Ptr transform, double sign = 1) {
    return gridOf(
        transform, 0, [=](double distance) { return sign * distance; }, Vec3d(0), true);
  }
  /// A level set. @param band  world units
  template <class Grid = FloatGrid>
  static typename Grid::Ptr levelSet(Transform::Ptr transform, double band = 3 * kVoxel,
                                     const Vec3d& centre = Vec3d(0)) {
    auto grid = gridOf<Grid>(
        transform, band, [=](double distance) { return std::clamp(distance, -band, band); }, centre);
    for (auto value = grid->beginValueOn(); value; ++value)
      if (*value == -grid->background()) value.setValueOff();
    openvdb::tools::signedFloodFill(grid->tree());
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    return grid;
  }
  /// A density that falls from 1 to 0 over four voxels around the surface, times a factor.
  static FloatGrid::Ptr fog(Transform::Ptr transform, double most = 1, const Vec3d& centre = Vec3d(0)) {
    auto grid = gridOf(
        transform, 0, [=](double distance) { return most * std::clamp(0.5 - distance / (4 * kVoxel), 0.0, 1.0); },
        centre);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    return grid;
  }

  std::unique_ptr<const TargetInput> opened(const openvdb::GridBase::Ptr& grid, const VolumeOptions& volume = {},
                                            bool half = false) {
    TargetOptions options;
    options.input.path = mFolder.path() / "ball.vdb";
    options.mend.volume = volume;
    std::ofstream(options.input.path, std::ios::binary) << encodeVdb({grid}, {.half = half});
    return openTarget(options, mMonitor);
  }
  Target read(const openvdb::GridBase::Ptr& grid, const VolumeOptions& volume = {}, bool half = false) {
    return opened(grid, volume, half)->distances({}, mMonitor);
  }

  /// @param within  voxels
  static void expectBall(const Target& target, double radius, double within = 0.05, const Vec3d& centre = Vec3d(0)) {
    const FloatGrid& phi = *target.phi;
    const double voxel = phi.voxelSize()[0];
    EXPECT_LT((target.box.min() - (centre - Vec3d(radius))).length(), 2 * within * voxel);
    EXPECT_LT((target.box.max() - (centre + Vec3d(radius))).length(), 2 * within * voxel);
    EXPECT_GT(phi.activeVoxelCount(), 1000u);
    for (auto value = phi.cbeginValueOn(); value; ++value)
      ASSERT_NEAR(*value, (phi.indexToWorld(value.getCoord()) - centre).length() - radius, within * voxel);
    EXPECT_LT(phi.tree().getValue(Coord::round(phi.worldToIndex(centre))), 0);
    EXPECT_GT(phi.background(), 0);
    EXPECT_GT(phi.tree().getValue(Coord::round(phi.worldToIndex(centre + Vec3d(30)))), 0);
  }

  template <class Error>
  std::string refusal(const openvdb::GridBase::Ptr& grid, const VolumeOptions& volume = {}) {
    try {
      read(grid, volume);
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  }
  Remedy remedy(const openvdb::GridBase::Ptr& grid, const VolumeOptions& volume = {}) {
    try {
      read(grid, volume);
    } catch (const DataError& error) {
      return error.remedy();
    }
    return Remedy::None;
  }

  TemporaryFolder mFolder;
  Monitor mMonitor;
};

// Promise of targets.md: "lengths such as the longest side are measured on the surface, not on the box of the grid"; a
//   band whose voxels are no cubes "is resampled to cubes of the smallest side"; "Floats, doubles and halves are read"
TEST_F(VolumeTarget, LengthsAreMeasuredOnTheSurfaceHoweverTheGridIsTurned) {
  for (const double voxel : {0.05, 0.02}) {
    const double band = 3 * voxel;
    const Transform::Ptr twice = turned(cubes(voxel));
    twice->postRotate(0.4, openvdb::math::X_AXIS);
    for (const Transform::Ptr& transform : {cubes(voxel), turned(cubes(voxel)), twice}) {
      const Target target = read(levelSet(transform, band));
      expectBall(target, 1, 0.01);
    }
    const FloatGrid::Ptr dense = denseOf(turned(cubes(voxel)));
    EXPECT_LT((read(dense).box.extents() - Vec3d(2)).length(), 0.02 * voxel);
  }
  // Other programs round their matrices to floats.
  for (double angle = 0.1; angle < 1.5; angle += 0.4) {
    Mat4d rounded = turned(cubes(), angle)->baseMap()->getAffineMap()->getMat4();
    for (int i = 0; i < 16; ++i) rounded.asPointer()[i] = static_cast<float>(rounded.asPointer()[i]);
    const Target target = read(levelSet(Transform::createLinearTransform(rounded)));
    expectBall(target, 1, 0.01);
    EXPECT_TRUE(target.facts.empty());
    Target wide = target;
    extendBand(wide, 0.2, 0.2, mMonitor);
    expectBall(wide, 1, 1.5);
  }
}

// Promise: "lengths such as the longest ..."
TEST_F(VolumeTarget, KindsOfLevelSets) {
  constexpr double kBand = 3 * kVoxel;
  expectBall(read(levelSet(cubes())), 1);
  expectBall(read(levelSet<openvdb::DoubleGrid>(cubes())), 1);
  expectBall(read(levelSet(cubes()), {}, true), 1);
  expectBall(read(levelSet(cubes(), 1.5 * kVoxel)), 1);
  expectBall(read(levelSet(boxes(Vec3d(-kVoxel, kVoxel, kVoxel)))), 1);
  const FloatGrid::Ptr unknown = levelSet(cubes());
  unknown->setGridClass(openvdb::GRID_UNKNOWN);
  expectBall(read(unknown), 1);
  const Vec3d far(1e5, 0, -1e5);
  expectBall(read(levelSet(cubes(), kBand, far)), 1, 0.05, far);
  const Transform::Ptr moved = cubes();
  moved->postTranslate(far);
  expectBall(read(levelSet(moved, kBand, far)), 1, 0.05, far);
}

// Promise: A fog volume's surface is "where ..."
TEST_F(VolumeTarget, ASignThatIsTurnedRoundIsNamedAndCanBeTurnedBack) {
  const FloatGrid::Ptr right = levelSet(cubes()), turned = right->deepCopy(), rootsOnly = right->deepCopy();
  for (auto value = turned->beginValueAll(); value; ++value) value.setValue(-*value);
  rootsOnly->setTree(turned->tree().copy());
  turned->tree().root().setBackground(-right->background(), false);
  ASSERT_GT(rootsOnly->background(), 0);
  for (const FloatGrid::Ptr& wrong : {turned, rootsOnly}) {
    EXPECT_EQ(remedy(wrong), Remedy::TurnSign);
    EXPECT_NE(refusal<DataError>(wrong).find("negative outside"), std::string::npos);
    const Target target = read(wrong, {.invert = true});
    expectBall(target, 1);
    const Target plain = read(right);
    ASSERT_TRUE(target.phi->tree().hasSameTopology(plain.phi->tree()));
    EXPECT_EQ(target.box, plain.box);
    EXPECT_EQ(target.phi->background(), plain.phi->background());
    auto other = plain.phi->cbeginValueAll();
    for (auto value = target.phi->cbeginValueAll(); value; ++value, ++other) ASSERT_EQ(*value, *other);
    expectBall(read(wrong, {.isovalue = 0.1, .invert = true}), 1.1);
  }
  EXPECT_NE(refusal<std::invalid_argument>(right, {.invert = true}).find("negative inside already"), std::string::npos);
  // Nothing tells which side of a dense grid is meant.
  const FloatGrid::Ptr dense = denseOf(cubes(), -1);
  const Target target = read(dense, {.invert = true});
  for (auto value = target.phi->cbeginValueOn(); value; ++value)
    ASSERT_EQ(*value, -dense->tree().getValue(value.getCoord()));
}

// Promise of targets.md: A fog volume's surface is "where its values are half of the largest one"; `--iso V` makes a
//   target "of any other grid of numbers" and "moves the surface outwards by V"; `--invert` "reverses its sign before
//   anything else"
TEST_F(VolumeTarget, AFogVolumeIsSolidWhereItIsAboveHalfOfItsLargestValue) {
  for (const double most : {1.0, 70.0}) {
    const Target target = read(fog(cubes(), most));
    expectBall(target, 1);
    EXPECT_EQ(target.facts, (std::map<std::string, std::string>{{"julia_chosen_iso", most == 1 ? "0.5" : "35"}}));
    const Target quarter = read(fog(cubes(), most), {.isovalue = most / 4});
    expectBall(quarter, 1 + kVoxel);
    EXPECT_TRUE(quarter.facts.empty());
  }
  const Vec3d far(1e5, 0, -1e5);
  expectBall(read(fog(cubes(), 1, far)), 1, 0.05, far);
  expectBall(read(fog(turned(cubes()))), 1);
}

TEST_F(VolumeTarget, WhatAFogVolumeEnclosesStaysHollow) {
  FloatGrid::Ptr shell = gridOf(cubes(), 0, [](double distance) {
    return std::clamp(0.5 - (std::abs(distance + 0.2) - 0.2) / (2 * kVoxel), 0.0, 1.0);
  });
  shell->setGridClass(openvdb::GRID_FOG_VOLUME);
  const Target target = read(shell);
  EXPECT_GT(target.phi->tree().getValue(Coord(0)), 0);
  for (auto value = target.phi->cbeginValueOn(); value; ++value) {
    const double radius = target.phi->indexToWorld(value.getCoord()).length();
    ASSERT_NEAR(*value, std::abs(radius - 0.8) - 0.2, 0.1 * kVoxel);
  }
}

// Promise: A fog volume's surface is "where ..."
TEST_F(VolumeTarget, AnyGridHasASurfaceAtAValue) {
  // A temperature of 20 outside, which rises to the centre.
  const FloatGrid::Ptr warm = gridOf(cubes(), 20, [](double distance) { return std::max(20.0, 60 - 100 * distance); });
  expectBall(read(warm, {.isovalue = 60}), 1);
  expectBall(read(warm, {.isovalue = 80}), 0.8);
  const FloatGrid::Ptr cold = gridOf(cubes(), 20, [](double distance) { return std::min(20.0, -10 + 100 * distance); });
  expectBall(read(cold, {.isovalue = -10, .invert = true}), 1);
  EXPECT_NE(refusal<DataError>(cold, {.isovalue = -10}).find("no end"), std::string::npos);
  // Without a value it is taken for a signed distance.
  EXPECT_NE(remedy(fog(cubes()), {.isovalue = 2}), Remedy::None);
  const FloatGrid::Ptr unknown = fog(cubes());
  unknown->setGridClass(openvdb::GRID_UNKNOWN);
  EXPECT_EQ(remedy(unknown), Remedy::GiveIsovalue);
  expectBall(read(unknown, {.isovalue = 0.5}), 1);
}

// Promise: A fog volume's surface is "where ..."
TEST_F(VolumeTarget, AValueMovesTheSurfaceOfALevelSet) {
  for (const double distance : {-0.1, 0.0, 0.12}) {
    expectBall(read(levelSet(cubes()), {.isovalue = distance}), 1 + distance);
    FloatGrid::Ptr dense = denseOf(cubes());
    dense->setGridClass(openvdb::GRID_LEVEL_SET);
    expectBall(read(dense, {.isovalue = distance}), 1 + distance);
  }
  for (const double beyond : {-0.2, 0.2})
    EXPECT_EQ(remedy(levelSet(cubes()), {.isovalue = beyond}), Remedy::GiveIsovalue);
}

// Promise: "lengths such as the longest ..."
TEST_F(VolumeTarget, UnequalVoxelsBecomeCubesOfTheSmallestSide) {
  const Transform::Ptr sheared = cubes();
  sheared->preShear(0.4, openvdb::math::X_AXIS, openvdb::math::Y_AXIS);
  for (const Transform::Ptr& transform :
       {boxes(Vec3d(kVoxel, kVoxel, 2 * kVoxel)), turned(boxes(Vec3d(2 * kVoxel, kVoxel, 1.3 * kVoxel))), sheared}) {
    const Target level = read(levelSet(transform, 6 * kVoxel)), density = read(fog(transform));
    for (const Target& target : {level, density}) {
      expectBall(target, 1, 0.1);
      EXPECT_NEAR(target.phi->voxelSize()[0], kVoxel, 1e-9);
      EXPECT_EQ(target.facts.count("julia_unequal_voxels"), 1u);
    }
    expectBall(read(levelSet(transform, 6 * kVoxel), {.isovalue = 0.1}), 1.1, 0.1);
  }
  // Where all distances are known, they are used as they are.
  const FloatGrid::Ptr dense = denseOf(boxes(Vec3d(kVoxel, kVoxel, 2 * kVoxel)));
  const Target target = read(dense);
  EXPECT_EQ(target.phi->voxelSize(), dense->voxelSize());
  EXPECT_TRUE(target.facts.empty());
}

TEST_F(VolumeTarget, ASurfaceThatIsTooLargeIsRefusedBeforeItIsMade) {
  const FloatGrid::Ptr huge = FloatGrid::create(0);
  huge->setGridClass(openvdb::GRID_FOG_VOLUME);
  huge->sparseFill(CoordBBox(Coord(0), Coord((1 << 18) - 1, (1 << 18) - 1, (1 << 12) - 1)), 1);
  EXPECT_THROW(read(huge), MemoryError);
}

TEST_F(VolumeTarget, MakingItIsWatchedAndCanBeStopped) {
  class Watch final : public Monitor {
   public:
    void begin(const Phase&, std::uint64_t) override { ++phases; }
    bool cancelled() const override { return isStopped; }
    int phases = 0;
    bool isStopped = false;
  };
  opened(fog(cubes()));
  TargetOptions options;
  options.input.path = mFolder.path() / "ball.vdb";
  Watch watch;
  EXPECT_GT(openTarget(options, watch)->box().volume(), 0);
  EXPECT_GT(watch.phases, 0);
  watch.isStopped = true;
  EXPECT_THROW(openTarget(options, watch), Interrupted);
}

TEST_F(VolumeTarget, ValuesThatAreNotFiniteAreRefused) {
  const FloatGrid::Ptr broken = fog(cubes());
  broken->tree().setValue(Coord(3, 4, 5), std::numeric_limits<float>::quiet_NaN());
  EXPECT_NE(refusal<DataError>(broken).find("not finite near index 3, 4, 5"), std::string::npos);
}

}  // namespace
