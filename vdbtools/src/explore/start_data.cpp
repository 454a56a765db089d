// SPDX-License-Identifier: Apache-2.0
#include "explore/start_data.h"

#include "explore/look_data.h"
#include "vdbtools/explore/embedded_page.h"
#include "vdbtools/formats/file_formats.h"
#include "vdbtools/maps/texture_shelf.h"
#include "vdbtools/recipe/option_table.h"
#include "vdbtools/scene/fractal_options.h"

#include <algorithm>
#include <string>

namespace vdbtools::explore {
namespace {

using nlohmann::json;

bool names(const std::vector<OptionSpec>& options, const std::string& name) {
  return std::any_of(options.begin(), options.end(), [&](const OptionSpec& option) { return option.name == name; });
}

/// The part of a scene to which an option belongs.
std::string groupOf(const std::string& name, const MapRegistry& maps) {
  if (names(targetOptionSpecs(), name)) return "target";
  if (name == "map") return "map";
  if (names(spaceOptionSpecs(), name)) return "space";
  if (names(latticeOptionSpecs(), name)) return "lattice";
  if (names(surfaceOptionSpecs(), name)) return "surface";
  for (const MapRegistry::Descriptor& map : maps.maps())
    if (names(map->options(), name)) return "map";
  return "output";
}

json fractalOptionData(const MapRegistry& maps) {
  json all = json::parse(optionData(fractalOptionTable(maps)));
  for (json& option : all) option["group"] = groupOf(option["name"], maps);
  return all;
}

json textureData() {
  json textures = json::array();
  for (const Texture& texture : textureShelf()) {
    json data = {{"name", texture.name},
                 {"description", texture.description},
                 {"varies", texture.varies()},
                 {"followsThickness", texture.followsThickness()}};
    for (const char* extension : {".jpg", ".png"})
      if (const PageFile* file = findPageFile("texture-" + texture.name + extension))
        data["thumbnail"] = "page/" + std::string(file->name);
    textures.push_back(std::move(data));
  }
  return textures;
}

json mapData(const MapRegistry& maps) {
  json all = json::array();
  for (const MapRegistry::Descriptor& map : maps.maps()) {
    const TargetUse use = map->targetUse();
    all.push_back({{"name", map->name()},
                   {"summary", map->summary()},
                   {"target", use == TargetUse::Needed     ? "needed"
                              : use == TargetUse::Optional ? "optional"
                                                           : "none"},
                   {"roots", map->hasRoots()},
                   {"dimension", map->dimension()}});
  }
  return all;
}

}  // namespace

json programData() {
  const MapRegistry maps = builtInMaps();
  return {{"version", JULIAVDB_VERSION},
          {"options", fractalOptionData(maps)},
          {"maps", mapData(maps)},
          {"textures", textureData()},
          {"colours", {"clay", "trap", "depth", "iterations", "direction", "versor"}},
          {"gradients", gradientData()},
          {"materials", materialData()},
          {"looks", lookOptionData()},
          {"resolutions", {60, 100, 150, 200, 300, 400, 600, 800}},
          {"formats", writtenFormats()}};
}

}  // namespace vdbtools::explore
