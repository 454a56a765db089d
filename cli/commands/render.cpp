// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"
#include "output.h"
#include "render_mesh.h"
#include "report.h"

#include "vdbtools/base/numbered_monitor.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/formats/versor_file.h"
#include "vdbtools/job/file_axes.h"
#include "vdbtools/job/scene_picture.h"
#include "vdbtools/mesh/mesh_writer.h"
#include "vdbtools/render/look.h"
#include "vdbtools/render/preview.h"
#include "vdbtools/render/view_options.h"

#include <array>
#include <chrono>
#include <memory>
#include <numeric>
#include <ostream>
#include <set>
#include <utility>
#include <vector>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kRenderUsage = {
    "render",
    "F.vdb|MESH -o F.png [--size WxH] [--azimuth DEG] [--elevation DEG] [options]\n"
    "       juliavdb render --field [MESH|SDF.vdb|FRACTAL.vdb] -o F.png [options]",
    "Makes a shaded picture of a level set or of a mesh, framed automatically. A mesh may be open, and has the "
    "colours\n"
    "of its points if they have any, or with --colour clay none. With --field it sends rays through a map itself "
    "instead\n"
    "of through a grid, which shows the set finer than any voxels. The map is that of a fractal that this program "
    "made, or\n"
    "is given by the options of 'fractal', with or without a target. An EXR then holds R, G, B (premultiplied, without "
    "a\n"
    "background), A, the normal N.x, N.y, N.z, the depth Z along the view axis (1e10 where there is nothing), and id.",
    "  juliavdb render bunny.vdb -o bunny.png\n"
    "  juliavdb render bunny.obj -o mesh.png --size 400x400\n"
    "  juliavdb render bunny.vdb -o back.exr --size 1280x720 --azimuth 200 --zoom 1.5\n"
    "  juliavdb render --field bunny.vdb -o field.png --size 400x400\n"
    "  juliavdb render --field --map cross --pair A -o triplex.png --size 400x400\n"
    "  juliavdb render --field --map quadratic --c=-0.2,0.6,0.2,0.2 --iterations 8 -o julia.exr --size 400x400\n"
    "  juliavdb render --field --map quadratic --c=-1,0.2,0,0 --iterations 8 -o turn.####.png --frames 2 --size "
    "200x200\n",
    "fractal",
    nullptr,
    "up"};

constexpr const char* kSize = "800x800";

/// What a picture of a level set or of a mesh can have.
const std::set<vdbtools::Pass> kSurfacePasses{vdbtools::Pass::Beauty, vdbtools::Pass::Normal, vdbtools::Pass::Depth,
                                              vdbtools::Pass::Albedo, vdbtools::Pass::Ao,     vdbtools::Pass::Id};

std::vector<vdbtools::OptionSpec> lookAndPassesSpecs() {
  std::vector<vdbtools::OptionSpec> options = vdbtools::lookOptionSpecs();
  options.push_back(vdbtools::passesOptionSpec());
  return options;
}

std::vector<vdbtools::OptionSpec> surfaceOptionSpecs() {
  std::vector<vdbtools::OptionSpec> options = vdbtools::viewOptionSpecs(kSize);
  for (vdbtools::OptionSpec& option : lookAndPassesSpecs()) options.push_back(std::move(option));
  return options;
}

std::vector<vdbtools::PreviewBall> ballsOf(const std::string& name) {
  constexpr double kRadius = 0.008;  // of the target's longest side
  const vdbtools::RationalFile file = vdbtools::readRationalFile(name);
  if (!file.target)
    throw std::invalid_argument("'" + name +
                                "' does not say where its roots lie in the world; a file made by 'juliavdb fit' does");
  const vdbtools::FractalSpace& space = file.target->space;
  std::vector<vdbtools::PreviewBall> balls;
  const auto add = [&](const julia::Polynomial& polynomial, const std::array<float, 3>& colour) {
    for (const julia::Root& root : polynomial.roots) {
      const julia::Quaternion<double>& t = root.position;
      balls.push_back({space.toWorld({t.a, t.b, t.c}), kRadius * space.scale, colour});
    }
  };
  add(file.rational.top, {0.02f, 0.12f, 0.75f});
  add(file.rational.bottom, {0.75f, 0.03f, 0.02f});
  return balls;
}

