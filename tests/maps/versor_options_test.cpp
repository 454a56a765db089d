// SPDX-License-Identifier: Apache-2.0
// Versors as recipes describe them, and fields of directions that are sparse.
#include "vdbtools/maps/versor_options.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/scene/fractal_options.h"

#include "support/temporary_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace vdbtools;
using openvdb::Coord;
using openvdb::Vec3d;
using openvdb::Vec3s;

Recipe recipeOf(Recipe options) {
  options.emplace("input", "a.obj");
  return completeRecipe(options, fractalOptionTable());
}

std::vector<std::string> controlNames(const Recipe& options) {
  std::vector<std::string> names;
  for (const MapControl& control : parseFractalOptions(recipeOf(options)).map->controls())
    names.push_back(control.name);
  return names;
}

using Names = std::vector<std::string>;

TEST(VersorOptions, readTheControlsThatTheyNeed) {
  EXPECT_EQ(controlNames({}), Names());
  EXPECT_EQ(controlNames({{"texture", "expr:x,y,z*w+hx"}}), Names());
  EXPECT_EQ(
      controlNames({{"texture", "expr:phi,nx,x"}, {"texture-over", "expr:red,phi,0"}, {"texture-mix", "paint:red"}}),
      (Names{"at-nx", "at-phi", "at-red", "mix"}));
  EXPECT_EQ(controlNames({{"texture-over", "rings"}}), Names{"mix"});
  EXPECT_EQ(controlNames({{"texture", "rings"}, {"texture-over", "scales"}}), (Names{"mix", "over-octave"}));
  EXPECT_EQ(controlNames({{"texture", "fur"}, {"grain", "along"}}), Names{"grain"});
  EXPECT_EQ(controlNames({{"texture", "expr:x,y,z"}, {"texture-over", "scales"}, {"grain", "along"}}),
            (Names{"over-grain", "mix"}));
}

TEST(VersorOptions, recordWhatMeansSomethingAlone) {
  const Recipe plain = recipeOf({});
  EXPECT_EQ(plain.at("texture-over"), "none");
  EXPECT_EQ(plain.at("texture-symmetry"), "none");
  for (const char* name : {"texture-mix", "texture-over-seed", "texture-over-frequency"})
    EXPECT_FALSE(plain.contains(name));
  const Recipe layers = recipeOf({{"texture-over", "thorns"}});
  EXPECT_EQ(layers.at("texture-mix"), "0.5");
  EXPECT_EQ(layers.at("texture-over-frequency"), "medium");
  const Recipe formula = recipeOf({{"texture", "expr:x,y,z"}});
  for (const char* name : {"frequency", "texture-roots", "texture-powers"})
    EXPECT_FALSE(formula.contains(name)) << name;
}

TEST(VersorOptions, nameTheirFiles) {
  Recipe options =
      recipeOf({{"texture", "field:v.vdb:v"}, {"texture-over", "over.json"}, {"texture-mix", "m.vdb:mix"}});
  std::vector<std::string> files;
  for (const NamedFile& file : parseFractalOptions(options).map->files())
    files.push_back(file.path.string() + " " + file.recordedAs);
  EXPECT_EQ(files, (Names{"v.vdb texture-sha256", "over.json texture-over-sha256", "m.vdb texture-mix-sha256"}));
}

TEST(VersorOptions, knowAProgramsFunctionOnlyWhereThereIsOne) {
  const Recipe options = recipeOf({{"texture", "function"}});
  EXPECT_THROW(parseFractalOptions(options), std::invalid_argument);
  const MapRegistry maps =
      builtInMaps([](std::span<const Vec3d> points) { return std::vector<double>(3 * points.size(), 1); });
  EXPECT_NO_THROW(parseFractalOptions(options, maps));
}

/// A grid of vectors where keep() says so.
template <class Value, class Keep>
std::filesystem::path writtenField(const TemporaryFolder& folder, const Value& value, const Keep& keep) {
  auto grid = openvdb::Vec3SGrid::create(Vec3s(0));
  grid->setName("v");
  grid->setTransform(openvdb::math::Transform::createLinearTransform(0.1));
  auto accessor = grid->getAccessor();
  for (auto node = openvdb::CoordBBox(Coord(-12), Coord(12)).begin(); node; ++node) {
    const Vec3d at = grid->indexToWorld(*node);
    if (keep(at)) accessor.setValueOn(*node, Vec3s(value(at)));
  }
  return folder.write("v.vdb", encodeVdb({grid}, {}));
}

const openvdb::BBoxd kBox(Vec3d(-1), Vec3d(1));

TEST(DirectionGrids, keepWhatIsGivenAndFillTheRestWithItsMeans) {
  const TemporaryFolder folder;
  const auto value = [](const Vec3d& x) { return Vec3d(1 + 0.1 * x[0], 2, -0.5 * x[2]); };
  const auto keep = [](const Vec3d& x) { return x.length() > 0.6 && x.length() < 1; };
  const DirectionGrids given = readDirectionGrids(writtenField(folder, value, keep), {"v"}, "--texture");
  const DirectionGrids filled = filledAbout(given, kBox, "--texture");
  ASSERT_EQ(filled.components.size(), 3u);
  const openvdb::FloatGrid& first = *filled.components[0];
  for (auto node = filled.nodes.begin(); node; ++node) {
    const Vec3d at = first.indexToWorld(*node);
    for (int axis = 0; axis < 3; ++axis) {
      const float there = filled.components[static_cast<std::size_t>(axis)]->tree().getValue(*node);
      if (keep(at)) {
        EXPECT_EQ(there, Vec3s(value(at))[axis]);
      } else {
        EXPECT_NEAR(there, axis == 1 ? 2 : axis == 0 ? 1 : 0, axis == 1 ? 1e-6 : 0.51) << *node;
      }
    }
  }
  // What is filled goes on without a step: neighbours differ by no more than what is given over two voxels.
  auto accessor = filled.components[2]->getConstAccessor();
  for (auto node = filled.nodes.begin(); node; ++node)
    if (const Coord next = (*node).offsetBy(0, 0, 1); filled.nodes.isInside(next)) {
      EXPECT_LT(std::abs(accessor.getValue(*node) - accessor.getValue(next)), 0.3) << *node;
    }
}

TEST(DirectionGrids, refuseWhatIsNoDirectionWithItsPlace) {
  const TemporaryFolder folder;
  const auto everywhere = [](const Vec3d&) { return true; };
  const auto refusal = [&](const auto& value, const auto& keep) -> std::string {
    try {
      filledAbout(readDirectionGrids(writtenField(folder, value, keep), {}, "--texture"), kBox, "--texture");
    } catch (const DataError& error) {
      return error.what();
    }
    return "";
  };
  const auto one = [](const Vec3d&) { return Vec3d(0, 1, 0); };
  EXPECT_EQ(refusal(one, everywhere), "");
  EXPECT_EQ(refusal([](const Vec3d& x) { return x; }, everywhere), "");
  const std::string zero = refusal([](const Vec3d& x) { return Vec3d(x[0] > 0.25 ? 0 : 1, 0, 0); }, everywhere);
  EXPECT_NE(zero.find("(0, 0, 0) at (0.3, -1.2, -1.2)"), std::string::npos) << zero;
  const std::string nan =
      refusal([](const Vec3d& x) { return Vec3d(x[1] > 1.15 ? std::nan("") : 1, 0, 0); }, everywhere);
  EXPECT_NE(nan.find("nan"), std::string::npos) << nan;
  EXPECT_NE(refusal(one, [](const Vec3d& x) { return x[0] > 5; }).find("no active voxel"), std::string::npos);
}

}  // namespace
