// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"
#include "output.h"
#include "report.h"
#include "shape_unit.h"
#include "target_text.h"

#include "vdbtools/base/text.h"
#include "vdbtools/fit/fit_job.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/scene/file_axes.h"

#include <optional>
#include <ostream>
#include <string>
#include <utility>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kFitUsage = {
    "fit", "MESH|SDF.vdb -o shape.json [--roots N | --target-iou X] [--method kim15] [options]",
    "Finds a rational quaternion map whose Julia set has the shape of a target. 'juliavdb fractal --map rational "
    "--rational shape.json' makes the set, for any number of iterations; the map can also be used as a versor. The "
    "fast fit is the default. --method kim15 runs the method of Kim (2015): electrostatics, monopoles, and the passes "
    "of --schedule.",
    "  juliavdb fit bunny.obj -o shape.json --roots 331 --report fit.csv --plot fit.png\n"
    "  juliavdb fit bunny.obj -o paper.json --method kim15 --schedule '25(VFRF) 50(V)' --epsilon 0.04\n"
    "  juliavdb fractal --map rational --rational shape.json -o bunny.vdb --mesh bunny.ply --resolution 300\n"};

}  // namespace

int runFit(const Arguments& arguments) {
  CommandLine line(kFitUsage, vdbtools::fit::fitOptionTable());
  line.addOptions()("output,o", po::value<std::string>()->value_name("F.json"), "the map to write: .json or .o3d")(
      "report", po::value<std::string>()->value_name("F.csv"),
      "a table of every accepted step: energies, IoU, distances, powers")(
      "plot", po::value<std::string>()->value_name("F.png"), "the same as a picture: .png, .svg or .exr")(
      "charge", po::value<std::string>()->value_name("F.ply"),
      ("the surface that roots are placed on, with its electrostatic charge as a grey: " +
       vdbtools::extensionsOf(&vdbtools::FileFormat::writesColours))
          .c_str());
  addUnitsOption(line);
  if (!line.parse(arguments)) return kDone;
  const vdbtools::fit::FitOptions options = vdbtools::fit::parseFitOptions(line.recipe());
  line.requireEffect({vdbtools::Product::Recipe});
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o F.json");
  line.requireUse(line.has("charge"), {"units"}, "it is for the mesh of --charge; leave it out");
  const std::optional<vdbtools::LengthUnit> unit =
      line.has("charge") ? unitOf(line, options.target.input.string()) : std::nullopt;
  vdbtools::InputFiles inputs;
  inputs.add(options.target.input);
  Outputs outputs(line, std::move(inputs));
  std::ostream& file = outputs.add("output", line.text("output"), ".json .o3d").stream();
  std::ostream* const reportFile =
      line.has("report") ? &outputs.add("report", line.text("report"), ".csv").stream() : nullptr;
  std::ostream* const plot =
      line.has("plot") ? &outputs.add("plot", line.text("plot"), ".png .svg .exr").stream() : nullptr;

  const std::string charge = line.text("charge");
  std::ostream* const chargeFile =
      line.has("charge") ? &outputs.add("charge", charge, &vdbtools::FileFormat::writesColours).stream() : nullptr;

  const vdbtools::fit::FitResult fit = vdbtools::fit::runFit(options, reportFile != nullptr, line.progress());
  line.progress().begin(vdbtools::PhaseKind::Writing, 0);
  if (formatOf(line.text("output"), ".json") == ".o3d")
    file << vdbtools::fit::fitToO3d(fit, line.progress());
  else
    file << vdbtools::fit::fitToJson(fit, line.recipe());
  if (reportFile) *reportFile << vdbtools::fit::fitReportCsv(fit.rows);
  if (plot) *plot << vdbtools::encodePlot(vdbtools::fit::fitReportPlot(fit.rows), formatOf(line.text("plot"), ".png"));
  if (chargeFile) {
    const vdbtools::fit::ChargedSurface surface = vdbtools::fit::chargedSurface(fit, line.progress());
    vdbtools::MeshWriteOptions write{.format = &vdbtools::meshFormat(formatOf(charge, ".ply")),
                                     .columns = surface.columns};
    if (unit) vdbtools::setUnit(write, *unit);
    vdbtools::writeMesh(*chargeFile, surface.mesh, write, surface.values);
  }
  line.progress().throwIfCancelled();
  outputs.commit();
  const vdbtools::fit::FitMeasure& measure = fit.measure;
  const auto number = [](double value) { return vdbtools::shortText(value); };
  report().count("topRoots", fit.rational.top.roots.size());
  report().count("bottomRoots", fit.rational.bottom.roots.size());
  report().count("iou", measure.iou);
  report().count("iteratedIou", fit.iteratedIou);
  report().count("steps", fit.rows.size());
  const std::string shifted = ", for which C was then shifted by " + number(fit.scaleShift);
  report().text() << "wrote " << outputs.names() << ": " << fit.rational.top.roots.size() << " top and "
                  << fit.rational.bottom.roots.size() << " bottom roots, IoU " << number(measure.iou)
                  << " after one iteration and " << number(fit.iteratedIou) << " after " << options.scored()
                  << (options.iterations > 1 ? shifted : "") << "; psi " << number(measure.psi) << ", mean distance "
                  << number(measure.meanDistance) << ", Hausdorff " << number(measure.hausdorff)
                  << " of the longest side; powers sum to " << number(julia::summedPowers(fit.rational.top)) << " and "
                  << number(julia::summedPowers(fit.rational.bottom)) << "; as thin as --alpha " << number(fit.slope)
                  << "; " << fit.rows.size() << " steps\n";
  if (fit.monopoles > 0)
    report().text() << "electrostatics: " << fit.monopoles << " monopoles, capacitance "
                    << number(fit.charge.capacitance) << '\n';
  tellTarget(fit.target.facts);
  return kDone;
}

}  // namespace cli
