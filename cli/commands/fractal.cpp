// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "grid_file.h"
#include "options.h"
#include "output.h"
#include "plan.h"
#include "report.h"
#include "scene_recipe.h"
#include "sequence.h"
#include "target_text.h"

#include "vdbtools/base/text.h"
#include "vdbtools/farm/plans.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/recipe/option_value.h"
#include "vdbtools/scene/voxel_advice.h"
#include "vdbtools/target/target_survey.h"

#include <ostream>
#include <sstream>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kFractalUsage = {
    "fractal", "MESH|SDF.vdb -o F.vdb|F.nvdb [--mesh F.ply] [--detail D] [--resolution N | --voxel-size H] [options]",
    "Turns a target into a fractal of the same shape: a level set for Houdini or Blender, and the mesh of its true "
    "surface. The distances of a VDB input are used as they are. The maps quadratic, cross and mandelbulb make sets of "
    "their own, without a target, within the ball from which no orbit has escaped, or within a --box.\n\n"
    "With --frames it makes a sequence, one frame after the other. Names such as in.####.obj and out.####.vdb have a "
    "place for the frame, an animated glTF is played, and --key says what an option is at some frames ('juliavdb plan "
    "frames --help'). A frame whose files are there and were made by the same options from the same inputs is kept.",
    "  juliavdb fractal bunny.obj -o bunny.vdb --mesh bunny.ply --resolution 150\n"
    "  juliavdb fractal bunny.obj -o bunny.nvdb --nvdb-bits 8 --resolution 100\n"
    "  juliavdb fractal bunny.obj -o deep.vdb --detail 0.6 --texture-seed 7 --resolution 100\n"
    "  juliavdb fractal bunny.obj -o ramp.vdb --detail x:0.05:0.6:smooth --resolution 100\n"
    "  juliavdb fractal bunny.obj -o papers.vdb --alpha 40 --beta 0.02 --origin centre --resolution 100\n"
    "  juliavdb fractal --config bunny.vdb -o again.vdb\n"
    "  juliavdb fractal bunny.obj -o grow.####.vdb --frames 1-3 --key detail@1=0.1 --key detail@3=0.3 --resolution 60\n"
    "  juliavdb fractal --map quadratic --c=-0.2,0.6,0.2,0.2 --iterations 8 -o julia.vdb --resolution 80\n"
    "  juliavdb fractal --map mandelbulb --power 8 -o bulb.vdb --resolution 150\n"
    "  juliavdb fractal --map cross --scheme 5 --pair A --c 0.39,0.2,0 -o tunnels.vdb --resolution 150\n"
    "  juliavdb fractal --map cross --f \"x*x, y*y, z*z\" --g \"cos(x), cos(y), cos(z)\" --radius 5 -o own.vdb\n"};

/// "a" or "a to b".
std::string rangeText(const std::pair<double, double>& range) {
  const std::string low = vdbtools::shortText(range.first), high = vdbtools::shortText(range.second);
  return low == high ? low : low + " to " + high;
}

/// The values that were chosen for the target: "origin at ..., detail 0.25: alpha 19 to 319".
std::string choiceText(const vdbtools::Scene& scene) {
  const openvdb::Vec3d at = scene.placed.unmoved.centre;
  std::string text = "origin at " + vdbtools::shortText(at[0]) + "," + vdbtools::shortText(at[1]) + "," +
                     vdbtools::shortText(at[2]) + ": ";
  if (scene.shellOptions().detail) text += "detail " + rangeText(scene.shellOptions().detail->detail.range()) + " is ";
  return text + "alpha " + rangeText(scene.exponent()->alphaRange) + ", beta " + rangeText(scene.exponent()->betaRange);
}

/// Reports how much of the target is left, with a warning if that is little.
/// @param onlyIfLittle  reports nothing otherwise
void tellWhatIsLeft(const vdbtools::Scene& scene, const vdbtools::SolidMeasure& solid, bool onlyIfLittle) {
  const std::optional<openvdb::BBoxd>& box = scene.options.lattice.box;
  const double there = box ? vdbtools::insideVolume(*scene.target->distances.phi, *box) : scene.target->volume;
  if (!(there > 0)) return;  // the box lies beside the target, and only detail reaches into it
  const double share = 100 * solid.volume / there, largest = 100 * solid.shareOfLargest(1);
  const std::size_t islands = solid.islands.size();
  constexpr double kLittle = 50;  // percent
  const bool isLittle = share < kLittle || solid.islands.empty();
  if (onlyIfLittle && !isLittle) return;
  report().text() << "the set holds " << vdbtools::shortText(share) << " % of the target's volume"
                  << (box ? " within the box" : "") << " in "
                  << (islands == 1 ? std::string("1 island")
                                   : std::to_string(islands) + " islands, the largest of which has " +
                                         vdbtools::shortText(largest) + " % of it")
                  << '\n';
  if (!isLittle) return;
  report().text() << "warning: less than half of the target's volume is left; try "
                  << (scene.shellOptions().detail ? "a smaller --detail, a larger --outward"
                                                  : "--detail instead of --alpha, a larger --alpha or --beta")
                  << ", or --origin auto\n";
}

