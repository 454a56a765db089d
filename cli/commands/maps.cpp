// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"

#include "vdbtools/maps/map_registry.h"
#include "vdbtools/scene/fractal_options.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <iomanip>
#include <iostream>
#include <stdexcept>

namespace cli {
namespace {

constexpr Usage kMapsUsage = {
    "maps", "[--markdown | --json]",
    "Lists the maps that 'juliavdb fractal --map' iterates. --markdown writes them with their options, as in "
    "docs/maps.md. --json writes, for other programs, the names of the maps and the options of a recipe.",
    "  juliavdb maps\n"
    "  juliavdb maps --markdown\n"};

/// A recipe describes a fractal and not where its files go, so none of its options makes a program write.
nlohmann::json recipeData(const vdbtools::MapRegistry& maps) {
  nlohmann::json data{{"maps", nlohmann::json::array()}, {"options", nlohmann::json::array()}};
  for (const auto& map : maps.maps()) data["maps"].push_back(map->name());
  for (const vdbtools::OptionListing& option : vdbtools::fractalOptionTable().listing())
    data["options"].push_back({{"name", option.name}, {"argument", option.argument}, {"help", option.help}});
  return data;
}

}  // namespace

int runMaps(const Arguments& arguments) {
  CommandLine line(kMapsUsage, vdbtools::OptionTable());
  line.addOptions()("markdown", "a page with the options of each map")(
      "json",
      "the names of the maps, and of each option of a recipe its name, what its value is called (nothing for a "
      "flag) and its help");
  if (!line.parse(arguments)) return kDone;
  const vdbtools::MapRegistry maps = vdbtools::builtInMaps();
  if (line.has("markdown") && line.has("json")) throw std::invalid_argument("--markdown and --json exclude each other");
  if (line.has("json")) {
    std::cout << recipeData(maps).dump(1) << '\n';
    return kDone;
  }
  if (line.has("markdown")) {
    std::cout << vdbtools::mapsPage(maps);
    return kDone;
  }
  std::size_t width = 0;
  for (const auto& map : maps.maps()) width = std::max(width, map->name().size());
  for (const auto& map : maps.maps())
    std::cout << std::left << std::setw(static_cast<int>(width) + 2) << map->name() << map->summary() << '\n';
  return kDone;
}

}  // namespace cli
