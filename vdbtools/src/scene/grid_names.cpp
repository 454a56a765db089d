// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/scene/attribute_options.h"

#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/recipe/option_value.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace vdbtools {
namespace {

constexpr const char* kGridNames = "grid-names";

struct Naming {
  const char* program;
  std::vector<std::pair<const char*, const char*>> names;
};

/// The names in the documentation of the programs (docs/handoff.md). All of them call densities "density".
const std::vector<Naming>& namings() {
  static const std::vector<Naming> all = {{"houdini", {{"phi", "surface"}, {"velocity", "v"}}},
                                          {"blender", {{"phi", "surface"}, {"Cd", "color"}}},
                                          {"unreal", {{"phi", "surface"}, {"Cd", "color"}}},
                                          {"arnold", {{"phi", "surface"}, {"Cd", "color"}}}};
  return all;
}

bool isGridName(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.';
  });
}

void addPair(const std::string& text, const std::string& pair, std::span<const std::string> grids, GridNames& names) {
  const std::size_t equals = pair.find('=');
  const std::string own = pair.substr(0, equals), name = pair.substr(equals + 1);
  if (std::find(grids.begin(), grids.end(), own) == grids.end())
    throw std::invalid_argument("--grid-names is '" + text + "', but there is no grid '" + own + "' here; there are " +
                                joined(grids));
  if (!isGridName(name)) refuse(kGridNames, text, "a list of names that consist of letters, digits, '_' and '.'");
  names[own] = name;
}

/// The own name of the grid that one of the programs calls @a name, where others call it otherwise; empty if there is
/// none.
std::string ownNameOf(const std::string& name) {
  // Every program calls the distances so.
  if (name == "surface") return {};
  for (const Naming& naming : namings())
    for (const auto& [own, other] : naming.names)
      if (name == other) return own;
  return {};
}

/// The names that a program gives to grids, some of which another program may have named.
void addNaming(const Naming& naming, std::span<const std::string> grids, bool ofOthers, GridNames& names) {
  const auto isThere = [&](const std::string& name) {
    return std::find(grids.begin(), grids.end(), name) != grids.end();
  };
  for (const auto& [own, name] : naming.names)
    if (isThere(own)) names[own] = name;
  if (!ofOthers) return;
  for (const std::string& grid : grids) {
    const std::string own = ownNameOf(grid);
    if (own.empty() || isThere(own)) continue;
    const auto named =
        std::find_if(naming.names.begin(), naming.names.end(), [&](const auto& pair) { return pair.first == own; });
    const std::string name = named == naming.names.end() ? own : named->second;
    if (name != grid) names[grid] = name;
  }
}

void requireDistinct(const std::string& text, std::span<const std::string> grids, const GridNames& names) {
  std::map<std::string, std::string> taken;
  for (const std::string& own : grids) {
    const auto found = names.find(own);
    const std::string& name = found == names.end() ? own : found->second;
    const auto [other, isNew] = taken.emplace(name, own);
    if (!isNew)
      throw std::invalid_argument("--grid-names is '" + text + "', which calls both the grid '" + other->second +
                                  "' and the grid '" + own + "' '" + name + "'; give one of them another name");
  }
}

}  // namespace

OptionSpec gridNamesOption() {
  return {.name = kGridNames,
          .argument = "houdini|blender|unreal|arnold|NAME=NEW,...",
          .help =
              "the names of the grids as the volume shader of a program finds them, or single ones, such as "
              "trap=temperature, or both, as in blender,trap=temperature",
          .defaultNote = "the names of --grids and --attributes"};
}

GridNames parseGridNames(const std::string& text, std::span<const std::string> grids, bool ofOthers) {
  if (text.empty()) return {};
  GridNames names;
  bool isFirst = true;
  for (const std::string& part : split(text, ',')) {
    if (part.find('=') != std::string::npos) {
      addPair(text, part, grids, names);
    } else {
      const auto naming =
          std::find_if(namings().begin(), namings().end(), [&](const Naming& known) { return known.program == part; });
      if (naming == namings().end() || !isFirst)
        refuse(kGridNames, text,
               "houdini, blender, unreal, arnold, or pairs NAME=NEW, behind the program if there is one");
      addNaming(*naming, grids, ofOthers, names);
    }
    isFirst = false;
  }
  requireDistinct(text, grids, names);
  return names;
}

std::map<std::string, std::string> distanceGridMetadata(const GridNames& names, const std::string& own) {
  const auto found = names.find(own);
  if (found == names.end()) return {};
  return {{kDistanceGrid, found->second}};
}

}  // namespace vdbtools
