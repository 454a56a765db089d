// SPDX-License-Identifier: Apache-2.0
#include "option_groups.h"

#include "vdbtools/field/lattice_options.h"
#include "vdbtools/maps/map_options.h"
#include "vdbtools/maps/map_registry.h"
#include "vdbtools/maps/versor_options.h"
#include "vdbtools/motion/motion_options.h"
#include "vdbtools/surface/surface_options.h"
#include "vdbtools/target/space_options.h"
#include "vdbtools/target/target_input.h"

#include <algorithm>
#include <iterator>

namespace cli {
namespace {

constexpr const char* kBasics[] = {"detail", "texture", "texture-seed", "resolution"};

}  // namespace

OptionGroups::OptionGroups(const vdbtools::OptionTable& table) : mOthers("What to make") {
  if (!table.knows("origin")) return;
  mOthers = "Output";
  // An option belongs to the first group that names it.
  const auto add = [this](const char* heading, const std::vector<vdbtools::OptionSpec>& options) {
    for (const vdbtools::OptionSpec& option : options) mHeadings.emplace(option.name, heading);
  };
  add("Target", vdbtools::targetOptionSpecs());
  add("Motion", vdbtools::restOptionSpecs());
  add("Motion", vdbtools::velocityOptionSpecs());
  add("Detail", vdbtools::shellOptions());
  add("Texture", vdbtools::rootsOptions());
  add("Texture", {vdbtools::frequencyOption()});
  add("Texture", vdbtools::layerOptions());
  add("Space", vdbtools::spaceOptionSpecs());
  add("Lattice", vdbtools::latticeOptionSpecs());
  add("Surface", vdbtools::surfaceOptionSpecs());
  const vdbtools::MapRegistry maps = vdbtools::builtInMaps();
  add("Map", {maps.option()});
  for (const vdbtools::OptionVariant& map : maps.variants()) add("Map", map.options);
}

std::string OptionGroups::headingOf(const std::string& option) const {
  const auto found = mHeadings.find(option);
  return found == mHeadings.end() ? mOthers : found->second;
}

bool isBasic(const std::string& option) {
  return std::find(std::begin(kBasics), std::end(kBasics), option) != std::end(kBasics);
}

}  // namespace cli
