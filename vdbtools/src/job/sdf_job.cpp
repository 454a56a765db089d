// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/job/sdf_job.h"

#include "distance/united_parts.h"
#include "recipe/option_rows.h"
#include "repair/solid_input.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/formats/file_formats.h"
#include "vdbtools/recipe/recipe_reader.h"
#include "vdbtools/surface/level_set.h"
#include "vdbtools/target/target_input.h"

#include <stdexcept>

namespace vdbtools {

namespace {

constexpr const char* kGrid = "phi";

/// Adds the metadata that meshes and VDBs as the source have in common.
void describe(const SdfOptions& options, const openvdb::BBoxd& box, SdfResult& result) {
  const std::optional<LengthUnit> unit =
      options.mesh ? options.axes.unit : agreedUnit(options.axes.unit, unitOfFile(options.input), options.input);
  result.grid->setName(kGrid);
  result.metadata["julia_source_sha256"] = options.mesh ? sha256OfMesh(*options.mesh) : sha256OfFile(options.input);
  // The program reads the box together with the grid, so it is in the axes of the file.
  result.metadata[kTargetBox] = boxText(UpTurn(options.axes.target, options.axes.ofVdb())(box));
  result.metadata.merge(distanceGridMetadata(options.gridNames, kGrid));
  if (unit) result.metadata[kLengthUnit] = nameOf(*unit);
}

SdfResult redistancedVdb(const SdfOptions& options, Monitor& monitor) {
  const Target target = readVdbTarget(options.input, options.grid, options.mend.volume, monitor, true);
  SdfResult result;
  result.metadata = target.facts;
  result.grid = redistanced(*target.phi, options.band, monitor);
  describe(options, target.box, result);
  return result;
}

const OptionRows<SdfOptions>& sdfRows() {
  static const OptionRows<SdfOptions> rows{
      {{.name = "input",
        .argument = "MESH|SDF.vdb",
        .help = "the mesh: " + extensionsOf(&FileFormat::readsMesh) +
                "; with --points-radius a cloud of points; or a VDB, whose level set gets a band of another width, or "
                "whose volume becomes a level set",
        .hash = "source-sha256"},
       withoutDefault(text(&SdfOptions::input))},
      {{.name = "grid", .argument = "NAME", .help = "which grid of the input VDB to use", .idle = idleWithoutVdb},
       withoutDefault(text(&SdfOptions::grid))},
      {{.name = "resolution",
        .argument = "N",
        .defaultValue = "200",
        .help = "voxels along the mesh's longest side",
        .alternative = "voxel-size",
        .idle = idleWithoutMesh},
       readByRule(above(0))},
      {{.name = "voxel-size",
        .argument = "H",
        .help = "the size of a voxel, in the mesh's units",
        .alternative = "resolution",
        .idle = idleWithoutMesh},
       readByRule(above(0))},
      {{.name = "band", .argument = "N", .help = "half width of the narrow band, in voxels"},
       number(&SdfOptions::band, above(1, 1e6))},
      {{.name = "half", .help = "write 16-bit floats"}, flag(&SdfOptions::half)}};
  return rows;
}

}  // namespace

OptionTable sdfOptionTable() {
  std::vector<OptionSpec> options = sdfRows().specs();
  for (OptionSpec& option : mendOptionSpecs()) options.insert(options.end() - 1, std::move(option));
  options.push_back(gridNamesOption());
  options.back().defaultNote = kGrid;
  for (OptionSpec& option : fileAxesOptionSpecs()) options.push_back(std::move(option));
  return OptionTable(std::move(options));
}

SdfOptions parseSdfOptions(const Recipe& recipe) {
  const OptionTable table = sdfOptionTable();
  const RecipeReader reader(recipe, table);
  SdfOptions options = sdfRows().read(reader);
  if (options.input.empty()) throw std::invalid_argument("no mesh was given");
  options.voxels = reader.voxels("resolution", "voxel-size");
  options.mend = parseMendOptions(reader);
  options.axes = parseFileAxes(reader);
  options.gridNames = parseGridNames(reader.text("grid-names"), std::vector<std::string>{kGrid});
  return options;
}

SdfResult runSdf(const SdfOptions& options, Monitor& monitor) {
  openvdb::initialize();
  if (!options.mesh && isVdbPath(options.input)) return redistancedVdb(options, monitor);
  const SolidSource source = openSolid(options.input, options.mesh, options.mend);
  SdfResult result;
  const double voxel = options.voxels.sizeFor(longestSide(source.box));
  requireVdbVoxel(voxel);
  requireResolved(options.mend, voxel);
  MeshSdf sdf = makeSdf(*source.solid, sdfBand(voxel, options.band, options.band), options.mend, monitor);
  result.grid = sdf.grid;
  result.moved = sdf.moved;
  result.closedGap = sdf.closedGap;
  result.caps = sdf.caps;
  describe(options, source.box, result);
  if (sdf.moved) result.metadata["julia_repair_moved"] = numbersText({*sdf.moved});
  result.metadata.merge(partFacts(sdf.parts, options.mend.hollows));
  if (source.mesh->pointsLeftOut > 0) result.metadata[kPointsLeftOut] = std::to_string(source.mesh->pointsLeftOut);
  return result;
}

}  // namespace vdbtools
