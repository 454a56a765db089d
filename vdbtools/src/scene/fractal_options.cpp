// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/scene/fractal_options.h"

#include "recipe/option_rows.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <utility>

namespace vdbtools {
namespace {

/// Refuses attributes of a target that is not there, and of a mask that the map does not have.
void requireSources(const RecipeReader& reader, const FractalOptions& options) {
  const AttributeOptions& attributes = options.output.attributes;
  if (attributes.has(PointAttribute::Mask) && !options.map->shell())
    reader.refuse("attributes", "without 'mask', as the map has no option --mask");
  if (options.target) return;
  constexpr const char* kNoTarget = ", as there is no target; give a mesh or a VDB, or leave it out";
  for (const auto& [attribute, name] : {std::pair(PointAttribute::Depth, "depth"),
                                        {PointAttribute::Tau, "tau"},
                                        {PointAttribute::Velocity, "velocity"}})
    if (attributes.has(attribute)) reader.refuse("attributes", std::string("without '") + name + "'" + kNoTarget);
  if (attributes.colour && attributes.colour->by == FieldColour::Depth)
    reader.refuse("colour", std::string("something else than depth") + kNoTarget);
  if (!attributes.transferred.empty()) reader.refuse("transfer", std::string("empty") + kNoTarget);
}

/// "100%,25%,5%": the levels after the first, as shares.
void parseLevels(const RecipeReader& reader, const std::string& name, OutputOptions& options) {
  constexpr const char* kWanted = "percentages that begin with 100% and fall, such as 100%,25%,5%";
  constexpr std::size_t kMost = 8;
  double last = 0;
  for (const std::string& text : split(reader.text(name), ',')) {
    const std::optional<double> value =
        text.ends_with('%') ? numberFromText(text.substr(0, text.size() - 1)) : std::nullopt;
    const bool first = last == 0;
    if (!value || !(first ? *value == 100 : *value > 0 && *value < last)) reader.refuse(name, kWanted);
    if (!first) options.levels.push_back(*value / 100);
    last = *value;
  }
  if (last == 0 || options.levels.size() > kMost) reader.refuse(name, kWanted);
}

const OptionRows<FractalOptions>& precisionRow() {
  static const OptionRows<FractalOptions> row{
      {{.name = "precision", .help = "the arithmetic of the iteration; auto uses float where it is as good as double"},
       choice<Precision>(&FractalOptions::precision,
                         {{"auto", Precision::Auto}, {"float", Precision::Float}, {"double", Precision::Double}})}};
  return row;
}

const OptionRows<OutputOptions>& outputRows() {
  static const IdleRule noVdb = idleWithout({Product::Vdb}, "a VDB");
  static const OptionRows<OutputOptions> rows{
      {{.name = "grids",
        .argument = "LIST",
        .help = "the grids of the VDB, a list of surface, density, logmodulus, iterations, versor",
        .idle = noVdb},
       list<OutputGrid>(&OutputOptions::grids, {{"surface", OutputGrid::Surface},
                                                {"density", OutputGrid::Density},
                                                {"logmodulus", OutputGrid::LogModulus},
                                                {"iterations", OutputGrid::Iterations},
                                                {"versor", OutputGrid::Versor}})},
      {[] {
         OptionSpec names = gridNamesOption();
         names.idle = noVdb;
         return names;
       }(),
       readByRule()},
      {{.name = "half", .help = "write 16-bit floats", .idle = noVdb}, flag(&OutputOptions::half)},
      {{.name = "lod",
        .argument = "LIST",
        .defaultValue = "100%",
        .help = "levels of detail in a GLB, by their shares of the triangles, such as 100%,25%,5%",
        .idle = idleWithout({Product::Glb}, "a GLB")},
       parsedBy(parseLevels)}};
  return rows;
}

}  // namespace

OptionTable fractalOptionTable(const MapRegistry& maps) {
  std::vector<OptionSpec> options;
  const auto add = [&](std::vector<OptionSpec> some) {
    for (OptionSpec& option : some) options.push_back(std::move(option));
  };
  add(targetOptionSpecs());
  add(restOptionSpecs());
  add(velocityOptionSpecs());
  add({maps.option()});
  add(spaceOptionSpecs());
  add(latticeOptionSpecs());
  add(surfaceOptionSpecs());
  add(precisionRow().specs());
  add(outputRows().specs());
  add(attributeOptionSpecs());
  add(fileAxesOptionSpecs());
  return OptionTable(std::move(options), "map", maps.variants());
}

FractalOptions parseFractalOptions(const Recipe& recipe, const MapRegistry& maps) {
  const OptionTable table = fractalOptionTable(maps);
  const RecipeReader reader(recipe, table);
  FractalOptions options;
  options.target = parseTargetOptions(reader);
  options.rest = parseRestOptions(reader, options.target);
  options.space = parseSpaceOptions(reader);
  options.map = maps.find(reader.text("map"))->parse(reader);
  options.lattice = parseLatticeOptions(reader);
  options.surface = parseSurfaceOptions(reader);
  precisionRow().read(reader, options);
  outputRows().read(reader, options.output);
  options.output.axes = parseFileAxes(reader);
  options.output.attributes = parseAttributeOptions(reader);
  std::vector<std::string> grids = split(reader.text("grids"), ',');
  for (const VertexColumn& column : meshColumns(options.output.attributes)) grids.push_back(column.name);
  options.output.gridNames = parseGridNames(reader.text("grid-names"), grids);
  requireSources(reader, options);
  options.velocity = parseVelocityOptions(reader, options.target);
  if (options.rest && !options.map->shell())
    reader.refuse("map", "shape-modulus, as only its fractal follows a target that moves");
  if (options.lattice.automatic && !options.map->shell())
    reader.refuse("resolution", "a number, as only --map shape-modulus has a texture by which to choose it");
  return options;
}

FractalOptions forPictures(FractalOptions options) {
  const ShellSettings* const shell = options.map->shell();
  options.picture = shell && !shell->interpolation;
  return options;
}

FractalOptions optionsAtRest(FractalOptions options) {
  if (!options.rest) return options;
  requireTarget(options);
  options.target = targetAtRest(*options.rest, *options.target);
  options.rest.reset();
  options.velocity.reset();
  options.lattice.box.reset();
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
  if (options.velocity && !options.velocity->isKnown())
    throw std::invalid_argument(
        "--attributes is to have 'velocity', and nothing says how the target moves; give the mesh of a neighbouring "
        "frame as --target-before or --target-after, --target-frame for an animated glTF, or a sequence of inputs");
}

}  // namespace vdbtools
