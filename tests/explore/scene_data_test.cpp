// SPDX-License-Identifier: Apache-2.0
// What the page is told of a scene is what the scene evaluates.
#include "explore/scene_data.h"

#include "base/base64.h"
#include "base/srgb.h"
#include "explore/export_page.h"
#include "support/temporary_folder.h"
#include "support/test_fields.h"
#include "support/test_meshes.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/explore/embedded_page.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/picture/gradient.h"

#include "julia/brick_field.h"
#include "julia/grain_versor.h"
#include "julia/shape_modulus.h"

#include <gtest/gtest.h>

#include <openvdb/math/Half.h>

#include <algorithm>
#include <any>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string_view>
#include <vector>

namespace {

using namespace vdbtools;
using namespace vdbtools::explore;
using nlohmann::json;

class SceneDataTest : public testing::Test {
 protected:
  SceneDataTest() { openvdb::initialize(); }

  Scene scene(Recipe recipe) {
    recipe.emplace("resolution", "40");
    return makeScene(parseFractalOptions(recipe), mMonitor);
  }
  /// A ball as a narrow band.
  Recipe target() {
    const auto distance = [](const openvdb::Vec3d& x) { return x.length() - 0.45; };
    const std::string path = mFolder.path() / "ball.vdb";
    std::ofstream(path, std::ios::binary)
        << encodeVdb({test_fields::bandGrid(distance, 0.025, 0.1)}, {.half = false, .metadata = {}});
    return {{"input", path}};
  }

  Monitor mMonitor;
  TemporaryFolder mFolder;
};

/// A field as the page's shader reads it: trilinearly between the nodes of a volume.
class PageVolume {
 public:
  explicit PageVolume(const SceneData& data) : PageVolume(data.description.at("exponent"), data.volume) {}
  /// @param bytes  from the field's first value on
  /// @param stride  from one of its values to the next
  PageVolume(const json& entry, std::string_view bytes, std::size_t stride = 1)
      : mEntry(entry), mBytes(bytes), mStride(stride), mDims(entry.at("dims").get<std::array<int, 3>>()) {}

  double at(const julia::Point& x) const {
    std::array<double, 3> part{};
    std::array<int, 3> cell{};
    for (std::size_t row = 0; row < 3; ++row) {
      double node = mEntry.at("offset").at(row).get<double>();
      for (std::size_t column = 0; column < 3; ++column)
        node += mEntry.at("matrix").at(row).at(column).get<double>() * x[column];
      node = std::clamp(node, 0.0, mDims[row] - 1.0);
      cell[row] = std::min(static_cast<int>(node), mDims[row] - 2);
      part[row] = node - cell[row];
    }
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1;
      std::array<int, 3> node{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const int up = corner >> axis & 1;
        weight *= up ? part[axis] : 1 - part[axis];
        node[axis] = cell[axis] + up;
      }
      sum += weight * nodeAt(node);
    }
    return sum;
  }

 private:
  double nodeAt(const std::array<int, 3>& node) const {
    const auto index = static_cast<std::size_t>((node[2] * mDims[1] + node[1]) * mDims[0] + node[0]);
    openvdb::math::half value;
    std::uint16_t bits = 0;
    std::memcpy(&bits, mBytes.data() + 2 * mStride * index, sizeof bits);
    value.setBits(bits);
    return static_cast<double>(static_cast<float>(value));
  }

  const json& mEntry;
  std::string_view mBytes;
  std::size_t mStride;
  std::array<int, 3> mDims;
};

// Promise: An exported page is one file ...
TEST_F(SceneDataTest, theVolumeIsTheExponentWithinItsError) {
  Recipe recipe = target();
  recipe["alpha"] = "12";
  const Scene made = scene(recipe);
  const SceneData data = sceneData(made, {}, mMonitor);
  const auto shape = std::any_cast<julia::ShapeModulusDescription>(made.field.evaluator->describe().map);
  const julia::BrickField<double> exponent(shape.exponent->bricks, shape.exponent->placement);
  const PageVolume volume(data);
  const double error = data.description.at("exponent").at("error").get<double>();
  ASSERT_LT(error, 0.01);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(-0.8, 0.8);
  int undecided = 0;
  for (int i = 0; i < 3000; ++i) {
    const julia::Point x{coordinate(random), coordinate(random), coordinate(random)};
    double expected = 0;
    exponent.sample({&x[0], 1}, {&x[1], 1}, {&x[2], 1}, {&expected, 1});
    EXPECT_NEAR(volume.at(x), expected, error + 1e-5) << x[0] << ' ' << x[1] << ' ' << x[2];
    undecided += std::abs(expected) < 1 ? 1 : 0;
  }
  EXPECT_GT(undecided, 100) << "the points say nothing of the shell";
}

