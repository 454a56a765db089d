// SPDX-License-Identifier: Apache-2.0
// What the program tells others of its options, against what a recipe gets.
#include "vdbtools/recipe/option_table.h"

#include "vdbtools/base/text.h"
#include "vdbtools/scene/fractal_options.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <optional>
#include <string>

namespace {

using namespace vdbtools;
using nlohmann::json;

TEST(OptionData, HasEveryOptionOfTheListingInItsOrder) {
  const OptionTable table = fractalOptionTable();
  const json all = json::parse(optionData(table));
  const std::vector<OptionListing> listing = table.listing();
  ASSERT_EQ(all.size(), listing.size());
  for (std::size_t i = 0; i < listing.size(); ++i) {
    EXPECT_EQ(all[i]["name"], listing[i].name);
    EXPECT_EQ(all[i]["argument"], listing[i].argument);
    EXPECT_EQ(all[i]["help"], listing[i].help);
  }
}

TEST(OptionData, DefaultsAreThoseThatARecipeGets) {
  const OptionTable table = fractalOptionTable();
  const json all = json::parse(optionData(table));
  for (const OptionVariant& map : table.variants()) {
    Recipe given{{"map", map.name}};
    if (table.find("input", given)) given["input"] = "a.obj";
    Recipe recipe = completeRecipe(given, table);
    recipe.erase("input");
    for (const json& option : all) {
      const std::string entry = option["name"];
      const bool hasIt = std::find(option["maps"].begin(), option["maps"].end(), map.name) != option["maps"].end();
      const auto value = option["defaults"].find(map.name);
      if (recipe.contains(entry) && hasIt) {
        ASSERT_NE(value, option["defaults"].end()) << entry;
        EXPECT_EQ(*value, recipe[entry]) << entry;
      }
      EXPECT_LE(value != option["defaults"].end(), hasIt) << entry << " has a default for a map that lacks it";
    }
  }
}

TEST(OptionData, ADefaultIsOfItsOptionsType) {
  const json all = json::parse(optionData(fractalOptionTable()));
  for (const json& option : all) {
    const json& type = option["type"];
    const std::string kind = type["kind"];
    EXPECT_EQ(kind == "flag", option["argument"] == "") << option["name"];
    if (!option.contains("default")) continue;
    const std::string value = option["default"];
    const json words = type.value("words", json::array());
    const bool isWord = std::find(words.begin(), words.end(), json(value)) != words.end();
    EXPECT_TRUE(isWord || kind != "choice") << option["name"];
    if (kind != "number" && kind != "whole" && kind != "control") continue;
    const std::optional<double> number = numberFromText(value);
    EXPECT_TRUE(isWord || number) << option["name"];
    if (!number) continue;
    EXPECT_GE(*number, type.value("low", *number)) << option["name"];
    EXPECT_LE(*number, type.value("high", *number)) << option["name"];
  }
}

TEST(OptionData, OfATableWithoutVariantsSaysNothingOfMaps) {
  const OptionTable table({{.name = "seed", .argument = "N", .defaultValue = "1", .help = "a number"},
                           {.name = "force", .help = "a flag"}});
  const json all = json::parse(optionData(table));
  EXPECT_EQ(all[0]["default"], "1");
  EXPECT_EQ(all[1]["argument"], "");
  for (const json& option : all)
    for (const char* key : {"maps", "defaults"}) EXPECT_FALSE(option.contains(key));
  EXPECT_FALSE(all[1].contains("default"));
}

}  // namespace
