// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/maps/map_registry.h"

#include "maps/built_in_maps.h"

#include <sstream>
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

namespace {

std::string escaped(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, 1, '\\');
  return text;
}

std::string targetText(TargetUse use) {
  switch (use) {
    case TargetUse::Needed: return "needs a target";
    case TargetUse::Optional: return "may have a target, around which it is then evaluated";
    case TargetUse::None: break;
  }
  return "has no target";
}

std::string defaultText(const OptionSpec& spec) {
  return spec.defaultNote.empty() ? spec.defaultValue.value_or("") : spec.defaultNote;
}

}  // namespace

std::string mapsPage(const MapRegistry& maps) {
  std::ostringstream page;
  page << "# The maps and their options\n\n"
          "This page lists the values of `--map` and the options that each map adds to those of `juliavdb fractal`.\n"
          "`juliavdb maps --markdown` writes it, and a test compares the two. The papers are in "
          "[references.md](references.md).\n";
  for (const MapRegistry::Descriptor& map : maps.maps()) {
    page << "\n## `--map " << map->name() << "`\n\n"
         << map->summary() << ".\n\nIt " << targetText(map->targetUse()) << ". It works on "
         << (map->dimension() == 3 ? "points of R^3" : "quaternions")
         << (map->hasRoots() ? ", with the texture of its roots" : "") << ". " << map->proofs() << "\n\n"
         << "| option | default | meaning |\n|---|---|---|\n";
    for (const OptionSpec& spec : map->options()) {
      page << "| `--" << spec.name;
      if (!spec.argument.empty()) page << ' ' << escaped(spec.argument);
      page << "` | ";
      const char* quote = spec.defaultNote.empty() ? "`" : "";
      if (const std::string usual = defaultText(spec); !usual.empty()) page << quote << usual << quote;
      page << " | " << escaped(spec.help) << " |\n";
    }
  }
  return page.str();
}

}  // namespace vdbtools
