// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"
#include "output.h"
#include "report.h"
#include "slice_plane.h"

#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/picture/slice_image.h"

#include <openvdb/tools/Interpolation.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <optional>
#include <ostream>

namespace po = boost::program_options;

namespace cli {
namespace {

using vdbtools::Scene;
using vdbtools::SlicePlane;

constexpr Usage kSliceUsage = {
    "slice",
    "MESH|SDF.vdb|FRACTAL.vdb -o F.png [--field phi|e|f|membership|iterations|versor|grid] [--axis x|y|z] "
    "[options]",
    "Makes a picture of a field on a plane. For a fractal that this program made, the options come from its recipe; "
    "for a\n"
    "mesh or a signed distance, they are those of 'fractal'.\n"
    "\n"
    "  phi         the target's signed distance: blue inside, red outside, the surface dark\n"
    "  e           the exponent of the shape modulus, in the same colours\n"
    "  f           the log-modulus after the last step, in the same colours; also called logmodulus\n"
    "  membership  the fractal itself: black inside\n"
    "  iterations  how many steps the orbit took, from white (none) to black (all of them)\n"
    "  versor      the direction of the map as RGB\n"
    "  grid        the voxels of a VDB as they are",
    "  juliavdb slice bunny.vdb -o membership.png --field membership\n"
    "  juliavdb slice bunny.vdb -o versor.png --field versor --axis x\n"
    "  juliavdb slice bunny.obj -o e.exr --field e --alpha 40 --position 0.1 --size 400\n"};

enum class SliceField { Phi, Exponent, Field, Membership, Iterations, Versor, Grid };

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

/// A row of pixels at a time, in threads.
template <class Row>
void forEachRow(const SlicePlane& plane, Progress& progress, const Row& row) {
  progress.begin("slice", static_cast<std::uint64_t>(plane.height()));
  tbb::parallel_for(0, plane.height(), [&](int y) {
    if (progress.cancelled()) return;
    row(y);
    progress.advance(1);
  });
  progress.throwIfCancelled();
}

std::vector<julia::Point> pointsOfRow(const SlicePlane& plane, int y, const vdbtools::FractalSpace& space) {
  std::vector<julia::Point> points;
  for (int x = 0; x < plane.width(); ++x) points.push_back(space.toFractal(plane.position(x, y)));
  return points;
}

std::size_t rowStart(const SlicePlane& plane, int y) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(plane.width());
}

std::vector<float> sampleGrid(const SlicePlane& plane, const openvdb::FloatGrid& grid, Progress& progress) {
  std::vector<float> values(rowStart(plane, plane.height()));
  forEachRow(plane, progress, [&](int y) {
    const auto accessor = grid.getConstAccessor();
    for (int x = 0; x < plane.width(); ++x)
      values[rowStart(plane, y) + static_cast<std::size_t>(x)] =
          openvdb::tools::BoxSampler::sample(accessor, grid.worldToIndex(plane.position(x, y)));
  });
  return values;
}

struct FieldSamples {
  std::vector<float> field;
  std::vector<int> iterations;
};

FieldSamples sampleField(const SlicePlane& plane, const Scene& scene, Progress& progress) {
  FieldSamples samples;
  samples.field.resize(rowStart(plane, plane.height()));
  samples.iterations.resize(samples.field.size());
  forEachRow(plane, progress, [&](int y) {
    const std::vector<julia::Point> points = pointsOfRow(plane, y, scene.space);
    std::vector<double> field(points.size());
    const std::size_t start = rowStart(plane, y);
    scene.evaluator->evaluate(points, field, std::span(samples.iterations).subspan(start, points.size()));
    std::transform(field.begin(), field.end(), samples.field.begin() + static_cast<std::ptrdiff_t>(start),
                   [](double value) { return static_cast<float>(value); });
  });
  return samples;
}

std::vector<openvdb::Vec3s> sampleVersor(const SlicePlane& plane, const Scene& scene, Progress& progress) {
  std::vector<openvdb::Vec3s> values(rowStart(plane, plane.height()));
  forEachRow(plane, progress, [&](int y) {
    const std::vector<julia::Point> points = pointsOfRow(plane, y, scene.space);
    const std::vector<openvdb::Vec3s> versors = scene.source().versorVectors(points);
    std::copy(versors.begin(), versors.end(), values.begin() + static_cast<std::ptrdiff_t>(rowStart(plane, y)));
  });
  return values;
}

vdbtools::Image sliceOfScene(const Scene& scene, SliceField field, const PlanePlacement& placement, double range,
                             Progress& progress) {
  const openvdb::BBoxd frame = frameOf(scene);
  const SlicePlane plane = placement.plane(frame, frame.getCenter());
  const auto need = [](bool there, const char* what) {
    if (!there) throw std::invalid_argument(std::string("there is no ") + what + " without a target");
  };
  switch (field) {
    case SliceField::Phi:
      need(scene.target.has_value(), "phi");
      return vdbtools::signedSlice(plane, sampleGrid(plane, *scene.target->phi, progress), range);
    case SliceField::Exponent:
      need(scene.exponent.has_value(), "exponent");
      return vdbtools::signedSlice(plane, sampleGrid(plane, *scene.exponent->grid, progress), range);
    case SliceField::Field: return vdbtools::signedSlice(plane, sampleField(plane, scene, progress).field, range);
    case SliceField::Iterations:
      return vdbtools::countSlice(plane, sampleField(plane, scene, progress).iterations, scene.orbit.maxIterations);
    case SliceField::Versor: return vdbtools::versorSlice(plane, sampleVersor(plane, scene, progress));
    case SliceField::Membership:
    case SliceField::Grid: break;
  }
  return vdbtools::membershipSlice(plane, sampleField(plane, scene, progress).field);
}

vdbtools::Image sliceOfGrid(const std::string& input, const std::string& name, const PlanePlacement& placement,
                            double range, Progress& progress) {
  const auto grid = vdbtools::chooseFloatGrid(vdbtools::readVdb(input), name, input);
  const openvdb::CoordBBox active = grid->evalActiveVoxelBoundingBox();
  if (active.empty()) throw vdbtools::DataError("the grid '" + grid->getName() + "' is empty");
  const openvdb::BBoxd frame =
      grid->transform().indexToWorld(openvdb::BBoxd(active.min().asVec3d(), active.max().asVec3d()));
  const SlicePlane plane = placement.plane(frame, frame.getCenter());
  return vdbtools::signedSlice(plane, sampleGrid(plane, *grid, progress), range);
}

/// The voxels of a VDB are shown as they are.
void requireGridOptions(const CommandLine& line) {
  const std::string why = "it is for the fields of a fractal, and --field is grid; leave it out";
  for (const std::string& name : line.typedNames()) line.requireUse(name == "grid", {name.c_str()}, why);
  line.requireUse(false, {"config", "search"}, why);
}

}  // namespace

