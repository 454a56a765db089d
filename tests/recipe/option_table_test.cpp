// SPDX-License-Identifier: Apache-2.0
// Tables of options with a selector: which recipes fit, what is completed, what one option does to another.
#include "vdbtools/recipe/recipe_reader.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace {

using namespace vdbtools;

OptionTable tableOfShapes() {
  return OptionTable(
      {{.name = "input", .argument = "FILE", .hash = "input-sha256"},
       {.name = "shape", .argument = "ball|box", .defaultValue = "ball", .help = "the shape"},
       {.name = "size", .argument = "S", .defaultValue = "1", .alternative = "width"},
       {.name = "width", .argument = "W", .alternative = "size"}},
      "shape",
      {{.name = "ball",
        .options =
            {{.name = "radius", .argument = "R", .defaultValue = "2", .help = "from the middle"},
             {.name = "steps", .argument = "N", .defaultValue = "3", .help = "how many", .followsSelector = true}}},
       {.name = "box",
        .options =
            {{.name = "sides", .argument = "A,B,C", .help = "its sides", .kept = true},
             {.name = "steps", .argument = "N", .defaultValue = "10", .help = "how many", .followsSelector = true},
             {.name = "style",
              .argument = "sharp|round",
              .defaultValue = "sharp",
              .help = "of its edges",
              .qualifies = {"bevel"}},
             {.name = "bevel",
              .argument = "W",
              .help = "width of the round edge",
              .defaultFor = [](const Recipe& recipe) -> std::optional<std::string> {
                const auto style = recipe.find("style");
                if (style == recipe.end() || style->second != "round") return std::nullopt;
                return "0.1";
              },
              .defaultNote = "0.1 with --style round"}},
        .excludes = {"input"}}});
}

