// SPDX-License-Identifier: Apache-2.0
// Recipes of earlier versions are read: each of their names leads to today's.
#include "vdbtools/recipe/recipe.h"

#include "vdbtools/scene/fractal_options.h"

#include <gtest/gtest.h>

#include <set>

namespace vdbtools {
namespace {

TEST(OptionName, FormerNamesLeadToTodays) {
  std::set<std::string> former;
  for (const std::string& name : fractalOptionTable().names()) {
    EXPECT_EQ(currentName(name), name);
    EXPECT_EQ(currentName(formerName(name)), name);
    EXPECT_TRUE(former.insert(formerName(name)).second) << formerName(name) << " stands for two options";
  }
  EXPECT_TRUE(former.contains("versor-seed"));
}

TEST(OptionName, OnlyTheWholeFirstWordIsRenamed) {
  EXPECT_EQ(currentName("versors"), "versors");
  EXPECT_EQ(formerName("textured-x"), "textured-x");
  EXPECT_EQ(currentName("over-versor"), "over-versor");
}

TEST(OptionName, MetadataOfEarlierVersionsAreRead) {
  const OptionTable table = fractalOptionTable();
  const Recipe recipe = completeRecipe({{"input", "a.obj"},
                                        {"source-sha256", "0"},
                                        {"texture", "roots.json"},
                                        {"texture-sha256", "1"},
                                        {"texture-symmetry", "3:y"}},
                                       table);
  Recipe old;
  for (const auto& [name, value] : recipe) old.emplace(formerName(name), value);
  EXPECT_NE(old, recipe);
  EXPECT_EQ(recipeFromMetadata(recipeToMetadata(old, "fractal"), table), recipe);
  EXPECT_EQ(recipeFromMetadata(recipeToMetadata(recipe, "fractal"), table), recipe);
}

}  // namespace
}  // namespace vdbtools
