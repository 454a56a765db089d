// SPDX-License-Identifier: Apache-2.0
// Recipes that come back from files: broken ones are bad data, and the files that they name must be the same.
#include "support/temporary_folder.h"
#include "support/test_meshes.h"

#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/job/sdf_job.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/records/recorded_recipe.h"

#include <gtest/gtest.h>

#include <sstream>

namespace {

using namespace vdbtools;
using openvdb::Vec3d;

class RecordedRecipeTest : public testing::Test {
 protected:
  RecordedRecipeTest() { openvdb::initialize(); }

  std::string writeBall() const {
    std::ostringstream stream;
    writeMesh(stream, test_meshes::makeSphere(1, 3), {.format = &meshFormat(".obj")});
    return mFolder.write("ball.obj", stream.str()).string();
  }
  std::string writeGrid(const std::string& name, float value) const {
    const auto grid = openvdb::FloatGrid::create(value);
    grid->setName("paint");
    grid->tree().setValue(openvdb::Coord(0), value);
    return mFolder.write(name, encodeVdb({grid}, {})).string();
  }
  Scene scene(const Recipe& recipe) { return makeScene(parseFractalOptions(recipe), mMonitor); }

  TemporaryFolder mFolder;
  Monitor mMonitor;
};

// Promise: "a run from a recipe refuses ..."
// Promise: "Every file that a source ..."
TEST_F(RecordedRecipeTest, EveryFileIsHashedAndAnotherOneIsRefused) {
  for (const char* control : {"alpha", "beta"}) {
    SCOPED_TRACE(control);
    const float value = control[0] == 'a' ? 40.0F : 0.01F;
    const Recipe recipe = completeRecipe(
        {{"input", writeBall()}, {"resolution", "20"}, {"sdf-resolution", "20"}, {control, writeGrid("g.vdb", value)}},
        fractalOptionTable());
    const Scene first = scene(recipe);
    const std::string fact = "julia_" + std::string(control) + "_sha256";
    ASSERT_TRUE(first.metadata.contains(fact));
    const Recipe recorded = recordedRecipe(sceneMetadata(first, recipe)).recipe;
    EXPECT_NO_THROW(scene(recorded));
    writeGrid("g.vdb", value * 1.5F);
    EXPECT_THROW(scene(recorded), DataError) << "another grid under the same name made another fractal";
    EXPECT_NO_THROW(scene(recipe));
    // Given anew, it is a new file.
    const Recipe again = overridden(recorded, {{control, recipe.at(control)}}, fractalOptionTable());
    EXPECT_NO_THROW(scene(again));
  }
}

TEST_F(RecordedRecipeTest, ABrokenRecipeIsBadData) {
  const std::pair<const char*, const char*> broken[] = {
      {"julia_alpha", "soup"}, {"julia_resolution", "-1"}, {"julia_map", "moebius"}, {"julia_grids", "moon"}};
  for (const auto& [name, value] : broken) {
    const auto grid = openvdb::FloatGrid::create(1);
    const auto path =
        mFolder.write("broken.vdb", encodeVdb({grid}, {.metadata = {{"julia_command", "fractal"}, {name, value}}}));
    try {
      readRecordedRecipe(path);
      ADD_FAILURE() << name << " = " << value << " was taken";
    } catch (const DataError& error) {
      EXPECT_NE(std::string(error.what()).find("broken.vdb"), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find(value), std::string::npos) << error.what();
    }
  }
}

TEST_F(RecordedRecipeTest, ABrokenTargetBoxIsBadData) {
  const SdfResult sdf = runSdf({.input = writeBall(), .voxels = {.resolution = 20}}, mMonitor);
  for (const char* box : {"", "1,2,3", "0,0,0,1,1,nan", "1,1,1,0,0,0"}) {
    const std::string path =
        mFolder.write("sdf.vdb", encodeVdb({sdf.grid}, {.metadata = {{"julia_target_box", box}}})).string();
    EXPECT_THROW(scene(completeRecipe({{"input", path}}, fractalOptionTable())), DataError) << box;
  }
}

TEST_F(RecordedRecipeTest, AShapeThatNoResolutionServesIsBadData) {
  const VoxelChoice usual{.resolution = 200}, odd{.resolution = 1e13}, size{.voxelSize = 1e-13};
  EXPECT_THROW(usual.sizeFor(6e33), DataError);
  EXPECT_THROW(usual.sizeFor(1e-11), DataError);
  EXPECT_THROW(odd.sizeFor(2), std::invalid_argument);
  EXPECT_THROW(size.sizeFor(2), std::invalid_argument);
  EXPECT_EQ(usual.sizeFor(2), 0.01);
  EXPECT_EQ(usual.sizeFor(2e-6), 1e-8);
}

TEST_F(RecordedRecipeTest, ABandOfOneVoxelIsRefusedWhereItIsRead) {
  try {
    parseSdfOptions({{"input", "a.obj"}, {"band", "1"}});
    ADD_FAILURE();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("--band is '1'"), std::string::npos) << error.what();
  }
  EXPECT_NO_THROW(parseSdfOptions({{"input", "a.obj"}, {"band", "1.01"}}));
}

}  // namespace
