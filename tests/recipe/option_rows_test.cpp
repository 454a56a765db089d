// SPDX-License-Identifier: Apache-2.0
// Rows of options: the defaults are those of the struct, and each value reaches its member or is refused by name.
#include "recipe/option_rows.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

using namespace vdbtools;

namespace {

enum class Colour { Red, Green };

struct Inner {
  double depth = 0.25;
};

struct Settings {
  bool loud = false;
  double size = 5e-5;
  std::optional<double> limit;
  std::uint64_t count = 7;
  Colour colour = Colour::Green;
  std::vector<Colour> colours{Colour::Green, Colour::Red};
  openvdb::Vec3d at{1, -0.5, 0};
  std::string name = "bunny";
  Inner inner;
};

const OptionRows<Settings>& settingsRows() {
  const Choices<Colour> colours = {{"red", Colour::Red}, {"green", Colour::Green}};
  static const OptionRows<Settings> rows{
      {{.name = "loud"}, flag(&Settings::loud)},
      {{.name = "size", .argument = "S"}, number(&Settings::size, above(0, 2))},
      {{.name = "limit", .argument = "L"}, number(&Settings::limit, atLeast(1))},
      {{.name = "count", .argument = "N"}, whole(&Settings::count, std::uint64_t{1}, std::uint64_t{9})},
      {{.name = "colour"}, choice(&Settings::colour, colours)},
      {{.name = "colours", .argument = "LIST"}, list(&Settings::colours, colours)},
      {{.name = "at", .argument = "X,Y,Z"}, vector(&Settings::at)},
      {{.name = "name", .argument = "NAME"}, text(&Settings::name)},
      {{.name = "depth", .argument = "D"},
       withoutDefault(number(
           [](auto& settings) -> auto& { return settings.inner.depth; }, between(0, 1)))}};
  return rows;
}

Settings parsedSettings(const Recipe& recipe) {
  const OptionTable table(settingsRows().specs());
  Settings settings;
  settingsRows().read(RecipeReader(recipe, table), settings);
  return settings;
}

/// What is said of a recipe that is refused; "" if it is not.
std::string refusalOf(const Recipe& recipe) {
  try {
    parsedSettings(recipe);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

TEST(OptionRows, DefaultsAreThoseOfTheStruct) {
  const Recipe complete = completeRecipe({}, OptionTable(settingsRows().specs()));
  EXPECT_EQ(complete, (Recipe{{"size", "5e-5"},
                              {"count", "7"},
                              {"colour", "green"},
                              {"colours", "green,red"},
                              {"at", "1,-0.5,0"},
                              {"name", "bunny"}}));
  for (const Recipe& recipe : {Recipe{}, complete}) {
    const Settings settings = parsedSettings(recipe), usual;
    EXPECT_EQ(settings.loud, usual.loud);
    EXPECT_EQ(settings.size, usual.size);
    EXPECT_EQ(settings.limit, usual.limit);
    EXPECT_EQ(settings.count, usual.count);
    EXPECT_EQ(settings.colour, usual.colour);
    EXPECT_EQ(settings.colours, usual.colours);
    EXPECT_EQ(settings.at, usual.at);
    EXPECT_EQ(settings.name, usual.name);
    EXPECT_EQ(settings.inner.depth, usual.inner.depth);
  }
}

TEST(OptionRows, EachValueReachesItsMember) {
  EXPECT_TRUE(parsedSettings({{"loud", "true"}}).loud);
  EXPECT_EQ(parsedSettings({{"size", "2"}}).size, 2);
  EXPECT_EQ(parsedSettings({{"limit", "1"}}).limit, 1);
  EXPECT_EQ(parsedSettings({{"count", "9"}}).count, 9u);
  EXPECT_EQ(parsedSettings({{"colour", "red"}}).colour, Colour::Red);
  EXPECT_EQ(parsedSettings({{"colours", "red"}}).colours, std::vector{Colour::Red});
  EXPECT_EQ(parsedSettings({{"at", "3,4,5"}}).at, openvdb::Vec3d(3, 4, 5));
  EXPECT_EQ(parsedSettings({{"name", "horse"}}).name, "horse");
  EXPECT_EQ(parsedSettings({{"depth", "0.5"}}).inner.depth, 0.5);
}

TEST(OptionRows, OtherValuesAreRefusedByName) {
  const std::vector<std::pair<Recipe, std::string>> bad = {
      {{{"loud", "yes"}}, "--loud is 'yes'; it must be true or false"},
      {{{"size", "0"}}, "--size is '0'; it must be above 0 and at most 2"},
      {{{"size", "2.5"}}, "--size is '2.5'; it must be above 0 and at most 2"},
      {{{"limit", "0.5"}}, "--limit is '0.5'; it must be 1 or more"},
      {{{"count", "0"}}, "--count is '0'; it must be a whole number from 1 to 9"},
      {{{"colour", "gren"}}, "--colour is 'gren'; it must be one of red, green; did you mean 'green'?"},
      {{{"colours", "red,red"}}, "--colours is 'red,red'; it must be a list in which no name occurs twice"},
      {{{"colours", "red,"}}, "--colours is 'red,'; it must be a list of red, green"},
      {{{"at", "1,2"}}, "--at is '1,2'; it must be 3 finite numbers with commas between them"},
      {{{"depth", "1"}}, "--depth is '1'; it must be above 0 and below 1"}};
  for (const auto& [recipe, message] : bad) EXPECT_EQ(refusalOf(recipe), message);
}

TEST(OptionRows, TheHelpShowsTheWordsOfAChoice) {
  for (const OptionSpec& spec : settingsRows().specs()) {
    if (spec.name == "colour") {
      EXPECT_EQ(spec.argument, "red|green");
    }
    EXPECT_EQ(spec.argument.empty(), spec.type.kind == OptionType::Kind::Flag) << spec.name;
  }
}

TEST(OptionRows, NumbersAreWrittenAsPeopleDo) {
  EXPECT_EQ(numberText(1e-9), "1e-9");
  EXPECT_EQ(numberText(1e9), "1e9");
  EXPECT_EQ(numberText(1e-12), "1e-12");
  EXPECT_EQ(numberText(1e20), "1e20");
  EXPECT_EQ(numberText(0.3), "0.3");
}

}  // namespace
