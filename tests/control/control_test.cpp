// SPDX-License-Identifier: Apache-2.0
// Controls: every kind read from text and bound to a box, against its definition; their bounds hold everywhere.
#include "support/temporary_folder.h"
#include "support/test_controls.h"
#include "support/test_meshes.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/control/control.h"
#include "vdbtools/formats/vdb_file.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

namespace {

using namespace vdbtools;
using openvdb::BBoxd;
using openvdb::Coord;
using openvdb::Vec3d;
using test_controls::source;

const ControlContext kContext{BBoxd(Vec3d(-1, 0, 0), Vec3d(3, 1, 1))};

openvdb::FloatGrid::Ptr oneSeven() {
  const auto grid = openvdb::FloatGrid::create(5);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
  grid->tree().setValue(Coord(0), 7);
  grid->setName("paint");
  return grid;
}

TEST(Control, ReadsNumbers) {
  const Control number = source("-2.5")->bind(kContext);
  EXPECT_EQ(number.at(Vec3d(9, 9, 9)), -2.5);
  EXPECT_EQ(number.constant(), -2.5);
  EXPECT_EQ(number.range(), std::pair(-2.5, -2.5));
}

TEST(Control, ReadsRamps) {
  const Control ramp = source("x:10@0.25:300@0.75:smooth")->bind(kContext);
  const auto at = [&](double x) { return ramp.at(Vec3d(x, 5, 5)); };
  EXPECT_EQ(at(-7), 10);
  EXPECT_EQ(at(0), 10);
  EXPECT_DOUBLE_EQ(at(1), 155);
  EXPECT_EQ(at(2), 300);
  // Smooth: no slope at the ends; and monotonic.
  EXPECT_LT(at(0.01) - 10, 290 * 3 * 0.005 * 0.005 * 1.01);
  for (double x = 0; x < 2; x += 0.1) EXPECT_LT(at(x), at(x + 0.1));
  EXPECT_DOUBLE_EQ(source("z:0:1")->bind(kContext).at(Vec3d(9, 9, 0.3)), 0.3);
  EXPECT_EQ(ramp.range(), std::pair(10.0, 300.0));
  EXPECT_FALSE(ramp.constant());
}

TEST(Control, ReadsGridsOfFilesAndNamesTheFiles) {
  openvdb::initialize();
  const TemporaryFolder folder;
  const std::string path = folder.write("paint.vdb", encodeVdb({oneSeven()}, {})).string();
  for (const std::string& text : {path, path + ":paint"}) {
    const auto grid = source(text);
    ASSERT_EQ(grid->files().size(), 1u);
    EXPECT_EQ(grid->files()[0].path, path);
    EXPECT_EQ(grid->files()[0].recordedAs, "alpha-sha256");
    EXPECT_EQ(grid->text(), text);
    const Control control = grid->bind(kContext);
    EXPECT_EQ(control.at(Vec3d(0)), 7);
    EXPECT_DOUBLE_EQ(control.at(Vec3d(0.25, 0, 0)), 6);
    EXPECT_EQ(control.at(Vec3d(100)), 5);
    EXPECT_EQ(control.range(), std::pair(5.0, 7.0));
  }
  EXPECT_THROW(source(path + ":other")->bind(kContext), DataError);
}

// Bounds of the exponent are made of those of the controls.
TEST(Control, NoValueLeavesTheRange) {
  openvdb::initialize();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-1, 3);
  std::uniform_int_distribution<int> tenths(-30, 30);
  std::vector<Control> controls{Control(3.0), Control(openvdb::FloatGrid::ConstPtr(oneSeven()))};
  for (int i = 0; i < 300; ++i) {
    const double from = tenths(random) / 10.0, to = tenths(random) / 10.0;
    for (const bool smooth : {false, true})
      controls.emplace_back(Ramp{.axis = 0, .from = from, .to = to, .endAt = 0.7, .smooth = smooth},
                            kContext.targetBox);
    const auto grid = openvdb::FloatGrid::create(static_cast<float>(from));
    grid->fill(openvdb::CoordBBox(openvdb::Coord(-1), openvdb::Coord(1)), static_cast<float>(to));
    controls.emplace_back(openvdb::FloatGrid::ConstPtr(grid));
  }
  for (const Control& control : controls) {
    const auto [least, most] = control.range();
    for (double x = -1; x < 3; x += 0.125)
      for (const double shift : {0.0, 1e-16, -1e-9, place(random)}) {
        const double value = control.at(Vec3d(x + shift, 0.5, 0.5));
        ASSERT_GE(value, least) << x + shift;
        ASSERT_LE(value, most) << x + shift;
      }
  }
}

TEST(Control, ItsTextMakesItAgain) {
  for (const char* text : {"40", "x:10:300:smooth", "z:1@0.25:2@0.5", "paint.vdb:alpha"})
    EXPECT_EQ(source(text)->text(), text);
}

// The option is named where it is read, and nowhere later.
TEST(Control, RefusesBrokenTextByTheOptionsName) {
  for (const char* text : {"nan", "inf", "-inf", "1e999", "x:1:nan", "x:1@2@3:4", "x:a:4", "x:1:2:rough",
                           "x:1:2:smooth:3", "x:1@0.8:2@0.2", "", "w:1:2", "1 2", "x:1", "x:1:"})
    try {
      source(text);
      ADD_FAILURE() << "'" << text << "' was taken";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find("--alpha is '" + std::string(text) + "'"), std::string::npos)
          << error.what();
    }
  EXPECT_THROW(Control(Ramp{.axis = 0, .from = 1, .to = 2, .startAt = 0.5, .endAt = 0.5}, kContext.targetBox),
               std::invalid_argument);
  const auto grid = oneSeven();
  grid->tree().setValue(Coord(1), std::numeric_limits<float>::infinity());
  EXPECT_THROW(Control(openvdb::FloatGrid::ConstPtr(grid)), DataError);
}

}  // namespace
