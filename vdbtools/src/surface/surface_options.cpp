// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/surface/surface_options.h"

#include "recipe/option_rows.h"
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

const OptionRows<SurfaceOptions>& surfaceRows() {
  const IdleRule noMesh = idleWithout({Product::Mesh, Product::Stl, Product::Glb, Product::MeshCount}, "a mesh");
  const IdleRule noSurface = idleWithout({Product::Vdb, Product::Mesh, Product::Stl, Product::Glb, Product::MeshCount},
                                         "the surface in a VDB or a mesh");
  static const OptionRows<SurfaceOptions> rows{
      {{.name = "tolerance",
        .argument = "T",
        .help = "how close vertices lie to the true surface, in voxels",
        .idle = noSurface},
       number(&SurfaceOptions::tolerance, within(1e-12, 0.5))},
      {{.name = "adaptivity",
        .argument = "E",
        .help = "make triangles of the mesh larger where the surface is flat: neither it nor the full mesh is anywhere "
                "farther than E voxels from the other, which is proved. The mesh is held in memory",
        .idle = noMesh},
       number(&SurfaceOptions::adaptivity, within(0, 100))},
      {{.name = "crumbs",
        .help = "what happens to pieces of at most " + std::to_string(kCrumb) +
                " voxels along each axis that hold no part of the target of their own: there are hundreds of them, and "
                "they have less than a hundredth of the volume. auto drops those around a target that are no longer "
                "than 1/40 of it; sets without a target keep them",
        .idle = noSurface},
       choice<Crumbs>(&SurfaceOptions::crumbs,
                      {{"drop", Crumbs::Drop}, {"keep", Crumbs::Keep}, {"auto", Crumbs::Auto}})},
      {{.name = "largest",
        .argument = "N",
        .help =
            "keep only the N largest islands, by volume; 0 keeps all. With --box an island is the part of it inside "
            "the box",
        .idle = noSurface},
       whole(
           [](auto& options) -> auto& { return options.islands.largest; }, std::uint64_t{0},
           std::numeric_limits<std::uint64_t>::max())},
      {{.name = "min-size",
        .argument = "W",
        .help = "drop islands whose longest side is below this, in the target's units",
        .idle = noSurface},
       number(
           [](auto& options) -> auto& { return options.islands.minSize; }, atLeast(0))},
      {{.name = "cap",
        .help = "close the mesh where the box cuts the set; the VDB is always closed",
        .idle = idleByAny({noMesh, idleCap})},
       flag(&SurfaceOptions::cap)},
  };
  return rows;
}

}  // namespace

std::vector<OptionSpec> surfaceOptionSpecs() { return surfaceRows().specs(); }

SurfaceOptions parseSurfaceOptions(const RecipeReader& reader) { return surfaceRows().read(reader); }

}  // namespace vdbtools
