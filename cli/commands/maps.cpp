// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"

#include "vdbtools/maps/map_registry.h"

#include <algorithm>
#include <iomanip>
#include <iostream>

namespace cli {
namespace {

constexpr Usage kMapsUsage = {
    "maps", "[--markdown]",
    "Lists the maps that 'juliavdb fractal --map' iterates. --markdown writes them with their "
    "options, as in docs/maps.md.",
    "  juliavdb maps\n"
    "  juliavdb maps --markdown\n"};

}  // namespace

int runMaps(const Arguments& arguments) {
  CommandLine line(kMapsUsage, vdbtools::OptionTable());
  line.addOptions()("markdown", "a page with the options of each map");
  if (!line.parse(arguments)) return kDone;
  const vdbtools::MapRegistry maps = vdbtools::builtInMaps();
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
