// SPDX-License-Identifier: Apache-2.0
// The settings with which the library uses Eigen.
#include <gtest/gtest.h>
#include <Eigen/Core>

namespace {

// The sizes decide how a product is split, and so in which order it sums.
TEST(Eigen, assumesTheSameCachesOnEveryMachine) {
  EXPECT_EQ(Eigen::l1CacheSize(), 32 << 10);
  EXPECT_EQ(Eigen::l2CacheSize(), 512 << 10);
  EXPECT_EQ(Eigen::l3CacheSize(), 4 << 20);
}

}  // namespace
