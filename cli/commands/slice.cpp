// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"
#include "output.h"
#include "report.h"
#include "scene_recipe.h"
#include "sequence.h"
#include "shape_unit.h"
#include "slice_plane.h"
#include "slice_samples.h"
#include "slice_stack.h"
#include "target_text.h"

#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/picture/slice_image.h"
#include "vdbtools/recipe/option_value.h"
#include "vdbtools/scene/scene.h"

#include "julia/elementary.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <ostream>
#include <span>

namespace po = boost::program_options;

namespace cli {
namespace {

using vdbtools::Scene;
using vdbtools::SlicePlane;

constexpr Usage kSliceUsage = {
    "slice",
    "MESH|SDF.vdb|FRACTAL.vdb -o F.png [--field phi|e|f|membership|iterations|versor|grid] [--axis x|y|z] "
    "[--stack] [options]",
    "Makes a picture of a field on a plane, or with --stack one of each layer. For a fractal that this program made, "
    "the options come from its recipe; for a mesh or a signed distance, they are those of 'fractal'.\n\n"
    "  phi         the target's signed distance: blue inside, red outside, the surface dark\n"
    "  e           ln |f(x)| of the first step, in the same colours: for the shape modulus, its exponent\n"
    "  f           the log-modulus after the last step, in the same colours; also called logmodulus\n"
    "  membership  the fractal itself: black inside\n"
    "  iterations  how many steps the orbit took, from white (none) to black (all of them)\n"
    "  versor      the direction of the map as RGB\n"
    "  grid        the voxels of a VDB as they are",
    "  juliavdb slice bunny.vdb -o membership.png --field membership\n"
    "  juliavdb slice bunny.vdb -o versor.png --field versor --axis x\n"
    "  juliavdb slice bunny.vdb --stack -o layers.####.tif --axis y --size 60 --units mm\n"
    "  juliavdb slice bunny.obj -o e.exr --field e --alpha 40 --position 0.1 --size 400\n"
    "  juliavdb slice bunny.obj -o first_step.png --field e --arrow 0,0,0.2 --arrow 0.5,0.6,0\n"
    "  juliavdb slice grow.####.vdb -o cut.####.png --frames 1-2\n"};

SliceField parseField(const CommandLine& line) {
  return line.choice<SliceField>("field", {{"phi", SliceField::Phi},
                                           {"e", SliceField::Exponent},
                                           {"f", SliceField::Field},
                                           {"logmodulus", SliceField::Field},
                                           {"membership", SliceField::Membership},
                                           {"iterations", SliceField::Iterations},
                                           {"versor", SliceField::Versor},
                                           {"grid", SliceField::Grid}});
}

/// The first steps of the orbits of these points, world units.
/// @throw std::invalid_argument  the map is not one of quaternions
std::vector<vdbtools::SliceArrow> arrowsFrom(const std::vector<openvdb::Vec3d>& positions, const Scene& scene) {
  if (scene.field.evaluator->dimension() != 4)
    throw std::invalid_argument("--arrow is for maps of quaternions, and this map is one of R^3; leave it out");
  std::vector<julia::Point> points;
  for (const openvdb::Vec3d& position : positions) points.push_back(scene.field.space.toFractal(position));
  std::vector<double> field(points.size()), logModuli(points.size());
  std::vector<julia::Quaternion<double>> versors(points.size());
  scene.field.evaluator->evaluate(points, field, {});
  scene.field.evaluator->versors(points, versors);
  firstStep(scene)->orbitTraps(points, logModuli);
  const julia::Embedding embedding = scene.options.map->embedding();
  std::vector<vdbtools::SliceArrow> arrows;
  for (std::size_t i = 0; i < points.size(); ++i) {
    // No picture shows a longer step; this also keeps the drawing's numbers finite.
    constexpr double kFarthest = 1e6;
    const double modulus = std::min(julia::elementary::exp(logModuli[i]), kFarthest);
    const julia::Point direction = embedding.point(versors[i]);
    const julia::Point end{modulus * direction[0], modulus * direction[1], modulus * direction[2]};
    // The ball of quaternions is cut by the space of the points at the slice.
    const double radius = std::sqrt(std::max(0.0, modulus * modulus - embedding.slice * embedding.slice));
    arrows.push_back({.from = positions[i],
                      .to = scene.field.space.toWorld(end),
                      .centre = scene.field.space.toWorld({0, 0, 0}),
                      .radius = radius * scene.field.space.scale,
                      .inside = field[i] < 0});
  }
  return arrows;
}

vdbtools::Image sliceOfScene(const Scene& scene, SliceField field, const SlicePlane& plane, double range,
                             vdbtools::Monitor& progress) {
  switch (field) {
    case SliceField::Phi:
      if (!scene.target) throw std::invalid_argument("there is no phi without a target");
      return vdbtools::signedSlice(plane, sampleGrid(plane, *scene.target->distances.phi, progress), range);
    case SliceField::Exponent:
      return vdbtools::signedSlice(plane,
                                   scene.exponent() ? sampleGrid(plane, *scene.exponent()->grid, progress)
                                                    : sampleFirstStep(plane, scene, progress),
                                   range);
    case SliceField::Field: return vdbtools::signedSlice(plane, sampleField(plane, scene, progress).field, range);
    case SliceField::Iterations:
      return vdbtools::countSlice(plane, sampleField(plane, scene, progress).iterations,
                                  scene.field.orbit.maxIterations);
    case SliceField::Versor: return vdbtools::versorSlice(plane, sampleVersor(plane, scene, progress));
    case SliceField::Membership:
    case SliceField::Grid: break;
  }
  return vdbtools::membershipSlice(plane, sampleField(plane, scene, progress).field);
}

vdbtools::SliceCodes layerOfScene(const Scene& scene, SliceField field, const SlicePlane& plane,
                                  const StackOptions& stack, vdbtools::Monitor& progress) {
  const auto signedLayer = [&](std::vector<float> values) {
    return vdbtools::signedCodes(plane, values, stack.range, stack.bits);
  };
  switch (field) {
    case SliceField::Phi: return signedLayer(sampleGrid(plane, *scene.target->distances.phi, progress));
    case SliceField::Exponent:
      return signedLayer(scene.exponent() ? sampleGrid(plane, *scene.exponent()->grid, progress)
                                          : sampleFirstStep(plane, scene, progress));
    case SliceField::Field: return signedLayer(sampleField(plane, scene, progress).field);
    case SliceField::Iterations:
      return vdbtools::countCodes(plane, sampleField(plane, scene, progress).iterations, stack.bits);
    case SliceField::Versor: return vdbtools::versorCodes(plane, sampleVersor(plane, scene, progress), stack.bits);
    case SliceField::Membership:
    case SliceField::Grid: break;
  }
  return vdbtools::membershipCodes(plane, sampleField(plane, scene, progress).field, stack.bits);
}

/// The meaning of the numbers of a stack, for the text beside it.
std::string meaningOf(SliceField field, const StackOptions& stack) {
  const std::string most = stack.bits == 8 ? "255" : "65535";
  switch (field) {
    case SliceField::Membership: return most + " inside, 0 outside";
    case SliceField::Iterations: return "steps of the orbit, at most " + most;
    case SliceField::Versor: return "three channels, 0 is -1 and " + most + " is 1";
    default: break;
  }
  const std::string range = vdbtools::numbersText({stack.range});
  return "0 is -" + range + " and " + most + " is " + range + ", negative inside";
}

struct NamedGrid {
  openvdb::FloatGrid::Ptr grid;
  openvdb::BBoxd frame;
};

/// The grid of a VDB, with the box of its active voxels.
NamedGrid gridToSlice(const std::string& input, const std::string& name) {
  NamedGrid result{vdbtools::chooseFloatGrid(vdbtools::readVdb(input), name, input), {}};
  const openvdb::CoordBBox active = result.grid->evalActiveVoxelBoundingBox();
  if (active.empty()) throw vdbtools::DataError("the grid '" + result.grid->getName() + "' is empty");
  result.frame = result.grid->transform().indexToWorld(openvdb::BBoxd(active.min().asVec3d(), active.max().asVec3d()));
  return result;
}

vdbtools::Image sliceOfScene(const Scene& scene, SliceField field, const PlanePlacement& placement, double range,
                             const std::vector<openvdb::Vec3d>& arrows, vdbtools::Monitor& progress) {
  const openvdb::BBoxd frame = vdbtools::sliceFrame(scene);
  const SlicePlane plane = placement.plane(frame, frame.getCenter());
  const std::vector<vdbtools::SliceArrow> steps =
      arrows.empty() ? std::vector<vdbtools::SliceArrow>() : arrowsFrom(arrows, scene);
  const vdbtools::Image image = sliceOfScene(scene, field, plane, range, progress);
  return steps.empty() ? image : vdbtools::withArrows(plane, image, steps);
}

vdbtools::Image sliceOfGrid(const std::string& input, const std::string& name, const PlanePlacement& placement,
                            double range, vdbtools::Monitor& progress) {
  const NamedGrid named = gridToSlice(input, name);
  const SlicePlane plane = placement.plane(named.frame, named.frame.getCenter());
  return vdbtools::signedSlice(plane, sampleGrid(plane, *named.grid, progress), range);
}

/// @param options  empty: the grid of a VDB
/// @param unit     of the input, if it is known
void writeStack(const CommandLine& line, const std::optional<vdbtools::FractalOptions>& options, SliceField field,
                const PlanePlacement& placement, const StackOptions& stack, std::optional<vdbtools::LengthUnit> unit) {
  StackWriter writer(line, options ? vdbtools::inputsOf(*options) : vdbtools::InputFiles(), stack);
  const std::string meaning = meaningOf(field, stack);
  if (!options) {
    const NamedGrid named = gridToSlice(line.text("input"), line.text("grid"));
    writer.write(placement, named.frame, meaning, unit, [&](const SlicePlane& plane, vdbtools::Monitor& progress) {
      return vdbtools::signedCodes(plane, sampleGrid(plane, *named.grid, progress), stack.range, stack.bits);
    });
    return;
  }
  const Scene scene = vdbtools::makeScene(*options, line.progress());
  if (field == SliceField::Phi && !scene.target) throw std::invalid_argument("there is no phi without a target");
  writer.write(placement, vdbtools::sliceFrame(scene), meaning,
               unit ? unit : vdbtools::unitOfTarget(scene.options.output.axes, scene.metadata),
               [&](const SlicePlane& plane, vdbtools::Monitor& progress) {
                 return layerOfScene(scene, field, plane, stack, progress);
               });
  tellTarget(scene.metadata);
}

/// Refuses options that do not apply to the grid of a VDB, whose voxels are shown unchanged.
void requireGridOptions(const CommandLine& line) {
  const std::string why = "it is for the fields of a fractal, and --field is grid; leave it out";
  for (const std::string& name : line.typedNames())
    line.requireUse(name == "grid" || name == "units", {name.c_str()}, why);
  line.requireUse(false, {"config", "search", "arrow"}, why);
}

/// The recipe of the shown fractal; empty for the grid of a VDB.
std::optional<vdbtools::FractalOptions> sliceRecipe(const CommandLine& line, SliceField field,
                                                    const std::string& input) {
  if (field == SliceField::Grid) return std::nullopt;
  const vdbtools::Recipe recipe = sceneRecipe(line, input);
  vdbtools::FractalOptions options = vdbtools::parseFractalOptions(recipe);
  std::set<vdbtools::Product> makes = {vdbtools::Product::Slice};
  if (line.has("stack")) makes.insert(vdbtools::Product::Stack);
  line.requireEffect({{recipe, makes}});
  return options;
}

}  // namespace

int runSlice(const Arguments& arguments) {
  CommandLine line(kSliceUsage, vdbtools::fractalOptionTable());
  line.addOptions()("output,o", po::value<std::string>()->value_name("F.png"), "the picture to write: .png or .exr")(
      "field", po::value<std::string>()->default_value("membership")->value_name("NAME"), "the field to show");
  addPlaneOptions(line, "its middle");
  line.addOptions()("range", po::value<std::string>()->value_name("R"),
                    "phi, e, f, grid: the value that is shown in full colour (default: chosen from the data)");
  line.addOptions()(
      "arrow", po::value<std::vector<std::string>>()->value_name("X,Y,Z"),
      "draw the first step from this point, in the target's units: an arrow to f(x), and the circle about "
      "the origin of the dynamics on which the texture places it. White if the point belongs to the set, "
      "black if not; any number of times");
  addStackOptions(line);
  addFramesOption(line);
  addSearchOption(line);
  if (!line.parse(arguments)) return kDone;
  const SliceField field = parseField(line);
  const PlanePlacement placement = parsePlacement(line);
  const double range = line.has("range") ? line.number("range") : 0;
  if (line.has("range") && !(range > 0)) line.refuse("range", "above 0");
  line.requireUse(isSigned(field), {"range"}, "it is for --field phi, e, f and grid; leave it out");
  const StackOptions stack = parseStack(line, field);
  std::vector<openvdb::Vec3d> arrows;
  for (const std::string& point : line.texts("arrow")) arrows.push_back(vdbtools::parseVector("arrow", point));
  const std::string input = line.text("input");
  if (field == SliceField::Grid) requireGridOptions(line);
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o F.png");
  if (field == SliceField::Grid && input.empty()) throw std::invalid_argument("no VDB was given");
  if (line.has("stack")) {
    line.requireUse(false, {"frames", "keep-going"}, "a --stack has a file for each layer of one shape; leave it out");
    writeStack(line, sliceRecipe(line, field, input), field, placement, stack,
               input.empty() ? std::nullopt : unitOf(line, input));
    return kDone;
  }
  return runFrames(line, input, kOnlyOutput, [&](const std::string& name) {
    const std::optional<vdbtools::FractalOptions> options = sliceRecipe(line, field, name);
    FrameJob job;
    if (options) job.inputs = vdbtools::inputsOf(*options);
    job.make = [&, name, options](const FrameRun& run) {
      std::ostream& file = run.outputs.add("output", line.text("output"), ".png .exr").stream();
      std::optional<Scene> scene;
      if (options) scene = vdbtools::makeScene(*options, run.monitor);
      const vdbtools::Image image = scene ? sliceOfScene(*scene, field, placement, range, arrows, run.monitor)
                                          : sliceOfGrid(name, line.text("grid"), placement, range, run.monitor);
      run.monitor.begin(vdbtools::PhaseKind::Writing, 0);
      file << vdbtools::encodeImage(image, formatOf(line.text("output"), ".png"));
      run.outputs.commit(run.isLast);
      report().count("width", image.width);
      report().count("height", image.height);
      report().text() << "wrote " << run.outputs.names() << ": " << image.width << " x " << image.height << '\n';
      if (scene) tellTarget(scene->metadata);
    };
    return job;
  });
}

}  // namespace cli