std::string refusal(const Recipe& recipe) {
  try {
    const OptionTable options = tableOfShapes();
    RecipeReader(recipe, options);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

bool holds(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

TEST(OptionTable, CompletesByTheVariantAndOnce) {
  EXPECT_EQ(completeRecipe({}, tableOfShapes()),
            (Recipe{{"shape", "ball"}, {"size", "1"}, {"radius", "2"}, {"steps", "3"}}));
  EXPECT_EQ(completeRecipe({{"shape", "box"}, {"width", "4"}}, tableOfShapes()),
            (Recipe{{"shape", "box"}, {"width", "4"}, {"steps", "10"}, {"style", "sharp"}}));
  const Recipe round = completeRecipe({{"shape", "box"}, {"style", "round"}}, tableOfShapes());
  EXPECT_EQ(round.at("bevel"), "0.1");
  EXPECT_EQ(completeRecipe(round, tableOfShapes()), round);
}

TEST(OptionTable, RefusesWhatDoesNotApplyAndSaysWhy) {
  EXPECT_EQ(refusal({{"shape", "ball"}, {"radius", "3"}}), "");
  EXPECT_EQ(refusal({{"shape", "ball"}, {"sides", "1,2,3"}}), "") << "a kept option goes with every variant";
  EXPECT_EQ(refusal({{"shape", "ball"}, {"input-sha256", "00"}}), "");
  EXPECT_TRUE(holds(refusal({{"shape", "box"}, {"radius", "3"}}), "--radius does not apply to --shape box"));
  EXPECT_TRUE(holds(refusal({{"shape", "box"}, {"input", "a.obj"}}), "'a.obj'"));
  EXPECT_TRUE(holds(refusal({{"shape", "cone"}}), "ball, box"));
  EXPECT_TRUE(holds(refusal({{"colour", "red"}}), "--colour is not an option of this command"));
}

TEST(OptionTable, OverridingDisplacesWhatLostItsMeaning) {
  const Recipe box = completeRecipe({{"shape", "box"}, {"style", "round"}, {"sides", "1,2,3"}}, tableOfShapes());
  const auto over = [&](const Recipe& base, const Recipe& given) {
    return completeRecipe(overridden(base, given, tableOfShapes()), tableOfShapes());
  };
  EXPECT_FALSE(over(box, {{"style", "sharp"}}).contains("bevel"));
  EXPECT_EQ(over(box, {{"style", "round"}}), box) << "the same value changes nothing";
  EXPECT_FALSE(over(box, {{"width", "3"}}).contains("size"));
  const Recipe ball = over(box, {{"shape", "ball"}});
  EXPECT_EQ(ball, (Recipe{{"shape", "ball"}, {"size", "1"}, {"radius", "2"}, {"steps", "3"}, {"sides", "1,2,3"}}));
  EXPECT_EQ(over(box, {{"shape", "ball"}, {"steps", "5"}}).at("steps"), "5");
  // Another file, another hash; and none where there is no file.
  const Recipe file{{"shape", "ball"}, {"input", "a"}, {"input-sha256", "00"}};
  EXPECT_FALSE(over(file, {{"input", "b"}}).contains("input-sha256"));
  EXPECT_FALSE(over(file, {{"shape", "box"}}).contains("input-sha256"));
  EXPECT_TRUE(over(file, {{"radius", "9"}}).contains("input-sha256"));
}

TEST(OptionTable, ListsEveryOptionOnceWithWhoHasIt) {
  const auto listing = tableOfShapes().listing();
  const auto help = [&](const char* name) {
    const auto found =
        std::find_if(listing.begin(), listing.end(), [&](const auto& each) { return each.name == name; });
    return found == listing.end() ? std::string("none") : found->help;
  };
  EXPECT_EQ(listing.size(), tableOfShapes().names().size());
  EXPECT_EQ(help("radius"), "from the middle (default 2)");
  EXPECT_EQ(help("sides"), "box: its sides");
  EXPECT_EQ(help("steps"), "how many (default 3; box: 10)");
  EXPECT_EQ(help("bevel"), "box: width of the round edge (default 0.1 with --style round)");
}

TEST(OptionTable, TheSelectorMustSelect) {
  EXPECT_THROW(OptionTable({{.name = "shape", .defaultValue = "cone"}}, "shape", {{.name = "ball"}}),
               std::invalid_argument);
  EXPECT_THROW(OptionTable({{.name = "shape", .defaultValue = "ball"}}, "shape", {{.name = "ball"}, {.name = "ball"}}),
               std::invalid_argument);
}

/// Options that go with a mesh, with a flag, and with a variant.
OptionTable tableOfEffects() {
  return OptionTable(
      {{.name = "shape", .argument = "ball|box", .defaultValue = "ball"},
       {.name = "fast"},
       {.name = "stride", .argument = "N", .defaultValue = "8", .idle = idleWithoutFlag("fast")},
       {.name = "cap", .idle = idleWithout({Product::Mesh, Product::Stl}, "a mesh")},
       {.name = "both", .idle = idleByAny({idleWithoutFlag("fast"), idleWithout({Product::Mesh}, "a mesh")})}},
      "shape", {{.name = "ball"}, {.name = "box", .options = {{.name = "sides", .argument = "A", .kept = true}}}});
}

std::string refusal(const std::set<std::string>& given, const std::vector<OptionRun>& runs) {
  const OptionTable table = tableOfEffects();
  RequiredEffects effects(table, given);
  for (const OptionRun& run : runs) effects.add({completeRecipe(run.recipe, table), run.makes});
  try {
    effects.require();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

// Promise: "Where an option can do nothing", an option ...
TEST(OptionTable, WhatWasGivenHasAnEffectInOneOfTheRunsAtLeast) {
  const OptionRun vdb{{}, {Product::Vdb}}, mesh{{}, {Product::Mesh}}, fast{{{"fast", "true"}}, {Product::Vdb}};
  EXPECT_EQ(refusal({}, {vdb}), "");
  EXPECT_EQ(refusal({"shape", "fast"}, {vdb}), "");
  EXPECT_NE(refusal({"cap"}, {vdb}).find("--cap has no effect: "), std::string::npos);
  EXPECT_NE(refusal({"cap"}, {vdb}).find("a mesh"), std::string::npos);
  EXPECT_EQ(refusal({"cap"}, {mesh}), "");
  EXPECT_EQ(refusal({"cap"}, {vdb, mesh}), "");
  EXPECT_EQ(refusal({"cap"}, {{{}, {Product::Recipe}}}), "");
  EXPECT_NE(refusal({"stride"}, {vdb}).find("--fast"), std::string::npos);
  EXPECT_EQ(refusal({"stride"}, {vdb, fast}), "");
  // Each of two options may act in a run of its own, but no option in parts of two.
  EXPECT_EQ(refusal({"stride", "cap"}, {fast, mesh}), "");
  EXPECT_NE(refusal({"both"}, {fast, mesh}), "");
  EXPECT_NE(refusal({"stride", "both"}, {fast}).find("--both"), std::string::npos);
}

// Promise: "Where an option can do nothing", an option ...
TEST(OptionTable, AnOptionThatIsKeptForAnotherVariantHasNoEffect) {
  const OptionRun ball{{{"sides", "3"}}, {Product::Mesh}}, box{{{"shape", "box"}, {"sides", "3"}}, {Product::Mesh}};
  EXPECT_NO_THROW(tableOfEffects().requireFits(ball.recipe));
  for (const char* part : {"--sides has no effect: ", "--shape box", "--shape is ball"})
    EXPECT_NE(refusal({"sides"}, {ball}).find(part), std::string::npos) << refusal({"sides"}, {ball});
  EXPECT_EQ(refusal({"sides"}, {box}), "");
}

}  // namespace
