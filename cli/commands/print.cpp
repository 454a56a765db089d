// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"
#include "output.h"
#include "report.h"
#include "sequence.h"
#include "shape_unit.h"

#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/print/print_job.h"
#include "vdbtools/recipe/recipe_reader.h"
#include "vdbtools/records/recorded_recipe.h"
#include "vdbtools/scene/file_axes.h"
#include "vdbtools/surface/level_set.h"

#include <cmath>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

namespace cli {
namespace {

constexpr Usage kPrintUsage = {
    "print", "F.vdb|MESH -o PART.stl|PART.3mf|PART.ply|PART.obj [--longest-side MM] [--min-thickness MM] [options]",
    "Makes a part for 3D printing: one closed piece without cavities, in millimetres, with z up, standing on z = 0 and "
    "centred in x and y. With --min-thickness hairs and walls that are thinner are thickened, or taken off. If the "
    "unit of the input is known, the part has its true size unless --longest-side says another one. If the input is a "
    "fractal that this program made, VDB, PLY or OBJ, its true surface is computed again from the recipe in the file.",
    "  juliavdb print bunny.vdb -o bunny.stl --longest-side 60\n"
    "  juliavdb print bunny.vdb -o bunny.3mf --longest-side 60 --min-thickness 1.2 --flat-base 0.5\n"
    "  juliavdb print bunny.vdb -o plain.stl --longest-side 60 --min-thickness 1.2 --thin drop --tolerance 0.1\n"
    "  juliavdb print bunny.obj -o true.3mf --units in\n"
    "  juliavdb print grow.####.vdb -o part.####.stl --longest-side 60 --frames 1-2\n"};

std::vector<vdbtools::OptionSpec> printOptionSpecs() {
  return {
      {.name = "output",
       .argument = "PART.stl",
       .help = "the part to write: " + vdbtools::extensionsOf(&vdbtools::FileFormat::printed)},
      {.name = "longest-side",
       .argument = "MM",
       .help = "the longest side of the part, in millimetres",
       .defaultNote = "that of the input's unit"},
      {.name = "min-thickness",
       .argument = "MM",
       .help = "the least thickness, in millimetres. Edges and tips of 60 degrees or more, and roughness of up to half "
               "of it, do not count as thin"},
      {.name = "thin",
       .argument = "thicken|drop",
       .defaultValue = "thicken",
       .help = "what happens to parts that are thinner than --min-thickness"},
      {.name = "flat-base", .argument = "MM", .help = "cut off so much below, for a flat base"},
      {.name = "target-up",
       .argument = "y|z",
       .help = "which axis of the input points up",
       .defaultNote = "what the input says, or else y"},
      {.name = "islands",
       .argument = "N",
       .defaultValue = std::to_string(vdbtools::PrintOptions().islands),
       .help = "how many pieces to keep, the largest by volume"},
      {.name = "tolerance",
       .argument = "MM",
       .defaultValue = "0.05",
       .help = "make triangles larger where that moves the surface by no more than this; 0 keeps all triangles. The "
               "default is finer than what printers can do"},
      {.name = "resolution",
       .argument = "N",
       .help = "voxels along the longest side, for the thickness, the flat base and meshes that are not closed",
       .defaultNote = "five to the least thickness, 250 to 600"},
      {.name = "repair", .help = "close holes and gaps of an open mesh or a triangle soup"},
      {.name = "from-grid", .help = "use the voxels or triangles, even of a fractal"},
      {.name = "grid", .argument = "NAME", .help = "which grid of a VDB to use, as with --from-grid"},
  };
}

vdbtools::PrintOptions parsePrint(const CommandLine& line, std::optional<vdbtools::LengthUnit> unit) {
  static const vdbtools::OptionTable table(printOptionSpecs());
  const vdbtools::RecipeReader reader(line.given(table), table);
  vdbtools::PrintOptions options;
  if (!reader.has("longest-side") && !unit)
    throw std::invalid_argument(
        "no size was given, and the unit of the input is not known; use --longest-side MM, or --units");
  const auto length = [&](const char* name) {
    const double value = reader.number(name);
    if (!(value > 0 && std::isfinite(value))) reader.refuse(name, "a length above 0, in millimetres");
    return value;
  };
  constexpr double kMillimetres = 1000;  // in a metre
  if (reader.has("longest-side"))
    options.size = length("longest-side");
  else
    options.scale = kMillimetres * metresOf(*unit);
  if (reader.has("min-thickness")) options.minThickness = length("min-thickness");
  options.thin = vdbtools::chosen<vdbtools::ThinParts>(
      "thin", reader.text("thin"), {{"thicken", vdbtools::ThinParts::Thicken}, {"drop", vdbtools::ThinParts::Drop}});
  if (line.has("thin") && !options.minThickness)
    throw std::invalid_argument("--thin can be used with --min-thickness only");
  if (reader.has("flat-base")) options.flatBase = length("flat-base");
  options.islands = reader.integer<std::uint64_t>("islands", 1, 1'000'000'000);
  if (reader.has("resolution")) options.resolution = reader.integer<std::uint64_t>("resolution", 20, 4000);
  options.tolerance = reader.number("tolerance");
  if (!(options.tolerance >= 0 && std::isfinite(options.tolerance)))
    reader.refuse("tolerance", "0 or a length above it, in millimetres");
  return options;
}

/// The fractal whose recipe the input contains, if it is to be computed again.
std::optional<vdbtools::FractalOptions> recordedFractal(const CommandLine& line, const std::string& input) {
  if (line.has("from-grid") || line.has("grid") || line.has("repair")) return std::nullopt;
  if (const vdbtools::FileFormat* const format = vdbtools::formatOfInput(input); !format || !format->isMadeAgain())
    return std::nullopt;
  const vdbtools::RecordedRecipe recorded = vdbtools::readRecordedRecipe(input);
  if (recorded.command != "fractal") return std::nullopt;
  vdbtools::FractalOptions options = vdbtools::parseFractalOptions(recorded.recipe);
  options.surface.cap = true;
  return options;
}

/// The axis of the shape that points up.
vdbtools::UpAxis upOf(const CommandLine& line, const std::string& input,
                      const std::optional<vdbtools::FractalOptions>& fractal) {
  using vdbtools::UpAxis;
  if (line.has("target-up")) return line.choice<UpAxis>("target-up", {{"y", UpAxis::Y}, {"z", UpAxis::Z}});
  if (fractal) return fractal->output.axes.target;
  return vdbtools::recordedUpAxis(vdbtools::readFileTexts(input));
}

/// Refuses options that have no effect on a part made from this input.
void requirePartFits(const CommandLine& line, const std::string& input, const vdbtools::PrintOptions& options) {
  const bool vdb = vdbtools::isVdbPath(input);
  line.requireUse(!vdb, {"repair"}, "it is for a mesh, and the input is a VDB; leave it out");
  line.requireUse(vdb, {"grid"}, "it chooses a grid of a VDB, and the input is a mesh; leave it out");
  line.requireUse(options.minThickness || options.flatBase || options.islands > 1 || !vdb, {"resolution"},
                  "it goes with --min-thickness, --flat-base or --islands; give one of them too, or leave it out");
}

/// The shape as a closed mesh.
/// @param united  receives the number of closed parts of a mesh that were made one
vdbtools::Mesh readShape(const CommandLine& line, const std::string& input, std::uint64_t resolution,
                         vdbtools::Monitor& progress, std::size_t& united) {
  if (vdbtools::isVdbPath(input)) {
    const vdbtools::VdbFile vdb = vdbtools::readVdb(input);
    return vdbtools::meshOfLevelSet(*vdbtools::chooseFloatGrid(vdb, line.text("grid"), input), progress);
  }
  progress.begin(vdbtools::PhaseKind::Reading, 0);
  return vdbtools::closedMesh(vdbtools::readMesh(input), resolution, line.has("repair"), progress, &united);
}

std::string counted(std::uint64_t count, const char* one, const char* several) {
  return std::to_string(count) + ' ' + (count == 1 ? one : several);
}

void tellPart(const vdbtools::PrintedPart& part, const vdbtools::PrintOptions& options, const std::string& names) {
  std::ostream& text = report().text();
  constexpr double kCubicCentimetre = 1000;  // cubic millimetres
  text << "wrote " << names << ": " << vdbtools::shortText(part.extents[0]) << " x "
       << vdbtools::shortText(part.extents[1]) << " x " << vdbtools::shortText(part.extents[2]) << " mm, "
       << vdbtools::shortText(part.volume / kCubicCentimetre) << " cm3, " << part.mesh.triangles.size()
       << " triangles\n";
  if (part.islands > part.keptIslands || part.cavities > 0) {
    text << "of " << counted(part.islands, "island", "islands") << ' ' << part.keptIslands
         << (part.keptIslands == 1 ? " is kept; " : " are kept; ") << vdbtools::shortText(100 * part.droppedShare)
         << " % of the volume is dropped";
    if (part.cavities > 0)
      text << ", and " << counted(part.cavities, "cavity", "cavities") << " of "
           << vdbtools::shortText(100 * part.cavityShare) << " % of it filled";
    text << '\n';
  }
  if (options.flatBase) text << "it stands on a base of " << vdbtools::shortText(part.baseArea) << " mm2\n";
  if (part.smallBase) {
    if (options.flatBase)
      text << "warning: a base of " << vdbtools::shortText(part.baseArea)
           << " mm2 is small for a part of this size, which may come off or fall over";
    else
      text << "note: it stands on " << vdbtools::shortText(part.baseArea)
           << " mm2, so that a slicer may find nothing to print in the first layer";
    if (part.betterBase)
      text << "; --flat-base " << vdbtools::shortText(*part.betterBase, vdbtools::Rounding::Up) << " gives "
           << (options.flatBase ? "one" : "a base") << " that is large enough";
    text << '\n';
  }
  const double asked = options.minThickness.value_or(1);
  const bool capped = part.thinnest > 1.9 * asked;
  text << "the thinnest place found is " << (capped ? "more than " : "") << vdbtools::shortText(part.thinnest)
       << " mm thick, of " << counted(part.places, "place", "places") << " that were measured";
  if (options.minThickness && part.thinPlaces == 0 && part.thinnest < asked)
    text << ", which is the least thickness of " << vdbtools::shortText(asked)
         << " mm as exactly as it is measured, within " << vdbtools::shortText(100 * vdbtools::kThicknessRounding)
         << " %";
  text << '\n';
  if (part.thinPlaces > 0)
    text << (options.minThickness ? "warning: " : "note: ") << counted(part.thinPlaces, "place is", "places are")
         << " thinner than " << vdbtools::shortText(asked) << " mm"
         << (options.minThickness ? "; try a higher --resolution" : "; --min-thickness makes such places thicker")
         << '\n';
  if (options.minThickness && part.voxelSize > *options.minThickness / 3)
    text << "warning: the voxels of " << vdbtools::shortText(part.voxelSize)
         << " mm are coarse for this thickness, and detail is lost; try a higher --resolution\n";
}

/// @param fractal  if set, its surface is computed again
void makePart(const CommandLine& line, const std::string& input, const std::optional<vdbtools::FractalOptions>& fractal,
              const vdbtools::PrintOptions& options, std::optional<vdbtools::LengthUnit> unit,
              const vdbtools::FileFormat& format, const FrameRun& run) {
  vdbtools::AtomicFile& file = run.outputs.add("output", line.text("output"), &vdbtools::FileFormat::printed);
  std::size_t united = 0;
  const vdbtools::PrintedPart part =
      vdbtools::printedPart(fractal ? vdbtools::fractalMesh(vdbtools::makeScene(*fractal, run.monitor), run.monitor)
                                    : readShape(line, input, options.resolution, run.monitor, united),
                            options, run.monitor);
  run.monitor.begin(vdbtools::PhaseKind::Writing, 0);
  vdbtools::MeshWriteOptions write{.format = &format};
  if (unit) vdbtools::setUnit(write, vdbtools::LengthUnit::Millimetre);
  vdbtools::writeMesh(file.stream(), part.mesh, write);
  run.monitor.throwIfCancelled();
  run.outputs.commit(run.isLast);

  report().count("points", part.mesh.points.size());
  report().count("triangles", part.mesh.triangles.size());
  report().count("x", part.extents[0]);
  report().count("y", part.extents[1]);
  report().count("z", part.extents[2]);
  report().count("volume", part.volume);
  report().count("scale", part.scale);
  report().count("islands", part.islands);
  report().count("droppedShare", part.droppedShare);
  report().count("cavities", part.cavities);
  report().count("thinnest", part.thinnest);
  report().count("thinPlaces", part.thinPlaces);
  tellPart(part, options, run.outputs.names());
  if (united > 0)
    report().text() << united << " parts of the mesh run into each other, and were made one on a lattice, which rounds "
                    << "edges; a higher --resolution rounds them less\n";
}

}  // namespace

int runPrint(const Arguments& arguments) {
  CommandLine line(kPrintUsage, vdbtools::OptionTable());
  line.addPositional("input", 1, "the VDB or the mesh");
  line.addOptions(printOptionSpecs());
  addUnitsOption(line);
  line.addFormerName("size", "longest-side");
  line.addFormerName("up", "target-up");
  addFramesOption(line);
  line.acceptStandardInput();
  if (!line.parse(arguments)) return kDone;
  const std::string input = line.text("input");
  if (input.empty()) throw std::invalid_argument("no VDB or mesh was given");
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o PART.stl");
  // Outputs refuse a name of another format.
  const vdbtools::FileFormat* const named = vdbtools::findFormat(formatOf(line.text("output"), ".stl"));
  const vdbtools::FileFormat& format = named && named->printed ? *named : vdbtools::meshFormat(".stl");
  vdbtools::requireBuilt(format);
  return runFrames(line, input, kOnlyOutput, [&](const std::string& name) {
    const std::optional<vdbtools::LengthUnit> unit = unitOf(line, name);
    vdbtools::PrintOptions options = parsePrint(line, unit);
    requirePartFits(line, name, options);
    const std::optional<vdbtools::FractalOptions> fractal = recordedFractal(line, name);
    options.up = upOf(line, name, fractal);
    FrameJob job;
    if (fractal) job.inputs = vdbtools::inputsOf(*fractal);
    job.make = [&line, &format, name, fractal, options, unit](const FrameRun& run) {
      makePart(line, name, fractal, options, unit, format, run);
    };
    return job;
  });
}

}  // namespace cli
