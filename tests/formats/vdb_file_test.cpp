// SPDX-License-Identifier: Apache-2.0
#include "support/temporary_folder.h"
#include "support/test_fields.h"

#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/sdf_job.h"
#include "vdbtools/records/recorded_recipe.h"
#include "vdbtools/scene/fractal_options.h"

#include <gtest/gtest.h>
#include <openvdb/io/File.h>

#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <vector>

namespace {

using namespace vdbtools;
using openvdb::Coord;

openvdb::FloatGrid::Ptr fineBall() {
  const auto grid = test_fields::bandGrid([](const openvdb::Vec3d& x) { return x.length() - 0.4; }, 0.05, 0.15, 0.15);
  grid->setName("surface");
  return grid;
}

class VdbFileTest : public testing::Test {
 protected:
  VdbFileTest() { openvdb::initialize(); }
  void write(const std::string& bytes) const { std::ofstream(mPath, std::ios::binary) << bytes; }

  const TemporaryFolder mFolder;
  const std::filesystem::path mPath = mFolder.path() / "ball.vdb";
};

TEST_F(VdbFileTest, ComesBackAsItWas) {
  const auto grid = fineBall();
  const auto versor = openvdb::Vec3SGrid::create();
  versor->setName("versor");
  versor->tree().setValue(Coord(1, 2, 3), openvdb::Vec3s(0.5f, -1, 0));
  write(encodeVdb({grid, versor}, {.metadata = {{"julia_alpha", "40"}, {"julia_texture_seed", "7"}}}));
  const VdbFile file = readVdb(mPath);
  ASSERT_EQ(file.grids.size(), 2u);
  EXPECT_EQ(file.metadata.at("julia_alpha"), "40");
  EXPECT_EQ(readVdbMetadata(mPath), file.metadata);
  const auto read = chooseFloatGrid(file, "", mPath);
  EXPECT_EQ(read->metaValue<std::string>("julia_texture_seed"), "7");
  EXPECT_EQ(read->getGridClass(), openvdb::GRID_LEVEL_SET);
  EXPECT_TRUE(read->tree().hasSameTopology(grid->tree()));
  for (auto value = grid->cbeginValueOn(); value; ++value) ASSERT_EQ(read->tree().getValue(value.getCoord()), *value);
}

// Promise of design.md: "OpenVDB's random file identifier is made deterministic"
TEST_F(VdbFileTest, SameGridsSameBytes) {
  const std::string once = encodeVdb({fineBall()}, {});
  EXPECT_EQ(encodeVdb({fineBall()}, {}), once);
  // And other grids another identifier: programs tell files apart by it.
  const auto other = fineBall();
  other->tree().setValue(Coord(0), -0.125f);
  EXPECT_NE(encodeVdb({other}, {}).substr(21, 36), once.substr(21, 36));
}

// What OpenVDB counts in a build of 64 bits stands in the file, whatever the build, and with it the other statistics.
template <class Tree>
void expectRecordedMemory() {
  const auto grid = openvdb::Grid<Tree>::create();
  for (const Coord& place : {Coord(0), Coord(9, 0, 0), Coord(-700, 12, 4), Coord(5000, 0, 0)}) {
    EXPECT_EQ(decodeVdb(encodeVdb({grid}, {})).grids[0]->template metaValue<openvdb::Int64>("file_mem_bytes"),
              static_cast<openvdb::Int64>(grid->memUsage()))
        << grid->type();
    grid->tree().setValueOn(place);
  }
  const auto read = decodeVdb(encodeVdb({grid}, {})).grids[0];
  EXPECT_EQ(read->template metaValue<openvdb::Int64>("file_voxel_count"), 4);
  EXPECT_EQ(read->template metaValue<openvdb::Vec3i>("file_bbox_max"), openvdb::Vec3i(5000, 12, 4));
  EXPECT_NE(read->template metaValue<std::string>("file_compression").find("active values"), std::string::npos);
}

TEST_F(VdbFileTest, RecordsTheMemoryThatItsGridsTake) {
  if (sizeof(void*) != 8) GTEST_SKIP() << "this build has other sizes in memory";
  expectRecordedMemory<openvdb::FloatTree>();
  expectRecordedMemory<openvdb::DoubleTree>();
  expectRecordedMemory<openvdb::Int32Tree>();
  expectRecordedMemory<openvdb::Vec3STree>();
  expectRecordedMemory<openvdb::BoolTree>();
  expectRecordedMemory<openvdb::MaskTree>();
}

// With any version of OpenVDB, so that the bytes are the same: the head of 10.0. Format 225, of OpenVDB 13, differs in
// types of grids alone.
TEST_F(VdbFileTest, TheFormatIsThatOfOpenVdb10AndThatOf13IsRead) {
  std::string bytes = encodeVdb({fineBall()}, {});
  const auto number = [&](std::size_t at) {
    std::uint32_t value;
    std::memcpy(&value, bytes.data() + at, sizeof(value));
    return value;
  };
  EXPECT_EQ(number(8), 224u);
  EXPECT_EQ(number(12), 10u);
  EXPECT_EQ(number(16), 0u);
  bytes[8] = static_cast<char>(225);
  bytes[12] = 13;
  testing::internal::CaptureStderr();
  EXPECT_EQ(decodeVdb(bytes).grids.size(), 1u);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  bytes[8] = static_cast<char>(226);
  EXPECT_THROW(decodeVdb(bytes), DataError);
}

TEST_F(VdbFileTest, CanBeReadGridByGrid) {
  write(encodeVdb({fineBall()}, {}));
  openvdb::io::File file(mPath.string());
  file.open();
  EXPECT_TRUE(file.hasGrid("surface"));
  EXPECT_EQ(file.readGridMetadata("surface")->getGridClass(), openvdb::GRID_LEVEL_SET);
  EXPECT_GT(openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("surface"))->activeVoxelCount(), 100u);
}

