// SPDX-License-Identifier: Apache-2.0
// The shelf of textures: what each promises of its roots, and how recipes choose among textures, random roots and
// files.
#include "support/mesh_laws.h"
#include "support/temporary_folder.h"
#include "support/test_meshes.h"

#include "vdbtools/job/fractal_job.h"
#include "vdbtools/maps/texture_shelf.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/scene/fractal_options.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

namespace {

using namespace vdbtools;
using julia::Point;
using julia::Root;

bool isConstant(const Root& root) {
  const auto& t = root.position;
  return std::hypot(std::hypot(t.a, t.b), std::hypot(t.c, t.d)) > 1e5;
}

TEST(TextureShelf, saysWhatItHolds) {
  std::set<std::string> names;
  for (const Texture& texture : textureShelf()) {
    SCOPED_TRACE(texture.name);
    EXPECT_TRUE(names.insert(texture.name).second);
    EXPECT_TRUE(std::all_of(texture.name.begin(), texture.name.end(), [](char c) { return c >= 'a' && c <= 'z'; }));
    EXPECT_NE(texture.name, "random");
    EXPECT_GT(texture.description.size(), 10U);
    EXPECT_EQ(texture.description.back(), '.');
    EXPECT_EQ(findTexture(texture.name), &texture);
  }
  EXPECT_GE(names.size(), 10U);
  EXPECT_TRUE(names.contains(defaultTexture().name));
  EXPECT_EQ(findTexture("no-such-texture"), nullptr);
}

TEST(TextureShelf, isOfRootsOrOfWaves) {
  for (const Texture& texture : textureShelf()) {
    SCOPED_TRACE(texture.name);
    EXPECT_NE(texture.strands.empty(), texture.waves.empty());
    EXPECT_EQ(texture.followsThickness(), texture.strands.empty());
    if (texture.followsThickness()) {
      EXPECT_NO_THROW(julia::requireValid(placedWaves(wavesOf(texture, 1), 1, {})));
    }
  }
  EXPECT_TRUE(defaultTexture().followsThickness());
}

// Promise of textures.md: "All powers are whole", and "the size and the place of a mesh do not matter"
TEST(TextureShelf, hasWholePowersThatFloatsServe) {
  for (const Texture& texture : textureShelf()) {
    if (texture.followsThickness()) continue;
    SCOPED_TRACE(texture.name);
    const julia::Rational rational = placeTexture(texture, 1, {});
    EXPECT_TRUE(rational.bottom.roots.empty());
    EXPECT_LE(rational.top.roots.size(), 60U);
    double powers = 0;
    for (const Root& root : rational.top.roots) {
      EXPECT_EQ(root.power, std::floor(root.power));
      powers += std::abs(root.power);
    }
    EXPECT_LE(powers, 250);  // docs/precision.md
  }
}

// Promise: "All powers are whole", and "the size ..."
TEST(TextureShelf, growsWithItsTarget) {
  for (const Texture& texture : textureShelf()) {
    SCOPED_TRACE(texture.name);
    const std::vector<Root> one = placeTexture(texture, 1, {}).top.roots;
    const std::vector<Root> two = placeTexture(texture, 4, {}).top.roots;
    ASSERT_EQ(one.size(), two.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
      EXPECT_EQ(two[i].power, one[i].power);
      EXPECT_EQ(two[i].position, isConstant(one[i]) ? one[i].position : one[i].position * 4.0);
    }
  }
}

TEST(TextureShelf, wavesGrowWithTheirScale) {
  for (const Texture& texture : textureShelf()) {
    SCOPED_TRACE(texture.name);
    const julia::WaveTexture one = placedWaves(wavesOf(texture, 3), 1, {}),
                             two = placedWaves(wavesOf(texture, 3), 4, {});
    ASSERT_EQ(one.factors.size(), two.factors.size());
    for (std::size_t f = 0; f < one.factors.size(); ++f)
      for (std::size_t i = 0; i < one.factors[f].waves.size(); ++i)
        EXPECT_EQ(two.factors[f].waves[i].frequency * 4.0, one.factors[f].waves[i].frequency);
  }
}

// Promise: Textures: the table, the default, and those ...
TEST(TextureShelf, seedsVaryWhatSaysSo) {
  bool someVary = false;
  for (const Texture& texture : textureShelf()) {
    SCOPED_TRACE(texture.name);
    const julia::WaveTexture one = placedWaves(wavesOf(texture, 1), 1, {});
    EXPECT_EQ(one, placedWaves(wavesOf(texture, 1), 1, {}));
    EXPECT_EQ(one != placedWaves(wavesOf(texture, 2), 1, {}), texture.varies());
    someVary |= texture.varies();
  }
  EXPECT_TRUE(someVary);
}

/// Waves of many directions have amplitudes c and s of length 1 at right angles, so that none has a zero by itself.
TEST(TextureShelf, wavesHaveUnitAmplitudes) {
  for (const Texture& texture : textureShelf())
    for (std::uint64_t seed = 0; seed < 20; ++seed)
      for (const julia::WaveFactor& factor : placedWaves(wavesOf(texture, seed), 1, {}).factors)
        for (const auto& [frequency, c, s] : factor.waves) {
          EXPECT_NEAR(julia::normSquared(c), 1, 1e-12) << texture.name;
          EXPECT_NEAR(julia::normSquared(s), 1, 1e-12) << texture.name;
          EXPECT_NEAR(c.a * s.a + c.b * s.b + c.c * s.c + c.d * s.d, 0, 1e-12) << texture.name;
          EXPECT_LT(julia::normSquared(frequency), 100) << texture.name;
        }
}

TEST(TextureShelf, liesInTheSlice) {
  for (const Texture& texture : textureShelf())
    for (const julia::DropAxis dropped : {julia::DropAxis::I, julia::DropAxis::K}) {
      const julia::Embedding embedding{0.125, dropped};
      for (const Root& root : placeTexture(texture, 1, embedding).top.roots) {
        if (isConstant(root)) continue;
        EXPECT_EQ(embedding.slicePart(root.position), 0.125) << texture.name;
      }
    }
}

class TextureJob : public testing::Test {
 protected:
  TextureJob() { openvdb::initialize(); }