// Promise: The page shows a texture ...
TEST_F(SceneDataTest, theVolumesOfAGrainAreTheFieldsThatItsVersorReads) {
  Recipe recipe = target();
  recipe.merge(Recipe{{"texture", "fur"}, {"grain", "0,1,0"}, {"drop-axis", "j"}});
  const Scene made = scene(recipe);
  // A small picture needs the whole of it, too: phases cannot be read between nodes that are far apart.
  const SceneData data = sceneData(made, {.side = 16}, mMonitor);
  const json& entry = data.description.at("grain");
  EXPECT_EQ(entry.at("coarser"), 1);
  EXPECT_FALSE(data.description.contains("waves"));
  EXPECT_FALSE(data.description.contains("factors"));
  const auto dims = entry.at("dims").get<std::array<std::size_t, 3>>();
  const std::size_t nodes = dims[0] * dims[1] * dims[2];
  ASSERT_EQ(data.grain.size(), 10 * nodes);
  const auto shape = std::any_cast<julia::ShapeModulusDescription>(made.field.evaluator->describe().map);
  const auto versor = std::any_cast<julia::GrainVersorDescription>(shape.versor);
  ASSERT_EQ(entry.at("factors").size(), versor.texture.factors.size());
  for (std::size_t i = 0; i < versor.texture.factors.size(); ++i) {
    const julia::WaveFactor& factor = versor.texture.factors[i];
    EXPECT_EQ(entry.at("factors").at(i).at("power"), factor.power);
    for (std::size_t k = 0; k < factor.waves.size(); ++k) {
      const auto wave = entry.at("factors").at(i).at("waves").at(k).get<std::array<std::array<double, 4>, 3>>();
      const julia::Quaternion<double>& frequency = factor.waves[k].frequency;
      EXPECT_EQ(wave[0], (std::array{frequency.a, frequency.b, frequency.c, frequency.d}));
    }
  }
  const double error = entry.at("error").get<double>();
  ASSERT_LT(error, 0.002);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> coordinate(-0.7, 0.7);
  std::vector<julia::Point> points(3000);
  for (julia::Point& x : points) x = {coordinate(random), coordinate(random), coordinate(random)};
  for (std::size_t k = 0; k < julia::kGrainFields; ++k) {
    const bool isDepth = k == julia::kGrainDepth;
    const PageVolume volume(entry, std::string_view(data.grain).substr(isDepth ? 8 * nodes : 2 * k), isDepth ? 1 : 4);
    const julia::BrickField<double> field(versor.fields[k]->bricks, versor.fields[k]->placement);
    int changing = 0;
    for (const julia::Point& x : points) {
      double expected = 0;
      field.sample({&x[0], 1}, {&x[1], 1}, {&x[2], 1}, {&expected, 1});
      EXPECT_NEAR(volume.at(x), expected, error + 1e-5) << k << ": " << x[0] << ' ' << x[1] << ' ' << x[2];
      changing += expected != 0 ? 1 : 0;
    }
    EXPECT_GT(changing, 100) << k;
  }
}

TEST_F(SceneDataTest, whatThePageCannotShowIsRefusedAtOnce) {
  const auto with = [&](const Recipe& options) {
    Recipe recipe = target();
    recipe.insert(options.begin(), options.end());
    return scene(recipe);
  };
  for (const Recipe& shown : std::vector<Recipe>{{}, {{"texture", "random"}}, {{"grain", "along"}}})
    EXPECT_NO_THROW(requireShown(with(shown)));
  for (const Recipe& other : std::vector<Recipe>{{{"texture-symmetry", "3:y"}},
                                                 {{"grain", "along"}, {"texture-symmetry", "3:y"}},
                                                 {{"texture-over", "thorns"}, {"texture-mix", "expr:0.2+0.5*hx"}},
                                                 {{"texture", "expr:y,-x,z+2"}}}) {
    const Scene made = with(other);
    EXPECT_THROW(requireShown(made), std::invalid_argument) << other.begin()->first;
  }
}

TEST_F(SceneDataTest, aCoarserVolumeReadsTheSameExponent) {
  const Scene made = scene(target());
  const SceneData data = sceneData(made, {.side = 24}, mMonitor);
  EXPECT_LE(data.description.at("exponent").at("dims").at(0).get<int>(), 24);
  EXPECT_GT(data.description.at("exponent").at("coarser").get<double>(), 1.5);
  // Of the ball, E is a function of the distance from its middle.
  const PageVolume volume(data);
  for (const double r : {0.42, 0.46, 0.5, 0.54})
    EXPECT_NEAR(volume.at({r, 0, 0}), volume.at({0, 0, -r}), 0.1 * (1 + std::abs(volume.at({r, 0, 0})))) << r;
  EXPECT_LT(volume.at({0.4, 0, 0}), volume.at({0.6, 0, 0}));
  EXPECT_THROW(sceneData(made, {.side = 300}, mMonitor), std::invalid_argument);
}