TEST_F(VdbFileTest, HalfIsSmallerAndNearlyTheSame) {
  const auto grid = fineBall();
  const std::string full = encodeVdb({grid}, {}), half = encodeVdb({grid}, {.half = true});
  EXPECT_LT(half.size(), full.size());
  write(half);
  const auto read = chooseFloatGrid(readVdb(mPath), "surface", mPath);
  for (auto value = grid->cbeginValueOn(); value; ++value)
    ASSERT_NEAR(read->tree().getValue(value.getCoord()), *value, std::abs(*value) * 0x1p-11 + 1e-7);
}

/// A half ends at 65504; the next number would be 65536.
TEST_F(VdbFileTest, HalfHasNoInfinityThatWasNotThere) {
  const auto numbers = openvdb::FloatGrid::create(3e5F);
  numbers->setName("numbers");
  auto access = numbers->getAccessor();
  const float infinity = std::numeric_limits<float>::infinity();
  const std::vector<float> given = {1, 65504, 65510, 65520, -1e30F, infinity, -infinity};
  const std::vector<float> held = {1, 65504, 65504, 65504, -65504, infinity, -infinity};
  for (std::size_t i = 0; i < given.size(); ++i) access.setValue(openvdb::Coord(static_cast<int>(i), 0, 0), given[i]);
  numbers->fill(openvdb::CoordBBox::createCube(openvdb::Coord(4096), 8), 7e4F, true);
  const auto vectors = openvdb::Vec3SGrid::create();
  vectors->setName("vectors");
  vectors->getAccessor().setValue(openvdb::Coord(0), openvdb::Vec3s(1, -7e4F, 2e5F));
  const auto before = numbers->deepCopy();

  std::vector<ClampedGrid> clamped;
  write(encodeVdb({numbers, vectors, fineBall()}, {.half = true, .clamped = &clamped}));
  const VdbFile file = readVdb(mPath);
  const auto read = chooseFloatGrid(file, "numbers", mPath);
  for (std::size_t i = 0; i < held.size(); ++i)
    EXPECT_EQ(read->tree().getValue(openvdb::Coord(static_cast<int>(i), 0, 0)), held[i]) << given[i];
  EXPECT_EQ(read->tree().getValue(openvdb::Coord(4096)), 65504);
  EXPECT_EQ(read->background(), 65504);
  EXPECT_EQ(read->tree().getValue(openvdb::Coord(0, 1, 0)), 65504) << "inactive nodes have the background";
  const auto vector = openvdb::gridPtrCast<openvdb::Vec3SGrid>(file.grids[1])->tree().getValue(openvdb::Coord(0));
  EXPECT_EQ(vector, openvdb::Vec3s(1, -65504, 65504));
  ASSERT_EQ(clamped.size(), 2u) << "the ball has nothing to report";
  EXPECT_EQ(clamped[0].name, "numbers");
  EXPECT_EQ(clamped[0].values, 3 + 8u * 8 * 8);
  EXPECT_EQ(clamped[1].name, "vectors");
  EXPECT_EQ(clamped[1].values, 1u);

  for (int i = 0; i < 7; ++i)
    EXPECT_EQ(numbers->tree().getValue(openvdb::Coord(i, 0, 0)), before->tree().getValue(openvdb::Coord(i, 0, 0)));
  clamped.clear();
  encodeVdb({numbers}, {.clamped = &clamped});
  EXPECT_TRUE(clamped.empty()) << "32 bits hold everything";
}