int runSlice(const Arguments& arguments) {
  CommandLine line(kSliceUsage, vdbtools::fractalOptionTable());
  line.addOptions()("output,o", po::value<std::string>()->value_name("F.png"), "the picture to write: .png or .exr")(
      "field", po::value<std::string>()->default_value("membership")->value_name("NAME"), "the field to show");
  addPlaneOptions(line, "its middle");
  line.addOptions()("range", po::value<std::string>()->value_name("R"),
                    "phi, e, f, grid: the value that is shown in full colour (default: chosen from the data)");
  addSearchOption(line);
  if (!line.parse(arguments)) return kDone;
  const SliceField field = parseField(line);
  const PlanePlacement placement = parsePlacement(line);
  const double range = line.has("range") ? line.number("range") : 0;
  if (line.has("range") && !(range > 0)) line.refuse("range", "above 0");
  const bool isSigned =
      field != SliceField::Membership && field != SliceField::Iterations && field != SliceField::Versor;
  line.requireUse(isSigned, {"range"}, "it is for --field phi, e, f and grid; leave it out");
  const std::string input = line.text("input");
  if (field == SliceField::Grid) requireGridOptions(line);
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o F.png");
  if (field == SliceField::Grid && input.empty()) throw std::invalid_argument("no VDB was given");
  std::optional<vdbtools::FractalOptions> options;
  if (field != SliceField::Grid) {
    const vdbtools::Recipe recipe = sceneRecipe(line, input);
    options = vdbtools::parseFractalOptions(recipe);
    line.requireEffect({{recipe, {vdbtools::Product::Slice}}});
  }
  Outputs outputs(line, options ? vdbtools::inputsOf(*options) : vdbtools::InputFiles());
  std::ostream& file = outputs.add("output", line.text("output"), ".png .exr").stream();
  const vdbtools::Image image =
      options ? sliceOfScene(vdbtools::makeScene(*options, line.progress()), field, placement, range, line.progress())
              : sliceOfGrid(input, line.text("grid"), placement, range, line.progress());
  line.progress().begin("writing", 0);
  file << vdbtools::encodeImage(image, formatOf(line.text("output"), ".png"));
  outputs.commit();
  report().count("width", image.width);
  report().count("height", image.height);
  report().text() << "wrote " << outputs.names() << ": " << image.width << " x " << image.height << '\n';
  return kDone;
}

}  // namespace cli
