// SPDX-License-Identifier: Apache-2.0
// What is finer than the voxels: of textures and plates whose sizes are known, and what --resolution auto makes of it.
#include "support/temporary_folder.h"
#include "support/test_fields.h"

#include "vdbtools/base/memory.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/recipe/option_value.h"
#include "vdbtools/scene/voxel_advice.h"

#include <gtest/gtest.h>

#include <tbb/global_control.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace {

using namespace vdbtools;
using openvdb::Vec3d;

/// Its versor turns once over a length, along X.
class TurningVersor final : public julia::FieldEvaluator {
 public:
  explicit TurningVersor(double length) : mLength(length) {}
  void evaluate(std::span<const julia::Point>, std::span<double>, std::span<int>) const override {}
  void orbitTraps(std::span<const julia::Point>, std::span<double>) const override {}
  void versors(std::span<const julia::Point> points, std::span<julia::Quaternion<double>> versors) const override {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double angle = 2 * 3.14159265358979 * points[i][0] / mLength;
      versors[i] = {std::cos(angle), 0, std::sin(angle), 0};
    }
  }

 private:
  double mLength;
};

class VoxelAdviceTest : public testing::Test {
 protected:
  VoxelAdviceTest() { openvdb::initialize(); }

  /// A plate 1 by 1 by a thickness.
  std::string plate(double thickness) const {
    const std::string path = mFolder.path() / ("plate" + std::to_string(thickness) + ".vdb");
    const auto distance = [=](const Vec3d& x) {
      const Vec3d beyond(std::abs(x[0]) - 0.5, std::abs(x[1]) - thickness / 2, std::abs(x[2]) - 0.5);
      const Vec3d outside(std::max(beyond[0], 0.0), std::max(beyond[1], 0.0), std::max(beyond[2], 0.0));
      return outside.length() + std::min(0.0, std::max({beyond[0], beyond[1], beyond[2]}));
    };
    std::ofstream(path, std::ios::binary)
        << encodeVdb({test_fields::bandGrid(distance, 0.0125, 0.06)}, {.half = false, .metadata = {}});
    return path;
  }
  Scene scene(Recipe recipe) {
    if (!recipe.contains("voxel-size")) recipe.emplace("resolution", "40");
    return makeScene(parseFractalOptions(recipe), mMonitor);
  }

  TemporaryFolder mFolder;
  Monitor mMonitor;
};

// Promise: "Files above 1 GiB are refused ..."
TEST_F(VoxelAdviceTest, TheResolutionThatFitsIsTheFinestThatDoes) {
  const std::string input = plate(0.2);
  const auto fitting = [&](double resolution, double bytes) {
    return fittingResolution(scene({{"input", input}, {"resolution", std::to_string(static_cast<int>(resolution))}}),
                             bytes);
  };
  EXPECT_FALSE(fitting(2000, std::numeric_limits<double>::infinity()));
  double before = 0;
  for (const double bytes : {3e8, 5e8, 2e9}) {
    const std::optional<double> fits = fitting(4000, bytes);
    ASSERT_TRUE(fits);
    EXPECT_GT(*fits, before);
    EXPECT_FALSE(fitting(*fits, bytes));
    EXPECT_EQ(fitting(*fits + 10, bytes), fits);
    before = *fits;
  }
  EXPECT_EQ(fitting(40, 0), 0);
}

// Promise: Where "more than a quarter ..."
TEST_F(VoxelAdviceTest, TheWidthOfAKnownTextureIsFound) {
  const Scene made = scene({{"input", plate(0.2)}});
  for (const double length : {0.3, 0.04, 0.005}) {
    const FeatureSizes sizes = measureFeatureSizes(made.target->distances, made.shellOptions(), TurningVersor(length),
                                                   made.placed.space, std::nullopt, mMonitor);
    ASSERT_GT(sizes.texture.count(), 1000U);
    // The target's longest side is 1 in either space.
    for (const double share : {0.0, 0.5, 1.0}) EXPECT_NEAR(sizes.texture.quantile(share), length, 0.02 * length);
    EXPECT_EQ(adviseVoxels(sizes, 0.6 * length).textureShare, 1);
    EXPECT_EQ(adviseVoxels(sizes, 0.4 * length).textureShare, 0);
  }
}