/// Says where a moving target cannot carry all of its detail.
void tellJumps(const vdbtools::Scene& scene) {
  constexpr double kWorthSaying = 0.001;
  if (!scene.rest || scene.rest->jumps < kWorthSaying) return;
  report().text() << "note: in " << vdbtools::shortText(100 * scene.rest->jumps)
                  << " % of the shell, parts of the surface that lie apart at rest are equally near; the detail of the "
                     "nearest one is taken there\n";
}

/// A sentence about the part of the surface that may be missing.
std::string followText(const vdbtools::FollowReport& report) {
  std::ostringstream text;
  const double visited = 100.0 * static_cast<double>(report.visitedBlocks) / static_cast<double>(report.shellBlocks);
  text << vdbtools::shortText(visited) << " % of the shell's blocks visited, some "
       << vdbtools::shortText(100 * report.missedShare()) << " % of the surface missed by an estimate from "
       << report.probedBlocks << " of the others";
  return text.str();
}

/// The options that name the files of a fractal.
constexpr const char* kOutputOptions[] = {"output", "mesh"};

struct FractalCounts {
  std::uint64_t evaluatedNodes = 0, triangles = 0;
};

/// Adds to the report the shares of the surface where something is finer than two voxels, 0 to 1, and the chosen
/// resolution.
void countFiner(const vdbtools::Scene& scene) {
  if (!scene.features()) return;
  const vdbtools::VoxelAdvice advice = vdbtools::adviseVoxels(*scene.features(), scene.voxelSize);
  report().count("textureBelowTwoVoxels", advice.textureShare);
  if (scene.shellOptions().detail) report().count("coreBelowTwoVoxels", advice.coreShare);
  if (scene.chosenResolution) report().count("resolution", scene.chosenResolution->resolution);
}

/// Reports what is finer than the voxels, or than floats. @return whether there was anything to report
bool tellWhatIsFiner(const vdbtools::Scene& scene) {
  bool any = false;
  for (const std::string& words : {vdbtools::finerThanVoxelsText(scene), vdbtools::coarseFloatsText(scene)}) {
    if (words.empty()) continue;
    report().text() << "warning: " << words << '\n';
    any = true;
  }
  return any;
}

/// Makes the files of one fractal and reports them, briefly for a frame.
/// @param options    those of run.found
/// @param saysFiner  whether to report what is finer than the voxels; set to false once that was reported
FractalCounts makeFractal(const CommandLine& line, const FractalRun& run, const vdbtools::FractalOptions& options,
                          vdbtools::SceneMaker& maker, bool& saysFiner, vdbtools::Monitor& progress) {
  const bool wantMesh = line.has("mesh"), isFrame = run.frame && line.has("frames");
  Outputs outputs(line, vdbtools::inputsOf(options), run.frame);
  std::vector<vdbtools::NvdbWritten> nvdb;
  const GridOutput grids = gridOutput(line);
  vdbtools::FractalFiles files{.nvdb = grids.values, .nvdbReport = &nvdb};
  if (line.has("output"))
    files.files.push_back(
        {&outputs.add("output", line.text("output"), &vdbtools::FileFormat::writesGrids), grids.format});
  if (wantMesh)
    files.files.push_back({&outputs.add("mesh", line.text("mesh"), &vdbtools::FileFormat::writesMesh),
                           &vdbtools::meshFormat(formatOf(line.text("mesh"), ".ply"))});

  const vdbtools::Scene scene = maker.make(options, progress);
  const vdbtools::FractalResult result = vdbtools::writeFractal(scene, run.recipe, files, progress);
  outputs.commit(run.isLast);

  const FractalCounts counts{result.evaluatedNodes, result.mesh.triangles};
  if (!isFrame) {
    report().count("voxelSize", scene.voxelSize);
    report().count("evaluatedNodes", counts.evaluatedNodes);
    countFiner(scene);
    if (wantMesh) report().count("triangles", counts.triangles);
    if (scene.rest) report().count("restJumps", scene.rest->jumps);
  }
  if (result.solid && !isFrame) report().count("islands", result.solid->islands.size());
  report().text() << "wrote " << outputs.names() << ": voxels of " << vdbtools::shortText(scene.voxelSize);
  for (const auto& grid : result.grids)
    if (grid->getName() == "surface") {
      if (!isFrame) report().count("bandVoxels", grid->activeVoxelCount());
      report().text() << ", " << grid->activeVoxelCount() << " in the band, |grad| within 0.5 of 1 in "
                      << vdbtools::shortText(100 * result.check.gradientFraction) << " % of them";
    }
  if (const auto moved = scene.metadata.find("julia_repair_moved"); moved != scene.metadata.end())
    report().text() << ", the target was repaired and its surface moved by at most "
                    << vdbtools::shortText(vdbtools::parseNumber("moved", moved->second), vdbtools::Rounding::Up);
  if (result.crumbs)
    tellCrumbs(*result.crumbs, scene.voxelSize, result.solid ? std::optional(result.solid->volume) : std::nullopt,
               !isFrame);
  if (result.islands)
    report().text() << ", " << result.islands->keptIslands << " of " << result.islands->islands << " islands kept";
  if (result.follow) report().text() << ", " << followText(*result.follow);
  report().text() << ", " << result.evaluatedNodes << " nodes evaluated";
  if (wantMesh) report().text() << ", " << result.mesh.triangles << " triangles";
  report().text() << '\n';
  tellNvdb(nvdb);
  tellClamped(result.clamped);
  const std::vector<vdbtools::VertexColumn> columns = vdbtools::meshColumns(options.output.attributes);
  for (const vdbtools::FractalFile& file : files.files) noteLeftOut(file.file->target(), columns);
  if (scene.target)
    if (const std::vector<std::string> unused = vdbtools::unusedParts(scene.target->parts, line.recipe());
        !unused.empty())
      report().text() << "not used of the target: " << vdbtools::joined(unused) << '\n';
  tellTarget(scene.metadata);
  tellJumps(scene);
  for (std::size_t i = 0; i < result.levels.size(); ++i)
    report().text() << "LOD" << i + 1 << ": " << result.levels[i].triangles << " triangles, some "
                    << vdbtools::shortText(result.levels[i].error / scene.voxelSize) << " voxels from the surface\n";
  if (const std::string chosen = vdbtools::chosenResolutionText(scene); !chosen.empty() && !isFrame)
    report().text() << chosen << '\n';
  if (const std::string chosen = vdbtools::chosenSdfResolutionText(scene); !chosen.empty() && !isFrame)
    report().text() << chosen << '\n';
  // This advice is given once for a sequence, because its frames are much alike.
  saysFiner = saysFiner && !tellWhatIsFiner(scene);
  if (scene.exponent()) {
    if (!isFrame) report().text() << choiceText(scene) << '\n';
    if (result.solid) tellWhatIsLeft(scene, *result.solid, isFrame);
    if (scene.shellOptions().mask.range().second == 0)
      report().text() << "note: the mask is 0 everywhere, so this is the plain target\n";
  }
  return counts;
}

