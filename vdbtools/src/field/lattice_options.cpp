// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/field/lattice_options.h"

#include "recipe/option_rows.h"

#include <stdexcept>
#include <string>

namespace vdbtools {
namespace {

constexpr const char* kAutomatic = "auto";
// The usual textures need this resolution on most shapes (docs/textures.md). Sets without a target have detail of every
// size.
constexpr const char* kResolutionOfTarget = "300";
constexpr const char* kResolutionOfRegion = "200";

/// --resolution and --voxel-size, which say the same in two ways.
void parseVoxels(const RecipeReader& reader, LatticeOptions& options) {
  options.automatic = hasAutomaticResolution(reader.recipe());
  if (options.automatic) {
    if (reader.has("voxel-size")) reader.voxels("resolution", "voxel-size");  // this call refuses it
    return;
  }
  if (reader.has("resolution") && !numberFromText(reader.text("resolution")))
    reader.refuse("resolution", "a number of voxels, or auto");
  options.voxels = reader.voxels("resolution", "voxel-size");
}

const OptionRows<LatticeOptions>& latticeRows() {
  const IdleRule offLattice =
      idleWithout({Product::Vdb, Product::Mesh, Product::Stl, Product::Glb, Product::MeshCount}, "a VDB or a mesh");
  static const OptionRows<LatticeOptions> rows{
      {{.name = "resolution",
        .argument = "N|auto",
        .help = "voxels of the result along the longest side of the target, or of the region if there is no target; "
                "auto: as many as show nine tenths of the texture with two voxels or more, 300 to 1000, within the "
                "memory that the run may use",
        .defaultFor = [](const Recipe& recipe) -> std::optional<std::string> {
          return recipe.contains("input") ? kResolutionOfTarget : kResolutionOfRegion;
        },
        .defaultNote = std::string(kResolutionOfTarget) + ", or " + kResolutionOfRegion + " without a target",
        .alternative = "voxel-size"},
       readByRule(above(0), {kAutomatic})},
      {{.name = "voxel-size",
        .argument = "H",
        .help = "the size of a voxel of the result, in the target's units",
        .alternative = "resolution"},
       readByRule(above(0))},
      {{.name = "box", .argument = "X0,Y0,Z0,X1,Y1,Z1", .help = "make only this region, in the target's units"},
       parsed(&LatticeOptions::box,
              [](const RecipeReader& reader, const std::string& name) { return parseBox(name, reader.text(name)); })},
      {{.name = "exhaustive", .help = "evaluate every node, even where the result is known; for checking"},
       flag(&LatticeOptions::exhaustive)},
      {{.name = "follow",
        .help = "follow the surface from seeds instead of visiting the whole shell, for very large runs. What is found "
                "is exact; islands that no seed meets are missed, and an estimate of how much that is gets printed",
        .idle = offLattice},
       parsedBy(
           [](const RecipeReader& reader, const std::string& name, LatticeOptions& options) {
             if (reader.flag(name)) options.follow = FollowOptions{};
           },
           {.kind = OptionType::Kind::Flag})},
      {{.name = "seed-stride",
        .argument = "N",
        .defaultValue = std::to_string(FollowOptions{}.seedStride),
        .help = "with --follow: voxels between seeds, a power of 2 up to 64; smaller distances find more",
        .idle = idleByAny({offLattice, idleWithoutFlag("follow")})},
       parsedBy([](const RecipeReader& reader, const std::string& name, LatticeOptions& options) {
         const int stride = reader.integer(name, 1, 64);
         if (!isSeedStride(stride)) reader.refuse(name, "a power of 2, at most 64");
         if (options.follow) options.follow->seedStride = stride;
       })},
  };
  return rows;
}

}  // namespace

bool hasAutomaticResolution(const Recipe& recipe) {
  const auto found = recipe.find("resolution");
  return found != recipe.end() && found->second == kAutomatic;
}

std::vector<OptionSpec> latticeOptionSpecs() { return latticeRows().specs(); }

LatticeOptions parseLatticeOptions(const RecipeReader& reader) {
  LatticeOptions options;
  parseVoxels(reader, options);
  latticeRows().read(reader, options);
  if (options.follow && options.exhaustive)
    throw std::invalid_argument("--follow and --exhaustive contradict each other; give only one of them");
  return options;
}

}  // namespace vdbtools