// Promise of design.md: "No two grids share a name"
TEST_F(VdbFileTest, TwoGridsOfOneNameAreRefused) {
  EXPECT_THROW(encodeVdb({fineBall(), fineBall()}, {}), std::invalid_argument);
}

TEST_F(VdbFileTest, BrokenFilesAreRefused) {
  EXPECT_THROW(readVdb(mPath), MissingInputError);
  EXPECT_THROW(readVdb(mPath.parent_path()), MissingInputError);
  write("");
  EXPECT_THROW(readVdb(mPath), DataError);
  write("solid cube");
  EXPECT_THROW(readVdb(mPath), DataError);
  write(encodeVdb({}, {}));
  EXPECT_THROW(readVdb(mPath), DataError);
  // Cut off anywhere.
  const std::string bytes = encodeVdb({fineBall()}, {.metadata = {{"julia_alpha", "40"}}});
  for (std::size_t length = 0; length < bytes.size(); length += 1 + bytes.size() / 97) {
    write(bytes.substr(0, length));
    EXPECT_THROW(readVdb(mPath), DataError) << length << " of " << bytes.size() << " bytes";
  }
}

TEST_F(VdbFileTest, AGridIsChosenByNameOrRefusedWithTheList) {
  const auto phi = fineBall(), density = fineBall();
  phi->setName("phi");
  density->setName("density");
  const VdbFile file{{phi, density}, {}};
  EXPECT_EQ(chooseFloatGrid(file, "density", "x.vdb"), density);
  EXPECT_EQ(chooseFloatGrid(file, "", "x.vdb"), phi);
  try {
    chooseFloatGrid(file, "alpha", "x.vdb");
    FAIL();
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find("'density'"), std::string::npos) << error.what();
  }
  const auto a = fineBall(), b = fineBall();
  a->setName("a");
  b->setName("b");
  EXPECT_THROW(chooseFloatGrid({{a, b}, {}}, "", "x.vdb"), DataError);
  EXPECT_THROW(chooseFloatGrid({{openvdb::Vec3SGrid::create()}, {}}, "", "x.vdb"), DataError);
}

// Files of other programs may hold several grids of one name.
TEST_F(VdbFileTest, GridsOfOneNameHaveNumbers) {
  const auto first = fineBall(), second = fineBall(), other = fineBall();
  first->setName("a");
  second->setName("a");
  other->setName("b");
  const auto vectors = openvdb::Vec3SGrid::create();
  vectors->setName("v");
  openvdb::io::File(mPath).write(openvdb::GridPtrVec{second, other, first, vectors});
  const VdbFile file = readVdb(mPath);
  const std::vector<std::string> labels = gridLabels(file);
  ASSERT_EQ(labels.size(), 4U);
  std::map<std::string, openvdb::GridBase::Ptr> byLabel;
  for (std::size_t i = 0; i < 4; ++i) byLabel[labels[i]] = file.grids[i];
  ASSERT_TRUE(byLabel.contains("a[0]") && byLabel.contains("a[1]") && byLabel.contains("b") && byLabel.contains("v"));
  EXPECT_EQ(chooseFloatGrid(file, "a[0]", "x.vdb"), byLabel["a[0]"]);
  EXPECT_EQ(chooseFloatGrid(file, "a[1]", "x.vdb"), byLabel["a[1]"]);
  EXPECT_NE(byLabel["a[0]"], byLabel["a[1]"]);
  for (const char* name : {"a", "", "a[2]"}) try {
      chooseFloatGrid(file, name, "x.vdb");
      FAIL() << name;
    } catch (const DataError& error) {
      for (const char* label : {"'a[0]' (float)", "'a[1]' (float)"})
        EXPECT_NE(std::string(error.what()).find(label), std::string::npos) << error.what();
    }
}

