// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/maps/map_registry.h"

#include "maps/built_in_maps.h"

#include <stdexcept>

namespace vdbtools {

std::shared_ptr<const MapInstance> MapInstance::reseeded(std::uint64_t) const {
  throw std::logic_error("a map without random roots was asked for those of another seed");
}

void MapRegistry::add(Descriptor map) {
  if (find(map->name())) throw std::invalid_argument("there is a map called '" + map->name() + "' already");
  mMaps.push_back(std::move(map));
}

const MapDescriptor* MapRegistry::find(const std::string& name) const {
  for (const Descriptor& map : mMaps)
    if (map->name() == name) return map.get();
  return nullptr;
}

OptionSpec MapRegistry::option() const {
  std::string names;
  for (const Descriptor& map : mMaps) {
    if (!names.empty()) names += '|';
    names += map->name();
  }
  return {.name = "map",
          .argument = names,
          .defaultValue = mMaps.empty() ? std::string() : mMaps.front()->name(),
          .help = "the map that is iterated"};
}

std::vector<OptionVariant> MapRegistry::variants() const {
  std::vector<OptionVariant> variants;
  for (const Descriptor& map : mMaps) {
    OptionVariant variant{.name = map->name(), .options = map->options()};
    if (map->targetUse() == TargetUse::None) variant.excludes = {"input"};
    variants.push_back(std::move(variant));
  }
  return variants;
}

MapRegistry builtInMaps(const VersorFunction& function) {
  MapRegistry maps;
  for (const auto& map : {shapeModulusMap(function), rationalMap(), quadraticMap(), crossMap(), mandelbulbMap()})
    maps.add(map);
  return maps;
}

}  // namespace vdbtools
