// SPDX-License-Identifier: Apache-2.0
// Contact sheets: which cells there are and where, what their recipes say, and which pictures are made again.
#include "support/temporary_folder.h"
#include "support/test_meshes.h"

#include "vdbtools/files/named_file.h"
#include "vdbtools/job/sheet_job.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/records/recorded_recipe.h"
#include "vdbtools/scene/fractal_options.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <set>
#include <sstream>

namespace {

using namespace vdbtools;

VariedOption varied(const std::string& text) { return parseVaried(text, fractalOptionTable(), kMostSheetCells); }

SheetOptions seeds(int count) {
  return {.varied = {varied("texture-seed=1:" + std::to_string(count) + ":1")}, .base = {{"input", "a.obj"}}};
}

TEST(SheetPlan, OneOptionFillsRowsWithFewEmptyPlaces) {
  std::vector<int> counts{97, 100, 101, 399, 400};
  for (int count = 1; count <= 30; ++count) counts.push_back(count);
  for (const int count : counts) {
    SCOPED_TRACE(count);
    const Sheet sheet = planSheet(seeds(count));
    ASSERT_EQ(sheet.cells.size(), static_cast<std::size_t>(count));
    EXPECT_GE(sheet.rows * sheet.columns, count);
    EXPECT_LT((sheet.rows - 1) * sheet.columns, count) << "a row is empty";
    EXPECT_GE(sheet.columns, sheet.rows);
    EXPECT_LE(sheet.columns, sheet.rows + 5) << "neither a column nor a ribbon";
    for (std::size_t i = 0; i < sheet.cells.size(); ++i)
      EXPECT_EQ(sheet.cells[i].varied, (Recipe{{"texture-seed", std::to_string(i + 1)}}));
  }
  SheetOptions asked = seeds(7);
  asked.columns = 3;
  EXPECT_EQ(planSheet(asked).rows, 3);
  asked.columns = 20;
  EXPECT_EQ(planSheet(asked).columns, 7);
}

TEST(SheetPlan, TwoOptionsAreRowsAndColumns) {
  const SheetOptions options{.varied = {varied("alpha=10,20"), varied("texture-seed=1,2,3")}, .base = {{"input", "a"}}};
  const Sheet sheet = planSheet(options);
  EXPECT_EQ(sheet.rows, 2);
  EXPECT_EQ(sheet.columns, 3);
  ASSERT_EQ(sheet.cells.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_EQ(sheet.cells[i].varied,
              (Recipe{{"alpha", i < 3 ? "10" : "20"}, {"texture-seed", std::to_string(i % 3 + 1)}}));
}

/// The values "1,2,...".
std::string upTo(int count) { return "1:" + std::to_string(count) + ":1"; }

// Promise of controls.md: A sheet's page is never a strip
TEST(SheetPlan, NoSheetIsAStrip) {
  constexpr int kLongest = 3;
  const std::vector<std::array<int, 2>> sizes{{256, 256}, {300, 100}, {100, 300}, {300, 300}};
  for (const auto& [width, height] : sizes)
    for (const int first : {1, 2, 3, 5, 7, 14})
      for (const int second : {1, 2, 4, 5, 10, 25}) {
        SCOPED_TRACE(std::to_string(first) + " x " + std::to_string(second) + " of " + std::to_string(width) + "x" +
                     std::to_string(height));
        SheetOptions options{.varied = {varied("iterations=" + upTo(first)), varied("texture-seed=" + upTo(second))},
                             .base = {{"input", "a.obj"}},
                             .view = {{"size", std::to_string(width) + "x" + std::to_string(height)}}};
        for (const bool both : {true, false}) {
          if (!both) options.varied.erase(options.varied.begin());
          const Sheet sheet = planSheet(options);
          EXPECT_GE(sheet.rows * sheet.columns, static_cast<int>(sheet.cells.size()));
          // Cells that are strips themselves stand one above the other, or side by side.
          EXPECT_TRUE(sheet.columns == 1 || sheet.columns * width <= kLongest * sheet.rows * height)
              << sheet.columns << " columns, " << sheet.rows << " rows";
          EXPECT_TRUE(sheet.rows == 1 || sheet.rows * height <= kLongest * sheet.columns * width)
              << sheet.columns << " columns, " << sheet.rows << " rows";
        }
      }
}

TEST(SheetPlan, RefusesWhatIsNoSheet) {
  EXPECT_THROW(planSheet({}), std::invalid_argument);
  EXPECT_THROW(planSheet({.varied = {varied("alpha=1"), varied("beta=1"), varied("texture-seed=1")}}),
               std::invalid_argument);
  EXPECT_THROW(planSheet({.varied = {varied("alpha=1"), varied("alpha=2")}}), std::invalid_argument);
  EXPECT_THROW(planSheet({.varied = {varied("alpha=1,2")}, .given = {{"alpha", "3"}}}), std::invalid_argument);
  EXPECT_THROW(planSheet({.varied = {varied("alpha=1:21:1"), varied("texture-seed=1:20:1")}}), std::invalid_argument);
  EXPECT_NO_THROW(planSheet({.varied = {varied("alpha=1:20:1"), varied("texture-seed=1:20:1")}}));
  EXPECT_THROW(planSheet({.varied = {varied("alpha=1"), varied("beta=1")}, .columns = 2}), std::invalid_argument);
  EXPECT_THROW(planSheet({.varied = {varied("alpha=1")}, .view = {{"size", "0x0"}}}), std::invalid_argument);
}

// Promise: "Options on the command line ..."
TEST(SheetPlan, AVariedOptionDisplacesItsAlternativeInTheBaseOnly) {
  const VariedOption option = varied("sdf-voxel-size=0.1,0.2");
  const Recipe rest{{"sdf-resolution", "32"}};
  for (const SheetCell& cell : planSheet({.varied = {option}, .base = rest}).cells) {
    EXPECT_FALSE(cell.recipe.contains("sdf-resolution"));
    EXPECT_EQ(cell.error, "");
  }
  // What stands beside --vary on the command line contradicts it, as two options there do.
  for (const SheetCell& cell : planSheet({.varied = {option}, .base = rest, .given = rest}).cells)
    EXPECT_NE(cell.error.find("--sdf-resolution"), std::string::npos) << cell.error;
}

class SheetJob : public testing::Test {
 protected:
  SheetJob() {
    std::ostringstream stream;
    writeMesh(stream, test_meshes::makeSphere(1, 2), {.format = &meshFormat(".obj")});
    mBall = mFolder.write("ball.obj", stream.str()).string();
  }

  SheetOptions options(const std::vector<std::string>& vary) const {
    SheetOptions result{.base = {{"input", mBall}, {"sdf-resolution", "16"}, {"resolution", "16"}},
                        .view = {{"size", "24x16"}, {"samples", "1"}}};
    for (const std::string& text : vary) result.varied.push_back(varied(text));
    return result;
  }
  SheetPage make(const SheetOptions& what, const std::string& folder = "cells") {
    return makeSheet(what, mFolder.path() / folder, mMonitor);
  }
  std::set<std::string> finished(const std::string& folder = "cells") const {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(mFolder.path() / folder))
      names.insert(entry.path().filename().string());
    return names;
  }

  TemporaryFolder mFolder;
  Monitor mMonitor;
  std::string mBall;
};

// Promise: A cell of a sheet is what ...
TEST_F(SheetJob, RecipesAreCompleteAndComeBack) {
  const Sheet sheet = planSheet(options({"alpha=20,40"}));
  const std::string file = mFolder.write("s.json", encodeSheet(sheet)).string();
  EXPECT_TRUE(isSheetFile(file));
  for (std::size_t i = 0; i < 2; ++i) {
    const Recipe& recipe = sheet.cells[i].recipe;
    EXPECT_EQ(recipe.at("alpha"), i == 0 ? "20" : "40");
    EXPECT_EQ(recipe.at("source-sha256"), sha256OfFile(mBall));
    EXPECT_EQ(completeRecipe(recipe, fractalOptionTable()), recipe);
    const RecordedRecipe back = readRecordedRecipe(file + "#" + std::to_string(i + 1));
    EXPECT_EQ(back.command, "fractal");
    EXPECT_EQ(back.recipe, recipe);
  }
  for (const char* none : {"", "#", "#0", "#3", "#-1", "#x", "#1.5"})
    EXPECT_THROW(readRecordedRecipe(file + none), std::invalid_argument) << none;
  mFolder.write("broken.json", R"({"juliavdb": "sheet", "version": 1, "cells": [{"number": 1}]})");
  mFolder.write("versor.json", R"({"juliavdb": "rational", "version": 1})");
  mFolder.write("text.json", "no JSON");
  for (const char* bad : {"broken.json#1", "versor.json#1", "text.json#1"})
    EXPECT_THROW(readRecordedRecipe(mFolder.path() / bad), DataError) << bad;
  EXPECT_THROW(readRecordedRecipe(mFolder.path() / "missing.json#1"), MissingInputError);
  EXPECT_FALSE(isSheetFile(mFolder.path() / "versor.json"));
  EXPECT_FALSE(isSheetFile(mFolder.path() / "missing.json"));
}

TEST_F(SheetJob, OnlyNewCellsAreMade) {
  const SheetPage first = make(options({"alpha=20,40"}));
  EXPECT_EQ(first.reusedCells, 0U);
  EXPECT_EQ(finished().size(), 2U);
  const SheetPage again = make(options({"alpha=20,40"}));
  EXPECT_EQ(again.reusedCells, 2U);
  EXPECT_EQ(again.picture, first.picture);
  const SheetPage more = make(options({"alpha=40,30,20"}));
  EXPECT_EQ(more.reusedCells, 2U);
  EXPECT_EQ(finished().size(), 3U);
  EXPECT_EQ(more.picture, make(options({"alpha=40,30,20"}), "elsewhere").picture) << "a kept cell looks otherwise";
}

// Promise: "Nothing is made twice", and the program ...
TEST_F(SheetJob, WhatChangesACellMakesItAgain) {
  const SheetOptions usual = options({"alpha=20,40"});
  make(usual);
  SheetOptions other = usual;
  other.view["azimuth"] = "10";
  EXPECT_EQ(make(other).reusedCells, 0U);
  other = usual;
  other.base["texture-seed"] = "2";
  EXPECT_EQ(make(other).reusedCells, 0U);
  EXPECT_EQ(make(usual).reusedCells, 2U);
  std::ostringstream stream;
  writeMesh(stream, test_meshes::makeSphere(1.2, 2), {.format = &meshFormat(".obj")});
  mFolder.write("ball.obj", stream.str());
  EXPECT_EQ(make(usual).reusedCells, 0U) << "the mesh is another one";
}

// Promise: "Nothing is made twice", and the program ...
TEST_F(SheetJob, ABrokenCellIsMadeAgain) {
  const SheetPage first = make(options({"alpha=20,40"}));
  for (const std::string& name : finished()) mFolder.write("cells/" + name, "no picture");
  const SheetPage again = make(options({"alpha=20,40"}));
  EXPECT_EQ(again.reusedCells, 0U);
  EXPECT_EQ(again.picture, first.picture);
  EXPECT_EQ(make(options({"alpha=20,40"})).reusedCells, 2U);
}

// Promise: "It fails itself only if ..."
TEST_F(SheetJob, AFailedCellLeavesTheOthersAlone) {
  const SheetPage page = make(options({"alpha=20,-1,word"}));
  ASSERT_EQ(page.sheet.cells.size(), 3U);
  EXPECT_EQ(page.sheet.cells[0].error, "");
  EXPECT_NE(page.sheet.cells[1].error.find("-1"), std::string::npos);
  EXPECT_NE(page.sheet.cells[2].error.find("word"), std::string::npos);
  EXPECT_EQ(finished().size(), 1U);
  EXPECT_NE(page.picture, make(options({"alpha=20"})).picture);
}

// Promise: "It fails itself only if ..."
TEST_F(SheetJob, IfAllFailTheirErrorIsTheSheets) {
  EXPECT_THROW(make(options({"alpha=-1,-2"})), std::invalid_argument);
  SheetOptions missing = options({"alpha=20,40"});
  missing.base["input"] = (mFolder.path() / "missing.obj").string();
  EXPECT_THROW(make(missing), MissingInputError);
  SheetOptions behind = options({"alpha=20,40"});
  behind.view.insert({{"eye", "0,0,9"}, {"look-at", "0,0,19"}});
  EXPECT_THROW(make(behind), DataError) << "a picture without anything in it is no picture of the set";
  EXPECT_FALSE(std::filesystem::exists(mFolder.path() / "cells"));
}

TEST_F(SheetJob, TheFolderCanBeRefused) {
  mFolder.write("cells", "in the way");
  EXPECT_THROW(make(options({"alpha=20,40"})), CreateError);
}

// Promise of controls.md: A sheet that takes more than an hour is told before the first cell is made
TEST_F(SheetJob, WhatTakesLongIsToldBeforeTheFirstCell) {
  /// Notes whether the work on a cell has begun.
  class Watching final : public Monitor {
   public:
    void begin(const Phase& phase, std::uint64_t) override {
      if (phase.kind == PhaseKind::Surface) mAnyMesh = true;
      if (phase.kind == PhaseKind::Render) mAnyPicture = true;
    }
    bool anyMesh() const { return mAnyMesh; }
    bool anyPicture() const { return mAnyPicture; }

   private:
    std::atomic<bool> mAnyMesh{false}, mAnyPicture{false};
  } watching;
  SheetOptions what = options({"alpha=20,40,60"});
  std::vector<std::string> told;
  LongWork longWork{.seconds = 0, .tell = [&](const std::string& words) {
                      EXPECT_FALSE(watching.anyMesh());
                      told.push_back(words);
                      told.back() += watching.anyPicture() ? " (late)" : " (in time)";
                    }};
  makeSheet(what, mFolder.path() / "fields", watching, longWork);
  EXPECT_TRUE(watching.anyPicture());
  EXPECT_FALSE(watching.anyMesh());
  ASSERT_EQ(told.size(), 1U);
  EXPECT_NE(told[0].find("the pictures of 3 cells will take some"), std::string::npos) << told[0];
  EXPECT_TRUE(told[0].ends_with("(in time)")) << told[0];
  makeSheet(what, mFolder.path() / "fields", watching, longWork);
  EXPECT_EQ(told.size(), 1U) << "nothing is left to do";
  told.clear();
  what.view["preview"] = "mesh";
  make({.varied = {varied("alpha=20")}, .base = what.base, .view = what.view});
  makeSheet(what, mFolder.path() / "cells", watching, longWork);
  EXPECT_TRUE(watching.anyMesh());
  ASSERT_EQ(told.size(), 1U);
  EXPECT_NE(told[0].find("of 2 cells"), std::string::npos) << "one of the three is there already: " << told[0];
  EXPECT_NE(told[0].find("hours"), std::string::npos);
  makeSheet(what, mFolder.path() / "cells", watching, longWork);
  EXPECT_EQ(told.size(), 1U) << "nothing is left to do";
  longWork.seconds = 1e9;
  makeSheet(what, mFolder.path() / "elsewhere", watching, longWork);
  EXPECT_EQ(told.size(), 1U);
}

TEST_F(SheetJob, AnInterruptionKeepsWhatIsFinished) {
  /// Cancels once the third cell begins.
  class Impatient final : public Monitor {
   public:
    void begin(const Phase& phase, std::uint64_t) override {
      if (phase.number == 3 && phase.count == 4) mCancelled = true;
    }
    bool cancelled() const override { return mCancelled; }

   private:
    std::atomic<bool> mCancelled{false};
  } impatient;
  const SheetOptions what = options({"alpha=20,30", "texture-seed=1,2"});
  EXPECT_THROW(makeSheet(what, mFolder.path() / "cells", impatient), Interrupted);
  EXPECT_EQ(finished().size(), 2U);
  const SheetPage page = make(what);
  EXPECT_EQ(page.reusedCells, 2U);
  EXPECT_EQ(page.picture, make(what, "elsewhere").picture);
}

}  // namespace