// Promise: Where "more than a quarter ..."
TEST_F(VoxelAdviceTest, TwiceTheFrequencyIsHalfTheWidth) {
  const std::string path = plate(0.2);
  for (const char* versor : {"scales", "coral", "quills"}) {
    const Scene coarse = scene({{"input", path}, {"texture", versor}, {"frequency", "1"}});
    const Scene fine = scene({{"input", path}, {"texture", versor}, {"frequency", "2"}});
    const Scene scaled = scene({{"input", path}, {"texture", versor}, {"frequency", "1"}, {"texture-scale", "2"}});
    for (const double share : {0.1, 0.25, 0.5}) {
      const double width = coarse.features()->texture.quantile(share);
      EXPECT_NEAR(fine.features()->texture.quantile(share), width / 2, 0.1 * width) << versor;
      EXPECT_NEAR(scaled.features()->texture.quantile(share), 2 * width, 0.4 * width) << versor;
    }
  }
}

// Promise: Where the core that detail ...
TEST_F(VoxelAdviceTest, TheCoreOfAPlateIsWhatDetailLeavesOfItsThickness) {
  for (const double thickness : {0.05, 0.1})
    for (const double detail : {0.5, 0.8, 0.9}) {
      const double core = thickness * (1 - detail);
      const Scene made = scene({{"input", plate(thickness)}, {"detail", std::to_string(detail)}});
      if (core > 0.019) continue;
      // The thickness is known to a small part of the voxels of its lattice.
      for (const double share : {0.1, 0.4})
        EXPECT_NEAR(made.features()->core.quantile(share), core, 0.1 * core) << thickness << ' ' << detail;
      EXPECT_GT(adviseVoxels(*made.features(), core).coreShare, 0.5);
    }
}

// Promise: Where "more than a quarter ..."
TEST_F(VoxelAdviceTest, TheVoxelsThatAreNamedDo) {
  for (const char* detail : {"0.3", "0.9"}) {
    const Scene made = scene({{"input", plate(0.08)}, {"detail", detail}});
    const VoxelAdvice advice = adviseVoxels(*made.features(), made.voxelSize);
    ASSERT_TRUE(advice.textureVoxel);
    EXPECT_LE(adviseVoxels(*made.features(), *advice.textureVoxel).textureShare, kTextureLeftOut);
    EXPECT_GT(adviseVoxels(*made.features(), 1.5 * *advice.textureVoxel).textureShare, kTextureLeftOut);
    // Finer voxels leave less out.
    double before = 1;
    for (double voxel = 0.05; voxel > 0.001; voxel /= 2) {
      const double share = adviseVoxels(*made.features(), voxel).textureShare;
      EXPECT_LE(share, before);
      before = share;
    }
    EXPECT_EQ(finerThanVoxelsText(made).empty(), advice.textureShare <= kTextureWorthSaying);
  }
}

TEST_F(VoxelAdviceTest, NothingIsSaidOfAPlainTarget) {
  const std::string path = plate(0.2);
  EXPECT_TRUE(scene({{"input", path}, {"mask", "0"}}).features()->texture.empty());
  EXPECT_TRUE(scene({{"input", path}, {"detail", "0"}, {"outward", "0"}}).features()->texture.empty());
  // With alpha no core is promised.
  EXPECT_TRUE(scene({{"input", path}, {"alpha", "40"}}).features()->core.empty());
  EXPECT_FALSE(scene({{"map", "quadratic"}}).features());
}

// Promise of design.md: What is measured depends "on no lattice of the result"
TEST_F(VoxelAdviceTest, IsTheSameForAnyNumberOfThreadsAndAnyLattice) {
  const std::string path = plate(0.1);
  const auto sizes = [&](const char* voxel, int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    const Scene made = scene({{"input", path}, {"voxel-size", voxel}, {"detail", "0.9"}});
    std::vector<double> all{made.features()->area};
    for (int i = 0; i <= 200; ++i) {
      all.push_back(made.features()->texture.quantile(i / 200.0));
      all.push_back(made.features()->core.quantile(i / 200.0));
    }
    return all;
  };
  const std::vector<double> one = sizes("0.05", 1);
  EXPECT_EQ(sizes("0.05", 3), one);
  EXPECT_EQ(sizes("0.01", 2), one);
}