  std::string write(const std::string& name, const Mesh& mesh) const {
    std::ostringstream obj;
    writeMesh(obj, mesh, {.format = &meshFormat(".obj")});
    return mFolder.write(name, obj.str());
  }
  Scene scene(const Recipe& recipe) {
    return makeScene(parseFractalOptions(completeRecipe(recipe, fractalOptionTable())), mMonitor);
  }

  TemporaryFolder mFolder;
  Monitor mMonitor;
};

// Promise: "All powers are whole", and "the size ..."
TEST_F(TextureJob, EachMakesAClosedMeshOfABall) {
  const std::string input = write("ball.obj", test_meshes::makeSphere(2, 4, {1, 2, 3}));
  for (const Texture& texture : textureShelf()) {
    SCOPED_TRACE(texture.name);
    const Recipe recipe{{"input", input},     {"texture", texture.name}, {"alpha", "20"},
                        {"resolution", "24"}, {"sdf-resolution", "24"},  {"origin", "0.05,0.02,0"}};
    const Mesh mesh = fractalMesh(scene(recipe), mMonitor);
    EXPECT_GT(mesh.triangles.size(), 500U);
    EXPECT_EQ(mesh_laws::notClosedManifold(mesh), "");
  }
}

// Promise: "All powers are whole", and "the size ..."
TEST_F(TextureJob, TheTargetsPlaceDoesNotMatter) {
  const std::string here = write("a.obj", test_meshes::makeSphere(2, 4));
  const std::string there = write("b.obj", test_meshes::makeSphere(2, 4, {64, -32, 8}));
  for (const Texture& texture : textureShelf()) {
    SCOPED_TRACE(texture.name);
    Recipe recipe{{"input", here}, {"texture", texture.name}, {"sdf-resolution", "24"}};
    const Scene one = scene(recipe);
    recipe["input"] = there;
    const Scene two = scene(recipe);
    std::vector<julia::Point> points;
    for (int i = 0; i < 60; ++i)
      points.push_back({0.4 * std::sin(2.7 * i), 0.4 * std::sin(1.9 * i + 1), 0.4 * std::sin(3.1 * i + 2)});
    std::vector<julia::Quaternion<double>> atHome(points.size()), tatHome(points.size());
    one.field.evaluator->versors(points, atHome);
    two.field.evaluator->versors(points, tatHome);
    for (std::size_t i = 0; i < points.size(); ++i)
      EXPECT_LT(std::sqrt(normSquared(atHome[i] - tatHome[i])), 0.01) << i;
  }
}

std::string versorOf(const Recipe& recipe) { return completeRecipe(recipe, fractalOptionTable()).at("texture"); }

// Promise of textures.md: "Without `--texture`, a seed means random roots, as does every other option of random roots"
TEST(TextureOptions, whoSpeaksOfRandomRootsGetsThem) {
  EXPECT_EQ(versorOf({{"input", "a.obj"}}), defaultTexture().name);
  EXPECT_EQ(versorOf({{"input", "a.obj"}, {"texture", "coral"}, {"texture-seed", "4"}}), "coral");
  EXPECT_EQ(versorOf({{"input", "a.obj"}, {"texture-scale", "2"}}), defaultTexture().name);
  for (const char* option : {"texture-seed", "texture-roots", "texture-powers", "texture-integer", "texture-placement",
                             "texture-distance", "texture-centre", "texture-radius"})
    EXPECT_EQ(versorOf({{"input", "a.obj"}, {option, "3"}}), "random") << option;
  EXPECT_EQ(versorOf({{"map", "rational"}, {"input", "a.obj"}}), "random");
}

// Promise: "Without `--texture`, a seed ..."
TEST(TextureOptions, recordedRecipesOfTexturesHaveNoRandomRoots) {
  const Recipe texture = completeRecipe({{"input", "a.obj"}}, fractalOptionTable());
  EXPECT_FALSE(texture.contains("texture-roots"));
  EXPECT_TRUE(texture.contains("texture-seed"));
  EXPECT_NO_THROW(parseFractalOptions(texture));
  const Recipe random = completeRecipe({{"input", "a.obj"}, {"texture", "random"}}, fractalOptionTable());
  EXPECT_EQ(random.at("texture-roots"), "10");
  EXPECT_EQ(random.at("texture-powers"), "2:11");

  // One displaces the other where a recorded recipe is taken up again.
  const OptionTable table = fractalOptionTable();
  EXPECT_EQ(versorOf(overridden(texture, {{"texture-roots", "5"}}, table)), "random");
  const Recipe back = completeRecipe(overridden(random, {{"texture", "scales"}}, table), table);
  EXPECT_FALSE(back.contains("texture-roots"));
  EXPECT_NO_THROW(parseFractalOptions(back));
}

std::string refusal(const Recipe& recipe) {
  try {
    parseFractalOptions(completeRecipe(recipe, fractalOptionTable()));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

// Promise: `--frequency`: words, numbers, controls; "A frequency ..."
TEST(TextureOptions, badOnesAreRefused) {
  const std::string unknown = refusal({{"input", "a.obj"}, {"texture", "feather"}});
  EXPECT_NE(unknown.find("feather"), std::string::npos) << unknown;
  for (const Texture& texture : textureShelf()) EXPECT_NE(unknown.find(texture.name), std::string::npos) << unknown;
  const std::string both = refusal({{"input", "a.obj"}, {"texture", "scales"}, {"texture-powers", "2:3"}});
  EXPECT_NE(both.find("--texture-powers"), std::string::npos) << both;
  EXPECT_NE(both.find("scales"), std::string::npos) << both;
  EXPECT_EQ(refusal({{"input", "a.obj"}, {"texture", "scales"}, {"texture-seed", "2"}}), "");
  EXPECT_EQ(refusal({{"input", "a.obj"}, {"texture", "scales.json"}}), "");
  EXPECT_NE(refusal({{"input", "a.obj"}, {"map", "rational"}, {"texture", "scales"}}).find("thickness"),
            std::string::npos);
  // A recorded recipe has a frequency that means nothing to the roots that displace its texture.
  EXPECT_EQ(refusal({{"input", "a.obj"}, {"texture", "rings"}, {"frequency", "2"}}), "");
  const OptionTable table = fractalOptionTable();
  EXPECT_NE(table.idle("frequency", {.recipe = completeRecipe({{"input", "a.obj"}, {"texture", "rings"}}, table)}), "");
  EXPECT_EQ(table.idle("frequency", {.recipe = completeRecipe({{"input", "a.obj"}}, table)}), "");
  for (const char* frequency : {"0", "-1", "inf", "nan", "middling"})
    EXPECT_NE(refusal({{"input", "a.obj"}, {"frequency", frequency}}).find(frequency), std::string::npos);
  for (const char* frequency : {"coarse", "medium", "fine", "0.7", "x:1:3", "expr:1 + hy"})
    EXPECT_EQ(refusal({{"input", "a.obj"}, {"frequency", frequency}}), "");
}

}  // namespace
