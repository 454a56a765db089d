// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/job/sdf_job.h"

#include "distance/united_parts.h"
#include "repair/solid_input.h"
#include "vdbtools/files/file_hash.h"
#include "vdbtools/recipe/recipe_reader.h"
#include "vdbtools/target/target_input.h"

#include <stdexcept>

namespace vdbtools {

namespace {

constexpr const char* kGrid = "phi";

}  // namespace

OptionTable sdfOptionTable() {
  std::vector<OptionSpec> options = {
      {.name = "input",
       .argument = "MESH",
       .help = "the mesh: .obj, .ply, .stl, .off, .glb or .gltf; with --points-radius a cloud of points",
       .hash = "source-sha256"},
      {.name = "resolution",
       .argument = "N",
       .defaultValue = "200",
       .help = "voxels along the mesh's longest side",
       .alternative = "voxel-size"},
      {.name = "voxel-size",
       .argument = "H",
       .help = "the size of a voxel, in the mesh's units",
       .alternative = "resolution"},
      {.name = "band", .argument = "N", .defaultValue = "3", .help = "half width of the narrow band, in voxels"},
      {.name = "half", .help = "write 16-bit floats"},
  };
  for (OptionSpec& option : mendOptionSpecs()) options.insert(options.end() - 1, std::move(option));
  options.push_back(gridNamesOption());
  options.back().defaultNote = kGrid;
  for (OptionSpec& option : fileAxesOptionSpecs()) options.push_back(std::move(option));
  return OptionTable(std::move(options));
}

SdfOptions parseSdfOptions(const Recipe& recipe) {
  const OptionTable table = sdfOptionTable();
  const RecipeReader reader(recipe, table);
  SdfOptions options;
  options.input = reader.text("input");
  if (options.input.empty()) throw std::invalid_argument("no mesh was given");
  options.voxels = reader.voxels("resolution", "voxel-size");
  options.mend = parseMendOptions(reader);
  options.band = reader.number("band");
  if (!(options.band > 1 && options.band <= 1e6)) reader.refuse("band", "above 1 and at most 1e6");
  options.half = reader.flag("half");
  options.axes = parseFileAxes(reader);
  options.gridNames = parseGridNames(reader.text("grid-names"), std::vector<std::string>{kGrid});
  return options;
}

SdfResult runSdf(const SdfOptions& options, Monitor& monitor) {
  openvdb::initialize();
  const std::optional<LengthUnit> unit =
      options.mesh ? options.axes.unit : agreedUnit(options.axes.unit, unitOfFile(options.input), options.input);
  const SolidSource source = openSolid(options.input, options.mesh, options.mend);
  SdfResult result;
  result.report = source.report;
  const double voxel = options.voxels.sizeFor(longestSide(source.box));
  requireVdbVoxel(voxel);
  requireResolved(options.mend, voxel);
  MeshSdf sdf = makeSdf(*source.solid, sdfBand(voxel, options.band, options.band), options.mend, monitor);
  result.grid = sdf.grid;
  result.grid->setName(kGrid);
  result.moved = sdf.moved;
  result.closedGap = sdf.closedGap;
  result.caps = sdf.caps;
  result.metadata["julia_source_sha256"] = options.mesh ? sha256OfMesh(*options.mesh) : sha256OfFile(options.input);
  // The program reads it back with the grid, and so in the axes of the file.
  result.metadata[kTargetBox] = boxText(UpTurn(options.axes.target, options.axes.ofVdb())(source.box));
  result.metadata.merge(distanceGridMetadata(options.gridNames, kGrid));
  if (unit) result.metadata[kLengthUnit] = nameOf(*unit);
  if (sdf.moved) result.metadata["julia_repair_moved"] = numbersText({*sdf.moved});
  if (sdf.united > 0) result.metadata[kUnitedParts] = std::to_string(sdf.united);
  return result;
}

}  // namespace vdbtools
