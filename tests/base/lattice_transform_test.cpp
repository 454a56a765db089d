// SPDX-License-Identifier: Apache-2.0
#include "base/lattice_transform.h"
#include "vdbtools/formats/vdb_file.h"

#include <gtest/gtest.h>

#include <initializer_list>

namespace {

using namespace vdbtools;
using openvdb::Vec3d;

const std::initializer_list<double> kSizes = {1e-12, 1e-8, 1e-5, 1.5e-5, 0.3, 1e6, 1e30};

void expectSame(const openvdb::math::Transform& a, const openvdb::math::Transform& b) {
  for (const Vec3d& node : {Vec3d(0), Vec3d(1, 2, 3), Vec3d(-1e6, 0.5, 7)}) {
    EXPECT_EQ(a.indexToWorld(node), b.indexToWorld(node));
    EXPECT_EQ(a.worldToIndex(a.indexToWorld(node)), b.worldToIndex(b.indexToWorld(node)));
  }
  EXPECT_EQ(a.voxelSize(), b.voxelSize());
}

// Promise: Targets "in units of any ..."
TEST(LatticeTransform, PutsNodesWhereTheyBelong) {
  for (const double size : kSizes) {
    SCOPED_TRACE(size);
    const auto transform = latticeTransform(size);
    EXPECT_EQ(transform->indexToWorld(Vec3d(1, 2, -3)), Vec3d(size, 2 * size, -3 * size));
    EXPECT_NEAR((transform->worldToIndex(Vec3d(size, 2 * size, -3 * size)) - Vec3d(1, 2, -3)).length(), 0, 1e-12);
    EXPECT_EQ(transform->voxelSize(), Vec3d(size));
    expectSame(*transform->copy(), *transform);
  }
}

TEST(LatticeTransform, IsThatOfOpenVdbWhereThereIsOne) {
  for (const double size : {1.45e-5, 0.3, 1e6}) {
    ASSERT_TRUE(isOrdinaryScale(Vec3d(size)));
    expectSame(*latticeTransform(size), *openvdb::math::Transform::createLinearTransform(size));
  }
  for (const double size : {1.44e-5, 1e-12}) {
    EXPECT_FALSE(isOrdinaryScale(Vec3d(size)));
    EXPECT_THROW(openvdb::math::Transform::createLinearTransform(size), openvdb::ArithmeticError);
  }
}

// Promise: Targets "in units of any ..."
TEST(LatticeTransform, EverySecondNodeLiesWhereItLay) {
  for (const double size : kSizes) {
    const auto fine = latticeTransform(size), coarse = coarserTransform(*fine);
    for (const Vec3d& node : {Vec3d(0), Vec3d(1, 2, -3), Vec3d(40, -1, 6)})
      EXPECT_EQ(coarse->indexToWorld(node), fine->indexToWorld(2.0 * node)) << size;
  }
}

// Promise: Targets "in units of any ..."
TEST(LatticeTransform, ComesBackFromAFile) {
  for (const double size : kSizes) {
    const auto grid = openvdb::FloatGrid::create(static_cast<float>(3 * size));
    grid->setName("phi");
    grid->tree().setValueOn(openvdb::Coord(1, 2, 3), static_cast<float>(size));
    grid->setTransform(latticeTransform(size));
    const VdbFile file = decodeVdb(encodeVdb({grid}, {}));
    ASSERT_EQ(file.grids.size(), 1U);
    expectSame(file.grids.front()->transform(), grid->transform());
  }
}

}  // namespace
