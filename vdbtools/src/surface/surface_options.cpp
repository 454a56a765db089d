// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/surface/surface_options.h"

#include "vdbtools/field/crumbs.h"

#include <limits>
#include <string>

namespace vdbtools {
namespace {

/// Without a box the default map ends by itself, while others end with their region.
std::string idleCap(const OptionRun& run) {
  const bool endsByItself = run.text("map") == "shape-modulus" && !run.recipe.contains("box");
  return endsByItself ? "it closes the mesh where a box cuts the set; give --box too, or leave it out" : "";
}

}  // namespace

std::vector<OptionSpec> surfaceOptionSpecs() {
  const IdleRule noMesh = idleWithout({Product::Mesh, Product::Stl, Product::Glb, Product::MeshCount}, "a mesh");
  const IdleRule noSurface = idleWithout({Product::Vdb, Product::Mesh, Product::Stl, Product::Glb, Product::MeshCount},
                                         "the surface in a VDB or a mesh");
  return {
      {.name = "tolerance",
       .argument = "T",
       .defaultValue = "0.001",
       .help = "how close vertices lie to the true surface, in voxels",
       .idle = noSurface},
      {.name = "adaptivity",
       .argument = "E",
       .defaultValue = "0",
       .help = "make triangles of the mesh larger where the surface is flat: neither it nor the full mesh is anywhere "
               "farther than E voxels from the other, which is proved. The mesh is held in memory",
       .idle = noMesh},
      {.name = "crumbs",
       .argument = "drop|keep|auto",
       .defaultValue = "auto",
       .help = "what happens to pieces of at most " + std::to_string(kCrumb) +
               " voxels along each axis that hold no part of the target of their own: there are hundreds of them, and "
               "they have less than a hundredth of the volume. auto drops those around a target that are no longer "
               "than 1/40 of it; sets without a target keep them",
       .idle = noSurface},
      {.name = "largest",
       .argument = "N",
       .defaultValue = "0",
       .help = "keep only the N largest islands, by volume; 0 keeps all. With --box an island is the part of it inside "
               "the box",
       .idle = noSurface},
      {.name = "min-size",
       .argument = "W",
       .defaultValue = "0",
       .help = "drop islands whose longest side is below this, in the target's units",
       .idle = noSurface},
      {.name = "cap",
       .help = "close the mesh where the box cuts the set; the VDB is always closed",
       .idle = idleByAny({noMesh, idleCap})},
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
  options.crumbs =
      reader.choice<Crumbs>("crumbs", {{"auto", Crumbs::Auto}, {"drop", Crumbs::Drop}, {"keep", Crumbs::Keep}});
  options.islands.largest = reader.integer<std::uint64_t>("largest", 0, std::numeric_limits<std::uint64_t>::max());
  options.islands.minSize = reader.notNegative("min-size");
  options.cap = reader.flag("cap");
  return options;
}

}  // namespace vdbtools