// Promise: "The recipe holds the number ..."
TEST_F(VoxelAdviceTest, AutomaticIsTheNumberThatShowsTheTextureAndIsRecorded) {
  const Recipe recipe{{"input", plate(0.04)}, {"frequency", "4"}, {"resolution", "auto"}};
  const Scene made = scene(recipe);
  ASSERT_TRUE(made.chosenResolution);
  const double resolution = made.chosenResolution->resolution;
  EXPECT_EQ(made.chosenResolution->limit, ChosenResolution::Limit::None);
  EXPECT_EQ(std::fmod(resolution, 10), 0);
  EXPECT_GT(resolution, 300);
  EXPECT_NEAR(made.voxelSize, 1 / resolution, 1e-3 / resolution);
  EXPECT_LE(adviseVoxels(*made.features(), made.voxelSize).textureShare, kTextureLeftOut);
  EXPECT_GT(adviseVoxels(*made.features(), 1 / (resolution - 10)).textureShare, kTextureLeftOut);
  // The same recipe with the number is the same scene.
  const Recipe numbered{{"input", recipe.at("input")}, {"frequency", "4"}, {"resolution", numbersText({resolution})}};
  const Scene again = scene(numbered);
  EXPECT_EQ(sceneMetadata(made, recipe), sceneMetadata(again, numbered));
  EXPECT_EQ(made.voxelSize, again.voxelSize);
  EXPECT_EQ(made.field.arithmetic, again.field.arithmetic);
}

// Promise: "The recipe holds the number ..."
TEST_F(VoxelAdviceTest, AutomaticKeepsWithinMemoryAndItsBounds) {
  const std::string path = plate(0.04);
  const double all = scene({{"input", path}, {"resolution", "auto"}}).chosenResolution->resolution;
  {
    const MemoryLimit limit(250e6);
    const auto chosen = [&](const Recipe& wanted) {
      Recipe recipe{{"input", path}, {"resolution", "auto"}};
      recipe.insert(wanted.begin(), wanted.end());
      const ChosenResolution choice = *scene(recipe).chosenResolution;
      EXPECT_EQ(choice.limit, ChosenResolution::Limit::Memory);
      EXPECT_GE(choice.resolution, 10);
      return choice.resolution;
    };
    const double plain = chosen({});
    EXPECT_LT(plain, all);
    // What takes more memory leaves fewer voxels.
    for (const Recipe& more : {Recipe{{"largest", "2"}}, Recipe{{"lod", "100%,10%"}}, Recipe{{"adaptivity", "0.1"}},
                               Recipe{{"grids", "surface,versor"}}, Recipe{{"attributes", "Cd"}}})
      EXPECT_LT(chosen(more), plain) << more.begin()->first;
    EXPECT_LT(chosen({{"attributes", "Cd,direction,trap"}}), chosen({{"attributes", "Cd"}}));
    EXPECT_LT(chosen({{"grids", "density,versor"}}), chosen({{"grids", "surface,versor"}}));
  }
  // However fine it is, there is a most; and however coarse, a least.
  const ChosenResolution most = *scene({{"input", path}, {"frequency", "16"}, {"resolution", "auto"}}).chosenResolution;
  EXPECT_EQ(most.limit, ChosenResolution::Limit::Most);
  EXPECT_EQ(most.resolution, 1000);
  EXPECT_EQ(scene({{"input", path}, {"frequency", "0.1"}, {"resolution", "auto"}}).chosenResolution->resolution, 300);
  // A box a tenth as long has as many voxels along its own side.
  const Scene boxed =
      scene({{"input", path}, {"frequency", "0.1"}, {"box", "0,-0.05,0,0.1,0.05,0.1"}, {"resolution", "auto"}});
  EXPECT_NEAR(boxed.chosenResolution->resolution, 3000, 10);
}

}  // namespace
