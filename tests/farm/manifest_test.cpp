// SPDX-License-Identifier: Apache-2.0
#include "support/temporary_folder.h"

#include "vdbtools/farm/manifest.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/scene/fractal_options.h"

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <set>
#include <stdexcept>
#include <string>

namespace vdbtools {
namespace {

using namespace vdbtools::farm;
namespace fs = std::filesystem;

class ManifestTest : public ::testing::Test {
 protected:
  void put(const std::string& text) const { std::ofstream(mFolder / kManifestName, std::ios::binary) << text; }

  template <class Error>
  std::string refusal(const std::string& text) const {
    put(text);
    try {
      readManifest(mFolder);
    } catch (const Error& error) {
      return error.what();
    }
    ADD_FAILURE() << "this manifest was not refused:\n" << text;
    return {};
  }

  const TemporaryFolder mTemporary;
  const fs::path mFolder = mTemporary.path();
};

Manifest tiles() {
  constexpr int kHigh = 1 << 30, kLow = -kHigh;
  Manifest manifest;
  manifest.kind = PlanKind::Tiles;
  manifest.recipe = {{"input", "a \"b\"\\\n\u00e4.obj"}, {"alpha", "40"}};
  manifest.makes = {"vdb", "ply"};
  manifest.metadata = {{"julia_origin_at", "0.1,0,0"}};
  manifest.lattice = TileLattice{{{kLow, -8, 0}, {kHigh, 7, 7}}, true, 1.0 / 3};
  manifest.inputs = {{"prepared.vdb", std::string(64, 'a')}, {"/models/b.obj", std::string(64, 'b')}};
  manifest.tasks.resize(3);
  for (int k = 0; k < 3; ++k) {
    manifest.tasks[static_cast<std::size_t>(k)].box = openvdb::CoordBBox({8 * k, -8, 0}, {8 * k + 7, 7, 7});
    manifest.tasks[static_cast<std::size_t>(k)].writes = {"tiles/000" + std::to_string(k + 1) + ".tile",
                                                          "tiles/000" + std::to_string(k + 1) + ".vdb"};
  }
  manifest.tasks[1].recipe = {{"alpha", "12"}, {"frame", "2"}};
  return manifest;
}

TEST_F(ManifestTest, ComesBackAsItWas) {
  const Manifest planned = tiles();
  put(encodeManifest(planned));
  const Manifest read = readManifest(mFolder);
  EXPECT_EQ(read.kind, planned.kind);
  EXPECT_EQ(read.recipe, planned.recipe);
  EXPECT_EQ(read.makes, planned.makes);
  EXPECT_EQ(read.metadata, planned.metadata);
  ASSERT_TRUE(read.lattice);
  EXPECT_EQ(read.lattice->domain, planned.lattice->domain);
  EXPECT_EQ(read.lattice->bounded, planned.lattice->bounded);
  EXPECT_EQ(read.lattice->voxelSize, planned.lattice->voxelSize);
  ASSERT_EQ(read.inputs.size(), planned.inputs.size());
  for (std::size_t i = 0; i < read.inputs.size(); ++i) {
    EXPECT_EQ(read.inputs[i].path, planned.inputs[i].path);
    EXPECT_EQ(read.inputs[i].sha256, planned.inputs[i].sha256);
  }
  ASSERT_EQ(read.tasks.size(), planned.tasks.size());
  for (std::size_t i = 0; i < read.tasks.size(); ++i) {
    EXPECT_EQ(read.tasks[i].recipe, planned.tasks[i].recipe);
    EXPECT_EQ(read.tasks[i].box, planned.tasks[i].box);
    EXPECT_EQ(read.tasks[i].writes, planned.tasks[i].writes);
    EXPECT_EQ(taskHash(read, i + 1), taskHash(planned, i + 1));
  }
  EXPECT_FALSE(read.version.empty());
  EXPECT_EQ(encodeManifest(read), encodeManifest(planned));
}

TEST_F(ManifestTest, NeedsNeitherBoxesNorALattice) {
  for (const PlanKind kind : {PlanKind::Frames, PlanKind::Sheet}) {
    Manifest manifest;
    manifest.kind = kind;
    manifest.makes = {"stl"};
    manifest.metadata = {{"folder", "/"}};
    manifest.tasks = {{.writes = {"out/a.stl"}}};
    put(encodeManifest(manifest));
    const Manifest read = readManifest(mFolder);
    EXPECT_EQ(read.kind, kind);
    EXPECT_FALSE(read.lattice);
    EXPECT_FALSE(read.tasks.at(0).box);
  }
}

// Promise: A changed plan, "Only this ..."
TEST_F(ManifestTest, EveryChangeByHandIsNoticed) {
  const std::string text = encodeManifest(tiles());
  int changes = 0;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] < '0' || text[at] > '9') continue;
    std::string changed = text;
    changed[at] = text[at] == '9' ? '8' : static_cast<char>(text[at] + 1);
    const std::string said = refusal<DataError>(changed);
    EXPECT_EQ(said.find('\n'), std::string::npos);
    ++changes;
  }
  EXPECT_GT(changes, 100);
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, text.size() / 2, text.size() - 3})
    refusal<DataError>(text.substr(0, size));
  refusal<DataError>("[]\n");
  refusal<DataError>("{\"juliavdb\": \"sheet\"}\n");
}

