// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/surface/surface_options.h"

#include <limits>

namespace vdbtools {

std::vector<OptionSpec> surfaceOptionSpecs() {
  return {
      {.name = "tolerance",
       .argument = "T",
       .defaultValue = "0.001",
       .help = "how close vertices lie to the true surface, in voxels"},
      {.name = "adaptivity",
       .argument = "E",
       .defaultValue = "0",
       .help = "make triangles of the mesh larger where the surface is flat: neither it nor the full mesh is anywhere "
               "farther than E voxels from the other, which is proved. The mesh is held in memory"},
      {.name = "largest",
       .argument = "N",
       .defaultValue = "0",
       .help = "keep only the N largest islands, by volume; 0 keeps all. With --box an island is the part of it inside "
               "the box"},
      {.name = "min-size",
       .argument = "W",
       .defaultValue = "0",
       .help = "drop islands whose longest side is below this, in the target's units"},
      {.name = "cap", .help = "close the mesh where the box cuts the set; the VDB is always closed"},
  };
}

SurfaceOptions parseSurfaceOptions(const RecipeReader& reader) {
  SurfaceOptions options;
  options.tolerance = reader.number("tolerance");
  if (!(options.tolerance >= 0x1p-40 && options.tolerance <= 0.5))
    reader.refuse("tolerance", "at least 1e-12 and at most 0.5");
  constexpr double kMostAdaptivity = 100;  // voxels
  options.adaptivity = reader.notNegative("adaptivity");
  if (options.adaptivity > kMostAdaptivity) reader.refuse("adaptivity", "a number of voxels from 0 to 100");
  options.islands.largest = reader.integer<std::uint64_t>("largest", 0, std::numeric_limits<std::uint64_t>::max());
  options.islands.minSize = reader.notNegative("min-size");
  options.cap = reader.flag("cap");
  return options;
}

}  // namespace vdbtools
