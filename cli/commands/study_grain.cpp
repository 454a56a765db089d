// SPDX-License-Identifier: Apache-2.0
#include "study_grain.h"

#include "exit_code.h"
#include "options.h"
#include "output.h"
#include "report.h"

#include "vdbtools/base/text.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/scene/file_axes.h"
#include "vdbtools/scene/fractal_options.h"
#include "vdbtools/study/study.h"
#include "vdbtools/target/target_input.h"

#include <ostream>
#include <set>
#include <stdexcept>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kStudyGrainUsage = {
    "study", "MESH|SDF.vdb --strokes F.ply --grain GRAIN [options]",
    "Draws the directions that a texture follows on its target, as a mesh: a small triangle for each place, whose tip "
    "shows the direction, and whose colour shows how thick the target is there; and red marks at the points about "
    "which "
    "the direction turns. 'juliavdb render' makes a picture of it. Its attributes grain_x, grain_y and grain_z are the "
    "directions.",
    "  juliavdb study bunny.obj --grain along --strokes strokes.ply\n"
    "  juliavdb study bunny.obj --grain around --grain-turn 30 --strokes strokes.glb\n",
    "fractal"};

/// Refuses options that describe something else of a fractal.
void requireUse(const CommandLine& line) {
  std::set<std::string> used{"texture", "grain", "grain-turn", "detail", "alpha", "beta", "target-up"};
  for (const vdbtools::OptionSpec& option : vdbtools::targetOptionSpecs()) used.insert(option.name);
  for (const auto& [name, value] : line.given())
    if (!used.contains(name))
      throw std::invalid_argument(
          "--" + name + " has no effect: --strokes draws the directions that a texture follows; leave it out");
}

}  // namespace

int studyGrain(const Arguments& arguments) {
  CommandLine line(kStudyGrainUsage, vdbtools::fractalOptionTable());
  line.addOptions()("strokes", po::value<std::string>()->value_name("F.ply"), "the mesh to write: .ply or .glb");
  if (!line.parse(arguments)) return kDone;
  requireUse(line);
  const vdbtools::FractalOptions options = vdbtools::parseFractalOptions(line.recipe());
  line.requireEffect({vdbtools::Product::Picture});
  Outputs outputs(line, vdbtools::inputsOf(options));
  std::ostream& file = outputs.add("strokes", line.text("strokes"), ".ply .glb").stream();
  const vdbtools::GrainStrokes strokes = vdbtools::grainStrokes(options, line.progress());
  line.progress().begin(vdbtools::PhaseKind::Writing, 0);
  vdbtools::MeshWriteOptions write = vdbtools::meshWriteOptions(
      vdbtools::meshFormat(line.text("strokes")), options.output.axes, std::map<std::string, std::string>());
  write.columns = strokes.columns;
  vdbtools::writeMesh(file, strokes.mesh, write, strokes.values);
  line.progress().throwIfCancelled();
  outputs.commit();
  report().count("points", strokes.points);
  report().count("singular", strokes.singular);
  report().text() << "wrote " << outputs.names() << ": " << strokes.points << " places, "
                  << (strokes.singular == 0   ? "no singular point"
                      : strokes.singular == 1 ? "1 singular point"
                                              : std::to_string(strokes.singular) + " singular points")
                  << ", thickness " << vdbtools::shortText(strokes.thickness.first) << " to "
                  << vdbtools::shortText(strokes.thickness.second) << ", waves in step on "
                  << vdbtools::shortText(100 * strokes.inStep.first) << " % along and "
                  << vdbtools::shortText(100 * strokes.inStep.second) << " % across\n";
  return kDone;
}

}  // namespace cli