TEST_F(ManifestTest, AnotherVersionIsNamed) {
  const std::string text = encodeManifest(tiles());
  put(text);
  const std::string version = readManifest(mFolder).version;
  std::string changed = text;
  changed.replace(changed.find(version), version.size(), "0.0.7");
  const std::string said = refusal<DataError>(changed);
  EXPECT_NE(said.find("version 0.0.7"), std::string::npos) << said;
  EXPECT_NE(said.find("version " + version), std::string::npos) << said;
}

TEST_F(ManifestTest, AFolderWithoutOneIsNamed) {
  try {
    readManifest(mFolder);
    FAIL() << "there is no manifest";
  } catch (const MissingInputError& error) {
    EXPECT_NE(std::string(error.what()).find(mFolder.native()), std::string::npos);
  }
}

// Promise: A changed plan, "Only this ..."
TEST(TaskHash, CoversAllThatTheResultDependsOn) {
  std::set<std::string> hashes;
  const std::vector<std::function<void(Manifest&)>> changes = {
      [](Manifest&) {},
      [](Manifest& m) { m.kind = PlanKind::Frames; },
      [](Manifest& m) { m.makes.pop_back(); },
      [](Manifest& m) { m.recipe["alpha"] = "41"; },
      [](Manifest& m) { m.lattice->voxelSize *= 2; },
      [](Manifest& m) { m.lattice->bounded = false; },
      [](Manifest& m) { m.lattice->domain.max().z() += 1; },
      [](Manifest& m) { m.inputs[1].sha256[5] = 'c'; },
      [](Manifest& m) { m.tasks[0].recipe["alpha"] = "41"; },
      [](Manifest& m) { m.tasks[0].box->max().z() += 1; },
      [](Manifest& m) { m.tasks[0].writes.push_back("x"); },
      [](Manifest& m) { m.version = "0.0.7"; },
  };
  for (const auto& change : changes) {
    Manifest manifest = tiles();
    change(manifest);
    EXPECT_TRUE(hashes.insert(taskHash(manifest, 1)).second) << "change " << hashes.size();
  }
  Manifest manifest = tiles();
  manifest.inputs[1].path = "/elsewhere/b.obj";
  manifest.tasks[2].recipe["alpha"] = "41";
  EXPECT_EQ(hashes.count(taskHash(manifest, 1)), 1u) << "another task, or a moved file, changes nothing";
}

TEST(TaskRecipe, TakesTheTasksOwnValues) {
  Manifest manifest = tiles();
  manifest.recipe = completeRecipe({{"input", "b.obj"}, {"alpha", "40"}}, fractalOptionTable());
  manifest.tasks[2].recipe = {{"detail", "0.3"}};
  EXPECT_EQ(taskRecipe(manifest, 1), manifest.recipe);
  const Recipe second = taskRecipe(manifest, 2);
  EXPECT_EQ(second.at("alpha"), "12");
  EXPECT_EQ(second.at("frame"), "2");
  EXPECT_EQ(second.at("input"), manifest.recipe.at("input"));
  EXPECT_EQ(taskRecipe(manifest, 3).count("alpha"), 0u) << "--detail stands for --alpha";
  EXPECT_THROW(taskRecipe(manifest, 0), std::out_of_range);
  EXPECT_THROW(taskRecipe(manifest, 4), std::out_of_range);
  EXPECT_THROW(taskHash(manifest, 4), std::out_of_range);
}

}  // namespace
}  // namespace vdbtools
