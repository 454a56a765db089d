// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/scene/fractal_options.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <utility>

namespace vdbtools {
namespace {

std::vector<OutputGrid> parseGrids(const RecipeReader& reader) {
  constexpr std::pair<const char*, OutputGrid> kKnown[] = {{"surface", OutputGrid::Surface},
                                                           {"density", OutputGrid::Density},
                                                           {"logmodulus", OutputGrid::LogModulus},
                                                           {"iterations", OutputGrid::Iterations},
                                                           {"versor", OutputGrid::Versor}};
  std::vector<OutputGrid> grids;
  for (const std::string& name : split(reader.text("grids"), ',')) {
    const auto known =
        std::find_if(std::begin(kKnown), std::end(kKnown), [&](const auto& k) { return k.first == name; });
    if (known == std::end(kKnown)) reader.refuse("grids", "a list of surface, density, logmodulus, iterations, versor");
    if (std::find(grids.begin(), grids.end(), known->second) != grids.end())
      reader.refuse("grids", "a list in which no name occurs twice");
    grids.push_back(known->second);
  }
  return grids;
}

/// Refuses attributes of a target that is not there, and of a mask that the map does not have.
void requireSources(const RecipeReader& reader, const FractalOptions& options) {
  const AttributeOptions& attributes = options.output.attributes;
  if (attributes.has(PointAttribute::Mask) && !options.map->shell())
    reader.refuse("attributes", "without 'mask', as the map has no option --mask");
  if (options.target) return;
  constexpr const char* kNoTarget = ", as there is no target; give a mesh or a VDB, or leave it out";
  for (const auto& [attribute, name] : {std::pair(PointAttribute::Depth, "depth"), {PointAttribute::Tau, "tau"}})
    if (attributes.has(attribute)) reader.refuse("attributes", std::string("without '") + name + "'" + kNoTarget);
  if (attributes.colour && attributes.colour->by == FieldColour::Depth)
    reader.refuse("colour", std::string("something else than depth") + kNoTarget);
  if (!attributes.transferred.empty()) reader.refuse("transfer", std::string("empty") + kNoTarget);
}

/// "100%,25%,5%": the levels after the first, as shares.
std::vector<double> parseLevels(const RecipeReader& reader) {
  constexpr const char* kWanted = "percentages that begin with 100% and fall, such as 100%,25%,5%";
  constexpr std::size_t kMost = 8;
  std::vector<double> levels;
  double last = 0;
  for (const std::string& text : split(reader.text("lod"), ',')) {
    const std::optional<double> value =
        text.ends_with('%') ? numberFromText(text.substr(0, text.size() - 1)) : std::nullopt;
    const bool first = last == 0;
    if (!value || !(first ? *value == 100 : *value > 0 && *value < last)) reader.refuse("lod", kWanted);
    if (!first) levels.push_back(*value / 100);
    last = *value;
  }
  if (last == 0 || levels.size() > kMost) reader.refuse("lod", kWanted);
  return levels;
}

std::vector<OptionSpec> outputOptionSpecs() {
  const IdleRule noVdb = idleWithout({Product::Vdb}, "a VDB");
  OptionSpec gridNames = gridNamesOption();
  gridNames.idle = noVdb;
  return {{.name = "precision",
           .argument = "auto|float|double",
           .defaultValue = "auto",
           .help = "the arithmetic of the iteration; auto uses float where it is as good as double"},
          {.name = "grids",
           .argument = "LIST",
           .defaultValue = "surface",
           .help = "the grids of the VDB, a list of surface, density, logmodulus, iterations, versor",
           .idle = noVdb},
          gridNames,
          {.name = "half", .help = "write 16-bit floats", .idle = noVdb},
          {.name = "lod",
           .argument = "LIST",
           .defaultValue = "100%",
           .help = "levels of detail in a GLB, by their shares of the triangles, such as 100%,25%,5%",
           .idle = idleWithout({Product::Glb}, "a GLB")}};
}

}  // namespace

OptionTable fractalOptionTable(const MapRegistry& maps) {
  std::vector<OptionSpec> options;
  const auto add = [&](std::vector<OptionSpec> some) {
    for (OptionSpec& option : some) options.push_back(std::move(option));
  };
  add(targetOptionSpecs());
  add({maps.option()});
  add(spaceOptionSpecs());
  add(latticeOptionSpecs());
  add(surfaceOptionSpecs());
  add(outputOptionSpecs());
  add(attributeOptionSpecs());
  add(fileAxesOptionSpecs());
  return OptionTable(std::move(options), "map", maps.variants());
}

FractalOptions parseFractalOptions(const Recipe& recipe, const MapRegistry& maps) {
  const OptionTable table = fractalOptionTable(maps);
  const RecipeReader reader(recipe, table);
  FractalOptions options;
  options.target = parseTargetOptions(reader);
  options.space = parseSpaceOptions(reader);
  options.map = maps.find(reader.text("map"))->parse(reader);
  options.lattice = parseLatticeOptions(reader);
  options.surface = parseSurfaceOptions(reader);
  options.output = {.grids = parseGrids(reader),
                    .half = reader.flag("half"),
                    .axes = parseFileAxes(reader),
                    .levels = parseLevels(reader),
                    .attributes = parseAttributeOptions(reader)};
  std::vector<std::string> grids = split(reader.text("grids"), ',');
  for (const VertexColumn& column : meshColumns(options.output.attributes)) grids.push_back(column.name);
  options.output.gridNames = parseGridNames(reader.text("grid-names"), grids);
  requireSources(reader, options);
  if (options.lattice.automatic && !options.map->shell())
    reader.refuse("resolution", "a number, as only --map shape-modulus has a texture by which to choose it");
  options.precision = reader.choice<Precision>(
      "precision", {{"auto", Precision::Auto}, {"float", Precision::Float}, {"double", Precision::Double}});
  return options;
}

FractalOptions forPictures(FractalOptions options) {
  const ShellSettings* const shell = options.map->shell();
  options.picture = shell && !shell->interpolation;
  return options;
}

bool dropsCrumbs(const FractalOptions& options) {
  const Crumbs crumbs = options.surface.crumbs;
  return crumbs == Crumbs::Drop || (crumbs == Crumbs::Auto && options.map->shell());
}

bool dropsIslands(const FractalOptions& options) {
  const IslandOptions& islands = options.surface.islands;
  return islands.largest > 0 || islands.minSize > 0;
}

void requireTarget(const FractalOptions& options) {
  if (options.map->shell() && !options.target)
    throw std::invalid_argument(
        "there is no target, which the map needs: give a mesh, or a VDB with its signed distance");
}

}  // namespace vdbtools