TEST(Recipe, SurvivesMetadata) {
  const Recipe recipe = completeRecipe(
      {{"input", "a b.obj"}, {"alpha", "x:10:300:smooth"}, {"texture-integer", "true"}}, fractalOptionTable());
  EXPECT_EQ(recipe.at("beta"), "0");
  const auto metadata = recipeToMetadata(recipe, "fractal");
  for (const auto& [name, value] : metadata)
    for (const char c : name) EXPECT_TRUE(std::isalnum(static_cast<unsigned char>(c)) || c == '_') << name;
  const auto [command, back] = recordedRecipe(metadata);
  EXPECT_EQ(back, recipe);
  EXPECT_EQ(command, "fractal");
  EXPECT_EQ(recordedRecipe({{"name", "x"}}).command, "");
}

// Promise: Detail and the papers' numbers ...
TEST(Recipe, TwoWaysToSayTheSameAreRefusedTogether) {
  EXPECT_THROW(parseFractalOptions({{"input", "a.obj"}, {"resolution", "10"}, {"voxel-size", "1"}}),
               std::invalid_argument);
}

TEST(Recipe, TheDefaultsAreValid) {
  EXPECT_NO_THROW(parseFractalOptions(completeRecipe({{"input", "a.obj"}}, fractalOptionTable())));
  EXPECT_NO_THROW(parseSdfOptions(completeRecipe({{"input", "a.obj"}}, sdfOptionTable())));
}

// Promise: "wrong usage: an unknown ..."
TEST(Recipe, EveryValueIsChecked) {
  const std::pair<const char*, const char*> wrong[] = {{"resolution", "0"},
                                                       {"resolution", "nan"},
                                                       {"resolution", "-3"},
                                                       {"voxel-size", "1e400"},
                                                       {"voxel-size", "0"},
                                                       {"iterations", "0"},
                                                       {"iterations", "2.5"},
                                                       {"iterations", "99999999999"},
                                                       {"escape", "1"},
                                                       {"escape", "inf"},
                                                       {"slice", "x"},
                                                       {"origin", "1,2"},
                                                       {"origin", "1,2,3,4"},
                                                       {"drop-axis", "r"},
                                                       {"space", "mars"},
                                                       {"box", "0,0,0,1,1"},
                                                       {"box", "0,0,0,1,-1,1"},
                                                       {"map", "mandelbrot"},
                                                       {"c", "1,2,3"},
                                                       {"c", "1,2,3,nan"},
                                                       {"texture-seed", "-1"},
                                                       {"texture-seed", "1.5"},
                                                       {"texture-roots", "0"},
                                                       {"texture-powers", "5:2"},
                                                       {"texture-powers", "1:2:3"},
                                                       {"texture-powers", "a:b"},
                                                       {"texture-placement", "sky"},
                                                       {"texture-radius", "0"},
                                                       {"texture-scale", "0"},
                                                       {"texture-translate", "1"},
                                                       {"tolerance", "0"},
                                                       {"tolerance", "0.7"},
                                                       {"precision", "half"},
                                                       {"grids", "surface,moon"},
                                                       {"grids", "surface,surface"},
                                                       {"grids", ""},
                                                       {"repair", "maybe"},
                                                       {"repair-gap", "-1"},
                                                       {"half", "yes"},
                                                       {"no-such-option", "1"}};
  for (const auto& [name, value] : wrong) try {
      Recipe recipe{{"input", "a.obj"}};
      recipe[name] = value;
      parseFractalOptions(recipe);
      ADD_FAILURE() << "--" << name << " " << value << " was taken";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
    }
}

}  // namespace