/// Refuses the options that only the other way of rendering has.
void requireFits(const CommandLine& line, bool field) {
  if (field) {
    if (line.has("roots")) throw std::invalid_argument("--roots cannot be used with --field");
    return;
  }
  vdbtools::Recipe given = line.given(vdbtools::OptionTable(vdbtools::fieldViewOptionSpecs()));
  for (const char* option : {"frames", "search"})
    if (line.has(option)) given[option] = "";
  given.insert(line.givenRecipe().begin(), line.givenRecipe().end());
  if (isMesh(line.text("input"))) {
    if (given.contains("grid")) throw std::invalid_argument("--grid chooses a grid of a VDB, and a mesh has none");
    given.erase("colour");
  }
  for (const auto& [name, value] : given)
    if (name != "input" && name != "grid") throw std::invalid_argument("--" + name + " can be used with --field only");
}

/// A picture of a level set or of a mesh.
int renderSurface(const CommandLine& line) {
  const std::string input = line.text("input");
  if (input.empty()) throw std::invalid_argument("no VDB and no mesh was given");
  const vdbtools::OptionTable table(surfaceOptionSpecs());
  const vdbtools::RecipeReader reader(line.given(table), table);
  const vdbtools::ViewOptions view = vdbtools::parseViewOptions(reader);
  vdbtools::PreviewOptions options{.width = view.width,
                                   .height = view.height,
                                   .samples = view.samples,
                                   .view = view.angles,
                                   .look = vdbtools::parseLook(reader),
                                   .passes = vdbtools::parsePasses(reader, kSurfacePasses, vdbtools::kUsualPasses)};
  if (view.up) throw std::invalid_argument("--up X,Y,Z can be used with --field only; give y or z");
  if (line.has("roots")) options.balls = ballsOf(line.text("roots"));
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o F.png");
  vdbtools::InputFiles inputs;
  if (line.has("roots")) inputs.add(line.text("roots"));
  Outputs outputs(line, std::move(inputs));
  std::ostream& file = outputs.add("output", line.text("output"), ".png .exr").stream();
  const bool mesh = isMesh(input);
  const vdbtools::VdbFile vdb = mesh ? vdbtools::VdbFile() : vdbtools::readVdb(input);
  options.up =
      view.upAxis ? *view.upAxis : vdbtools::recordedUpAxis(mesh ? vdbtools::readMeshComments(input) : vdb.metadata);
  const std::string format = formatOf(line.text("output"), ".png");
  const bool isExr = vdbtools::lowerCase(format) == ".exr";
  if (!isExr && line.has("passes"))
    throw std::invalid_argument("--passes are layers of an EXR; give -o a name that ends in .exr, or leave it out");
  if (!isExr) options.passes = {vdbtools::Pass::Beauty};
  // Compositors put their own background behind an EXR.
  if (isExr && options.look.backdrop == vdbtools::Backdrop::Neutral) options.look.backdrop = vdbtools::Backdrop::None;
  const vdbtools::ShadedImage image =
      mesh ? imageOfMesh(line, options)
           : vdbtools::renderPreview(*vdbtools::chooseFloatGrid(vdb, line.text("grid"), input), options,
                                     line.progress());
  line.progress().begin("writing", 0);
  file << vdbtools::encodeShadedImage(image, format, options.look.backdrop == vdbtools::Backdrop::None, options.passes);
  outputs.commit();
  report().count("width", view.width);
  report().count("height", view.height);
  report().text() << "wrote " << outputs.names() << ": " << view.width << " x " << view.height << '\n';
  return kDone;
}

/// The number of a turntable's frames; none for a single picture.
std::optional<int> parseFrames(const CommandLine& line) {
  constexpr int kMost = 100000;
  return line.has("frames") ? std::optional(line.integer("frames", 1, kMost)) : std::nullopt;
}

