// SPDX-License-Identifier: Apache-2.0
// What every registered map promises: its options have defaults that it takes, in words that stand for one thing.
#include "vdbtools/scene/fractal_options.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

namespace {

using namespace vdbtools;

Recipe defaultsOf(const MapDescriptor& map) {
  Recipe recipe{{"map", map.name()}};
  if (map.targetUse() == TargetUse::Needed) recipe["input"] = "a.obj";
  return completeRecipe(recipe, fractalOptionTable());
}

// Promise: Every map has the options, defaults ...
TEST(Maps, TakeTheirOwnDefaults) {
  for (const MapRegistry maps = builtInMaps(); const auto& map : maps.maps()) {
    SCOPED_TRACE(map->name());
    const FractalOptions options = parseFractalOptions(defaultsOf(*map));
    ASSERT_TRUE(options.map);
    EXPECT_EQ(options.map->shell() != nullptr, map->targetUse() == TargetUse::Needed);
    if (map->targetUse() == TargetUse::None) {
      EXPECT_TRUE(options.map->radius()) << "where is its set to be looked for?";
    }
    if (map->dimension() == 3) {
      EXPECT_EQ(options.map->embedding().slice, 0);
    }
    EXPECT_EQ(options.target.has_value(), map->targetUse() == TargetUse::Needed);
  }
}

TEST(Maps, SayWhatTheyAreInOneLine) {
  std::set<std::string> names;
  for (const MapRegistry maps = builtInMaps(); const auto& map : maps.maps()) {
    EXPECT_TRUE(names.insert(map->name()).second);
    EXPECT_FALSE(map->summary().empty());
    EXPECT_EQ(map->summary().find('\n'), std::string::npos);
    EXPECT_FALSE(map->proofs().empty());
    std::set<std::string> options;
    for (const OptionSpec& option : map->options()) {
      EXPECT_TRUE(options.insert(option.name).second) << option.name;
      EXPECT_FALSE(option.help.empty()) << option.name;
    }
    EXPECT_TRUE(options.contains("iterations")) << map->name();
  }
}

// An option that several maps have has one meaning: its text goes from one map to the next.
TEST(Maps, SharedOptionsAreTheSame) {
  std::map<std::string, OptionSpec> first;
  for (const MapRegistry maps = builtInMaps(); const auto& map : maps.maps())
    for (const OptionSpec& option : map->options()) {
      const auto [known, isNew] = first.emplace(option.name, option);
      if (isNew || option.followsSelector || option.alternative == "c") continue;
      EXPECT_EQ(known->second.help, option.help) << map->name() << " " << option.name;
      EXPECT_EQ(known->second.defaultValue, option.defaultValue) << map->name() << " " << option.name;
      EXPECT_EQ(known->second.argument, option.argument) << map->name() << " " << option.name;
      EXPECT_EQ(known->second.hash, option.hash) << map->name() << " " << option.name;
    }
}

TEST(Maps, HaveOneNameEach) {
  MapRegistry maps = builtInMaps();
  EXPECT_THROW(maps.add(maps.maps().front()), std::invalid_argument);
  EXPECT_EQ(maps.find("no-such-map"), nullptr);
}

}  // namespace
