// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/field/lattice_options.h"

#include <stdexcept>
#include <string>

namespace vdbtools {
namespace {

constexpr const char* kAutomatic = "auto";
// The usual textures need this resolution on most shapes (docs/textures.md). Sets without a target have detail of every
// size.
constexpr const char* kResolutionOfTarget = "300";
constexpr const char* kResolutionOfRegion = "200";

}  // namespace

bool hasAutomaticResolution(const Recipe& recipe) {
  const auto found = recipe.find("resolution");
  return found != recipe.end() && found->second == kAutomatic;
}

std::vector<OptionSpec> latticeOptionSpecs() {
  const IdleRule offLattice =
      idleWithout({Product::Vdb, Product::Mesh, Product::Stl, Product::Glb, Product::MeshCount}, "a VDB or a mesh");
  return {
      {.name = "resolution",
       .argument = "N|auto",
       .help = "voxels of the result along the longest side of the target, or of the region if there is no target; "
               "auto: as many as show nine tenths of the texture with two voxels or more, 300 to 1000, within the "
               "memory that the run may use",
       .defaultFor = [](const Recipe& recipe) -> std::optional<std::string> {
         return recipe.contains("input") ? kResolutionOfTarget : kResolutionOfRegion;
       },
       .defaultNote = std::string(kResolutionOfTarget) + ", or " + kResolutionOfRegion + " without a target",
       .alternative = "voxel-size"},
      {.name = "voxel-size",
       .argument = "H",
       .help = "the size of a voxel of the result, in the target's units",
       .alternative = "resolution"},
      {.name = "box", .argument = "X0,Y0,Z0,X1,Y1,Z1", .help = "make only this region, in the target's units"},
      {.name = "exhaustive", .help = "evaluate every node, even where the result is known; for checking"},
      {.name = "follow",
       .help = "follow the surface from seeds instead of visiting the whole shell, for very large runs. What is found "
               "is exact; islands that no seed meets are missed, and an estimate of how much that is gets printed",
       .idle = offLattice},
      {.name = "seed-stride",
       .argument = "N",
       .defaultValue = "8",
       .help = "with --follow: voxels between seeds, a power of 2 up to 64; smaller distances find more",
       .idle = idleByAny({offLattice, idleWithoutFlag("follow")})},
  };
}

LatticeOptions parseLatticeOptions(const RecipeReader& reader) {
  LatticeOptions options;
  options.automatic = hasAutomaticResolution(reader.recipe());
  if (options.automatic) {
    if (reader.has("voxel-size")) reader.voxels("resolution", "voxel-size");  // this call refuses it
  } else {
    if (reader.has("resolution") && !numberFromText(reader.text("resolution")))
      reader.refuse("resolution", "a number of voxels, or auto");
    options.voxels = reader.voxels("resolution", "voxel-size");
  }
  if (reader.has("box")) options.box = parseBox("box", reader.text("box"));
  options.exhaustive = reader.flag("exhaustive");
  const int stride = reader.integer("seed-stride", 1, 64);
  if (!isSeedStride(stride)) reader.refuse("seed-stride", "a power of 2, at most 64");
  if (reader.flag("follow")) {
    if (options.exhaustive)
      throw std::invalid_argument("--follow and --exhaustive contradict each other; give only one of them");
    options.follow = FollowOptions{.seedStride = stride};
  }
  return options;
}

}  // namespace vdbtools
