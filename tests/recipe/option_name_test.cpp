// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/recipe/option_name.h"

#include "vdbtools/recipe/recipe.h"
#include "vdbtools/scene/fractal_options.h"

#include <gtest/gtest.h>

#include <set>

namespace vdbtools {
namespace {

TEST(OptionName, EachEntryHasOneOptionAndBothNamesLeadBackToIt) {
  std::set<std::string> options;
  for (const std::string& entry : fractalOptionTable().names()) {
    const std::string option = optionName(entry);
    EXPECT_TRUE(options.insert(option).second) << option << " stands for two entries";
    EXPECT_EQ(recipeEntry(option), entry);
    EXPECT_EQ(recipeEntry(entry), entry);
  }
  EXPECT_TRUE(options.contains("texture-seed"));
}

TEST(OptionName, OnlyTheWholeFirstWordIsRenamed) {
  EXPECT_EQ(optionName("versors"), "versors");
  EXPECT_EQ(recipeEntry("textured-x"), "textured-x");
  EXPECT_EQ(optionName("over-versor"), "over-versor");
}

}  // namespace
}  // namespace vdbtools