int renderMap(const CommandLine& line) {
  const vdbtools::OptionTable table(vdbtools::fieldPictureOptionSpecs(kSize));
  const vdbtools::FieldPicture picture = vdbtools::parseFieldPicture(line.given(table), table);
  const std::optional<int> frames = parseFrames(line);
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o F.png");
  const vdbtools::Recipe recipe = sceneRecipe(line, line.text("input"));
  const vdbtools::FractalOptions fractal = vdbtools::parseFractalOptions(recipe);
  line.requireEffect({{recipe, {vdbtools::Product::Picture}}});
  const std::string output = line.text("output"), format = formatOf(output, ".png");
  const vdbtools::InputFiles inputs = vdbtools::inputsOf(fractal);
  const int count = frames.value_or(1);
  if (frames) {
    std::vector<int> numbers(static_cast<std::size_t>(count));
    std::iota(numbers.begin(), numbers.end(), 1);
    requireFramePlaces(line, inputs, std::array{"output"}, numbers);
  }
  const auto claim = [&](Outputs& outputs) -> std::ostream& {
    return outputs.add("output", output, ".png .exr").stream();
  };
  const auto frameNumber = [&](int frame) { return frames ? std::optional(frame) : std::nullopt; };
  // The first place is claimed before the work begins, the others with their frames.
  auto outputs = std::make_unique<Outputs>(line, inputs, frameNumber(1));
  std::ostream* file = &claim(*outputs);

  const vdbtools::Scene scene = vdbtools::makeScene(fractal, line.progress());
  const openvdb::BBoxd region = vdbtools::pictureRegion(scene);
  vdbtools::FieldRenderOptions options = vdbtools::pictureOptions(scene, region, picture);
  const vdbtools::Camera camera = options.camera;
  options.background = vdbtools::lowerCase(format) != ".exr";
  vdbtools::FieldRenderer renderer(scene.source(), region);
  for (int frame = 1; frame <= count; ++frame) {
    if (frame > 1) {
      outputs = std::make_unique<Outputs>(line, inputs, frameNumber(frame));
      file = &claim(*outputs);
    }
    options.camera =
        vdbtools::turned(camera, picture.view.axis(fractal.output.axes.target), 360.0 * (frame - 1) / count);
    std::optional<vdbtools::NumberedMonitor> numbered;
    if (frames)
      numbered.emplace(line.progress(), "frame", static_cast<std::size_t>(frame), static_cast<std::size_t>(count));
    vdbtools::Monitor& monitor = numbered ? static_cast<vdbtools::Monitor&>(*numbered) : line.progress();
    const auto start = std::chrono::steady_clock::now();
    const vdbtools::FieldImage image = renderer.render(options, monitor);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    monitor.begin("writing", 0);
    *file << vdbtools::encodeFieldImage(image, format);
    outputs->commit(frame == count);
    if (frame == count) {
      report().count("width", options.width);
      report().count("height", options.height);
      report().count("frames", count);
    }
    report().text() << "wrote " << outputs->names() << ": " << options.width << " x " << options.height << ", "
                    << image.rays << " rays, "
                    << static_cast<std::uint64_t>(static_cast<double>(image.rays) / seconds.count()) << " a second, "
                    << image.evaluations << " samples evaluated\n";
  }
  return kDone;
}

}  // namespace

int runRender(const Arguments& arguments) {
  CommandLine line(kRenderUsage, vdbtools::fractalOptionTable());
  const auto text = [](const char* name) { return po::value<std::string>()->value_name(name); };
  line.addOptions()("output,o", text("F.png"), "the picture to write: .png or .exr");
  line.addOptions(vdbtools::viewOptionSpecs(kSize));
  line.addOptions(lookAndPassesSpecs());
  line.addOptions()("roots", text("F.json"),
                    "show the roots of a map that 'juliavdb fit' made: top roots in blue, bottom roots in red")(
      "field", po::bool_switch(),
      "show the set of the map itself and not the level set of a VDB. The following options go with it:")(
      "frames", text("N"), "make a turntable of N pictures, with names such as name.####.png");
  line.addOptions(vdbtools::fieldViewOptionSpecs());
  addSearchOption(line);
  if (!line.parse(arguments)) return kDone;
  const bool field = line.values()["field"].as<bool>();
  requireFits(line, field);
  return field ? renderMap(line) : renderSurface(line);
}

}  // namespace cli
