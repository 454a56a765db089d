// SPDX-License-Identifier: Apache-2.0
// A scene depends on its recipe and on the files that this names. What the same SceneMaker has made before changes no
// bit of it.
#include "support/temporary_folder.h"
#include "support/test_fields.h"
#include "support/test_meshes.h"

#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/fractal_job.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

namespace {

using namespace vdbtools;
using namespace test_meshes;
using openvdb::CoordBBox;
using openvdb::Vec3d;

class SceneHistory : public testing::Test {
 protected:
  SceneHistory() { openvdb::initialize(); }

  std::string write(const std::string& name, const Mesh& mesh) const {
    std::ostringstream stream;
    writeMesh(stream, mesh, {.format = &meshFormat(".obj")});
    return write(name, stream.str());
  }
  std::string write(const std::string& name, const std::string& bytes) const {
    const std::string path = mFolder.path() / name;
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  /// A body with a thin and a thick part.
  static Mesh snowman() {
    return merged(makeSphere(1, 3),
                  merged(makeSphere(0.45, 3, Vec3d(1.3, 0.2, 0)), makeSphere(0.2, 2, Vec3d(1.8, 0.4, 0))));
  }
  /// All bytes that are made of a scene, or the error that it ends in.
  std::string madeOf(SceneMaker& maker, const Recipe& given) {
    const std::filesystem::path vdb = mFolder.path() / "made.vdb", ply = mFolder.path() / "made.ply";
    try {
      const Recipe recipe = completeRecipe(given, fractalOptionTable());
      const Scene scene = maker.make(parseFractalOptions(recipe), mMonitor);
      AtomicFile grids(vdb), mesh(ply);
      const FractalResult result =
          writeFractal(scene, recipe, {.files = {{&grids, findFormat(".vdb")}, {&mesh, findFormat(".ply")}}}, mMonitor);
      grids.commit();
      mesh.commit();
      std::string bytes = readWholeFile(vdb) + readWholeFile(ply) + std::to_string(result.evaluatedNodes);
      if (scene.target) bytes += encodeVdb({scene.target->distances.phi}, {}) + numbersText({scene.target->volume});
      if (scene.exponent()) bytes += encodeVdb({scene.exponent()->grid}, {});
      return bytes;
    } catch (const DataError& error) {
      return error.what();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
  }
  std::string alone(const Recipe& recipe) {
    SceneMaker maker;
    return madeOf(maker, recipe);
  }
  /// Makes the recipes one after the other through one maker, each of which must be what it is alone.
  /// @return  how many are no errors
  int expectNoHistory(const std::vector<Recipe>& recipes) {
    constexpr std::size_t kLongestError = 2000;
    SceneMaker maker;
    int made = 0;
    for (const Recipe& recipe : recipes) {
      std::string text;
      for (const auto& [name, value] : recipe) text += " --" + name + ' ' + value;
      const std::string expected = alone(recipe);
      EXPECT_TRUE(madeOf(maker, recipe) == expected) << text;
      made += expected.size() > kLongestError;
    }
    return made;
  }

  TemporaryFolder mFolder;
  Monitor mMonitor;
};

/// Draws recipes over some targets.
class RandomRecipes {
 public:
  RandomRecipes(unsigned seed, std::vector<Recipe> targets) : mRandom(seed), mTargets(std::move(targets)) {}

  Recipe next() {
    Recipe recipe = oneOf(mTargets);
    recipe["sdf-resolution"] = oneOf<std::string>({"20", "20", "26"});
    recipe["resolution"] = oneOf<std::string>({"14", "20"});
    if (chance(0.2))
      withoutShell(recipe);
    else
      withShell(recipe);
    maybe(recipe, 0.3, "origin-shift", {"0.1,0,0", "0,-0.05,0.02"});
    maybe(recipe, 0.2, "slice", {"0.1", "-0.2"});
    maybe(recipe, 0.3, "iterations", {"2", "4", "6"});
    maybe(recipe, 0.2, "attributes", {"tau", "depth,mask", "Cd"});
    maybe(recipe, 0.2, "largest", {"1"});
    maybe(recipe, 0.1, "precision", {"double"});
    if (chance(0.15)) {
      recipe["space"] = "world";
      recipe["origin"] = "0,0,0";
    } else if (chance(0.4)) {
      recipe["origin"] = oneOf<std::string>({"centre", "0.05,0,0", "auto"});
    }
    if (!recipe.contains("origin")) maybe(recipe, 0.2, "origin-near", {"0.3,0,0"});
    return recipe;
  }

 private:
  template <class T>
  T oneOf(const std::vector<T>& values) {
    return values[mRandom() % values.size()];
  }
  bool chance(double share) { return mRandom() < share * static_cast<double>(std::mt19937::max()); }
  void maybe(Recipe& recipe, double share, const std::string& name, const std::vector<std::string>& values) {
    if (chance(share)) recipe[name] = oneOf(values);
  }

  void withShell(Recipe& recipe) {
    if (chance(0.7)) {
      recipe["detail"] = oneOf<std::string>({"0.05", "0.1", "0.3", "0.5", "0.9", "x:0.1:0.6", "y:0.4:0.2:smooth",
                                             "expr:0.2+0.3*hx", "expr:min(0.6, 0.1+tau)"});
      maybe(recipe, 0.4, "outward", {"0", "0.3", "z:0:0.4", "expr:min(0.4, tau)"});
    } else {
      recipe["alpha"] = oneOf<std::string>({"8", "20", "60", "200", "x:15:80", "expr:20+60*hy"});
      maybe(recipe, 0.5, "beta", {"-0.03", "0.02", "y:-0.02:0.04"});
    }
    maybe(recipe, 0.3, "mask", {"0.5", "x:0:1", "expr:min(1, 0.5+hz)"});
    maybe(recipe, 0.3, "escape", {"3", "20"});
    maybe(recipe, 0.2, "sampling", {"quadratic"});
    if (chance(0.4)) {
      recipe["texture"] = "random";
      recipe["texture-seed"] = oneOf<std::string>({"1", "2"});
      maybe(recipe, 0.5, "texture-placement", {"inside", "surface"});
    } else {
      maybe(recipe, 0.5, "texture", {"scales", "quills"});
    }
  }

  /// Maps that are evaluated in the box of the target.
  void withoutShell(Recipe& recipe) {
    if (chance(0.5)) {
      recipe["map"] = "quadratic";
      recipe["c"] = oneOf<std::string>({"0,0,0,0", "-0.2,0.6,0.2,0.2"});
      return;
    }
    recipe["map"] = "rational";
    recipe["texture"] = "random";
    recipe["texture-powers"] = "1:3";
    maybe(recipe, 0.7, "texture-placement", {"inside", "surface"});
  }

  std::mt19937 mRandom;
  std::vector<Recipe> mTargets;
};

// Promise of design.md: "What was made before changes nothing: a frame of a sequence, a cell of a sheet, a scene of
//   `explore` and a task of a plan have the bytes that their recipe has alone, in any order and in any company"
TEST_F(SceneHistory, RandomRecipesAreWhatTheyAreAlone) {
  const std::string mesh = write("snowman.obj", snowman());
  const std::string open = write("open.obj", withoutTriangles(snowman(), [](const Vec3d& at) { return at[1] > 0.8; }));
  const std::string band =
      write("band.vdb", encodeVdb({test_fields::bandGrid(test_fields::lumpy, 0.05, 0.15, 0.15)}, {}));
  const CoordBBox nodes(openvdb::Coord(-12), openvdb::Coord(12));
  const std::string dense =
      write("dense.vdb", encodeVdb({test_fields::denseGrid(test_fields::lumpy, 0.06, nodes)}, {}));
  constexpr unsigned kSeed = 7;
  RandomRecipes random(kSeed, {{{"input", mesh}},
                               {{"input", mesh}},
                               {{"input", mesh}, {"thicken", "0.3"}},
                               {{"input", open}, {"repair", "true"}},
                               {{"input", band}},
                               {{"input", dense}}});
  constexpr int kCount = 48;
  std::vector<Recipe> recipes;
  for (int i = 0; i < kCount; ++i) recipes.push_back(random.next());
  // Most have the target of the one before, so that there is something to share.
  const auto target = [](const Recipe& recipe) {
    const auto mended = [&](const char* name) { return recipe.contains(name) ? recipe.at(name) : std::string(); };
    return std::tuple(recipe.at("input"), recipe.at("sdf-resolution"), mended("thicken"), mended("repair"));
  };
  std::stable_sort(recipes.begin(), recipes.end(),
                   [&](const Recipe& a, const Recipe& b) { return target(a) < target(b); });
  EXPECT_GT(expectNoHistory(recipes), kCount / 2);
}

// Promise: "What was made before changes ..."
TEST_F(SceneHistory, NeitherTheOrderNorTheCompanyOfDepthsMatters) {
  const std::string mesh = write("snowman.obj", snowman());
  std::vector<std::string> depths{"0.1", "0.3", "0.5"};
  do {
    std::vector<Recipe> recipes;
    for (const std::string& depth : depths)
      recipes.push_back({{"input", mesh}, {"detail", depth}, {"sdf-resolution", "48"}, {"resolution", "20"}});
    EXPECT_EQ(expectNoHistory(recipes), 3);
  } while (std::next_permutation(depths.begin(), depths.end()));
}

// The thickness of a target is remembered for a few depths of detail, and an expression asks for another one.
// Promise: "What was made before changes ..."
TEST_F(SceneHistory, ManyDepthsAndAnExpressionOfTheThickness) {
  const std::string mesh = write("snowman.obj", snowman());
  std::vector<Recipe> recipes;
  for (int i = 0; i < 12; ++i)
    recipes.push_back({{"input", mesh},
                       {"detail", std::to_string(0.2 + 0.06 * i)},
                       {"outward", "expr:min(0.3, 0.1+tau)"},
                       {"sdf-resolution", "20"},
                       {"resolution", "12"}});
  EXPECT_EQ(expectNoHistory(recipes), 12);
}

// Promise of explore.md: A target or a control "whose file changes" is read again within a running program
TEST_F(SceneHistory, AFileThatHasChangedIsReadAgain) {
  const std::string mesh = write("target.obj", snowman()), painter = write("near.obj", makeSphere(0.3, 2));
  const Recipe recipe{
      {"input", mesh}, {"detail", "near:" + painter + ":0.5:0.6:0.2"}, {"sdf-resolution", "20"}, {"resolution", "14"}};
  SceneMaker maker;
  const std::string first = madeOf(maker, recipe);
  EXPECT_TRUE(first == alone(recipe));
  write("near.obj", makeSphere(0.3, 2, Vec3d(1, 0, 0)));
  const std::string second = madeOf(maker, recipe);
  EXPECT_FALSE(second == first);
  EXPECT_TRUE(second == alone(recipe));
  write("target.obj", makeSphere(1, 3));
  const std::string third = madeOf(maker, recipe);
  EXPECT_FALSE(third == second);
  EXPECT_TRUE(third == alone(recipe));
}

// Promise: "What was made before changes ..."
TEST_F(SceneHistory, ASceneThatWasInterruptedLeavesNothingBehind) {
  /// Cancels the work in one of its phases.
  struct Stops final : Monitor {
    explicit Stops(int at) : left(at) {}
    void begin(const Phase&, std::uint64_t) override { --left; }
    bool cancelled() const override { return left <= 0; }
    std::atomic<int> left;
  };
  const std::string mesh = write("snowman.obj", snowman());
  Recipe recipe{{"input", mesh}, {"sdf-resolution", "20"}, {"resolution", "12"}};
  SceneMaker maker;
  int interrupted = 0;
  for (const char* detail : {"0.1", "0.5", "0.2"}) {
    recipe["detail"] = detail;
    for (int phase = 1; phase < 6; ++phase) {
      Stops stops(phase);
      try {
        maker.make(parseFractalOptions(completeRecipe(recipe, fractalOptionTable())), stops);
      } catch (const Interrupted&) {
        ++interrupted;
      }
    }
    EXPECT_TRUE(madeOf(maker, recipe) == alone(recipe)) << detail;
  }
  EXPECT_GT(interrupted, 5);
}

}  // namespace
