// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/maps/map_registry.h"

#include <sstream>

namespace vdbtools {
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