TEST_F(SceneDataTest, theSetIsWithinTheOccupiedCubes) {
  const Scene made = scene({{"map", "quadratic"}, {"c", "-0.2,0.6,0.2,0.2"}});
  const SceneData data = sceneData(made, {}, mMonitor);
  EXPECT_TRUE(data.volume.empty());
  const json& cubes = data.description.at("occupancy");
  const auto dims = cubes.at("dims").get<std::array<int, 3>>();
  const auto origin = cubes.at("origin").get<julia::Point>();
  const double cell = cubes.at("cell").get<double>();
  constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const std::string bits = cubes.at("bits").get<std::string>();
  const auto isOccupied = [&](std::size_t index) {
    const std::size_t byte = index / 8, digit = byte * 8 / 6;
    // The byte stands in two digits of base 64.
    const auto value = kAlphabet.find(bits.at(digit)) << 6 | kAlphabet.find(bits.at(digit + 1));
    return (value >> (12 - 8 - byte * 8 % 6) >> index % 8 & 1) != 0;
  };
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share(0, 1);
  int inside = 0, skipped = 0;
  for (int i = 0; i < 20000; ++i) {
    julia::Point x{};
    std::size_t index = 0;
    for (std::size_t axis = 3; axis-- > 0;) {
      x[axis] = origin[axis] + share(random) * cell * dims[axis];
      index = index * static_cast<std::size_t>(dims[axis]) + static_cast<std::size_t>((x[axis] - origin[axis]) / cell);
    }
    double field = 0;
    made.field.evaluator->evaluate({&x, 1}, {&field, 1}, {});
    EXPECT_TRUE(field >= 0 || isOccupied(index)) << x[0] << ' ' << x[1] << ' ' << x[2];
    inside += field < 0 ? 1 : 0;
    skipped += isOccupied(index) ? 0 : 1;
  }
  EXPECT_GT(inside, 200);
  EXPECT_GT(skipped, 5000) << "nothing is skipped";
}

TEST(Base64, isThatOfTheStandard) {
  // RFC 4648, section 10.
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64(std::string_view("\xff\x00\xfe", 3)), "/wD+");
}

TEST(BundledScript, holdsEveryModuleOnceAndImportsNothing) {
  const std::string script = bundledScript();
  EXPECT_EQ(script.find("\nimport "), std::string::npos);
  EXPECT_EQ(script.find("\nexport "), std::string::npos);
  for (const PageFile& file : embeddedPage()) {
    if (!file.name.ends_with(".js")) continue;
    // What each module says first.
    const std::string_view text = file.bytes;
    const std::size_t from = text.find("\n// ") + 1;
    const std::string line(text.substr(from, text.find('\n', from) - from));
    const std::size_t at = script.find(line);
    // An exported page has no program in a worker, and main.js loads this module only where there is one.
    const bool isLeftOut = file.name == "program.js";
    EXPECT_EQ(at == std::string::npos, isLeftOut) << file.name;
    if (isLeftOut) continue;
    EXPECT_EQ(script.find(line, at + 1), std::string::npos) << file.name;
  }
}

TEST(PageGradients, areThoseOfTheProgram) {
  const std::string script(findPageFile("renderer.js")->bytes);
  int count = 0;
  for (const std::string& name : gradientNames()) {
    ++count;
    const std::string before = "  " + name + ": codes(\"";
    const std::size_t at = script.find(before), from = at + before.size();
    ASSERT_NE(at, std::string::npos) << name;
    std::stringstream text(script.substr(from, script.find('"', from) - from));
    std::vector<unsigned> codes;
    for (unsigned code = 0; text >> std::hex >> code;) codes.push_back(code);
    const Gradient gradient = Gradient::named(name).value();
    for (std::size_t i = 0; i < codes.size(); ++i) {
      const openvdb::Vec3d colour = gradient.at(static_cast<double>(i) / static_cast<double>(codes.size() - 1));
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(255 * srgbFromLinear(colour[c]), codes[i] >> (16 - 8 * c) & 0xff, 1e-6) << name << ' ' << i;
    }
    // Between stops, too: there are no others.
    EXPECT_NEAR(srgbFromLinear(gradient.at(0.5 / static_cast<double>(codes.size() - 1))[0]),
                ((codes[0] >> 16) + (codes[1] >> 16)) / 510.0, 1e-6)
        << name;
  }
  EXPECT_EQ(count, 6);
}

// Promise: An exported page is one file ...
TEST_F(SceneDataTest, anExportedPageAsksForNothing) {
  const Scene made = scene({{"map", "cross"}, {"f", "x<1 ? x : y,y*y,z*z"}, {"g", "cos(x),cos(y),cos(z)"}});
  const std::string page = exportPage(made, {{"map", "cross"}}, {}, mMonitor);
  EXPECT_EQ(page.find("src="), std::string::npos);
  EXPECT_EQ(page.find("href=\"page"), std::string::npos);
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
  // No text of the user's can end the script that it stands in.
  const std::size_t data = page.find("id=\"exported\">");
  ASSERT_NE(data, std::string::npos);
  const std::size_t begin = data + std::strlen("id=\"exported\">"), end = page.find("</script>", begin);
  const json start = json::parse(page.substr(begin, end - begin));
  EXPECT_EQ(start.at("scene").at("f"), "x<1 ? x : y,y*y,z*z");
}

}  // namespace