/// Makes the frames of a sequence, except those that exist already.
int makeFrames(const CommandLine& line) {
  vdbtools::farm::FramePlanOptions options = parseFrameOptions(line, framesOf(line, kOutputOptions), productsOf(line));
  options.missingFails = !line.has("keep-going");
  // The options and the files of all frames are checked before the first frame is made.
  {
    vdbtools::farm::FrameRecipes asked(options);
    requireFramePlaces(line, asked.inputs(), kOutputOptions, asked.frames());
    chooseForAllFrames(line, asked, options);
  }
  const vdbtools::farm::FrameRecipes recipes(options);
  vdbtools::SceneMaker maker;
  FractalCounts total;
  bool saysFiner = true;
  const SequenceCounts counts =
      makeFractals(line, recipes, kOutputOptions, [&](const FractalRun& run, vdbtools::Monitor& monitor) {
        const FractalCounts made =
            makeFractal(line, run, vdbtools::parseFractalOptions(run.found), maker, saysFiner, monitor);
        total.evaluatedNodes += made.evaluatedNodes;
        total.triangles += made.triangles;
      });
  report().count("evaluatedNodes", total.evaluatedNodes);
  if (line.has("mesh")) report().count("triangles", total.triangles);
  return finishSequence(counts, /*keeps=*/true);
}

}  // namespace

int runFractalCommand(const Arguments& arguments) {
  CommandLine line(kFractalUsage, vdbtools::fractalOptionTable());
  line.addOptions()("output,o", po::value<std::string>()->value_name("F.vdb"), gridsHelp().c_str())(
      "mesh", po::value<std::string>()->value_name("F.ply"), meshHelp().c_str())(
      "frame", po::value<std::string>()->value_name("N"), "the frame number, for names such as name.####.vdb");
  addNvdbOption(line);
  addSequenceOptions(line);
  addSearchOption(line);
  line.acceptStandardInput();
  if (!line.parse(arguments)) return kDone;
  vdbtools::FractalOptions options = vdbtools::parseFractalOptions(line.recipe());
  if (!line.has("output") && !line.has("mesh"))
    throw std::invalid_argument("no output was given; use -o F.vdb, --mesh F.ply, or both");
  gridOutput(line);
  requireSequenceFits(line);
  if (line.has("frames")) return makeFrames(line);
  line.requireEffect(productsOf(line));
  vdbtools::SceneMaker maker;
  bool saysFiner = true;
  const FractalRun run{line.recipe(), withFoundFiles(line, line.recipe(), line.configHolder()),
                       parseFrame(line.text("frame"))};
  if (run.found != run.recipe) options = vdbtools::parseFractalOptions(run.found);
  makeFractal(line, run, options, maker, saysFiner, line.progress());
  return kDone;
}

}  // namespace cli
