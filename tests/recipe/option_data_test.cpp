// SPDX-License-Identifier: Apache-2.0
// What the program tells others of its options, against what a recipe gets.
#include "vdbtools/recipe/option_data.h"

#include "vdbtools/scene/fractal_options.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
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
    EXPECT_EQ(all[i]["entry"], listing[i].name);
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
      const std::string entry = option["entry"];
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
