// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"
#include "output.h"

#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/formats/versor_file.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/render/field_render.h"
#include "vdbtools/render/preview.h"

#include <charconv>
#include <chrono>
#include <iostream>
#include <memory>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kUsageText = {
    "render",
    "F.vdb -o F.png [--size WxH] [--azimuth DEG] [--elevation DEG] [options]\n"
    "       juliavdb render --field [MESH|SDF.vdb|FRACTAL.vdb] -o F.png [options]",
    "Makes a shaded picture of a level set, framed automatically. With --field it sends rays through a map itself "
    "instead\n"
    "of through a grid, which shows the set finer than any voxels. The map is that of a fractal that this program "
    "made, or\n"
    "is given by the options of 'fractal', with or without a target. An EXR then holds R, G, B (premultiplied, without "
    "a\n"
    "background), A, the normal N.x, N.y, N.z, the depth Z along the view axis (1e10 where there is nothing), and id.",
    "  juliavdb render bunny.vdb -o bunny.png\n"
    "  juliavdb render bunny.vdb -o back.exr --size 1280x720 --azimuth 200 --zoom 1.5\n"
    "  juliavdb render --field bunny.vdb -o field.png --size 400x400\n"
    "  juliavdb render --field --map cross --pair A -o triplex.png --size 400x400\n"
    "  juliavdb render --field --map quadratic --c=-0.2,0.6,0.2,0.2 --iterations 8 -o julia.exr --size 400x400\n"
    "  juliavdb render --field --map quadratic --c=-1,0.2,0,0 --iterations 8 -o turn.####.png --frames 2 --size "
    "200x200\n"};

/// Options that one way of rendering has and the other has not.
constexpr const char* kFieldOnly[] = {"eye",   "look-at", "up",     "epsilon", "alpha-clarity",
                                      "delta", "colour",  "frames", "no-skip"};
constexpr const char* kLevelSetOnly[] = {"roots"};

template <class Options>
void parseSize(const std::string& text, Options& options) {
  const char* end = text.data() + text.size();
  const auto [x, error] = std::from_chars(text.data(), end, options.width);
  const bool good = error == std::errc{} && x != end && *x == 'x';
  const auto [rest, second] = good ? std::from_chars(x + 1, end, options.height) : std::from_chars_result{x, error};
  if (!good || second != std::errc{} || rest != end || options.width < 1 || options.height < 1 ||
      options.width > 32768 || options.height > 32768)
    throw std::invalid_argument("--size is '" + text + "'; it must be WIDTHxHEIGHT, each 1 to 32768");
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

template <class Options>
void parseSamples(const CommandLine& line, Options& options) {
  if (!line.has("samples")) return;
  options.samples = line.choice<int>("samples", {{"1", 1}, {"4", 4}, {"9", 9}, {"16", 16}});
}

void requireFits(const CommandLine& line, bool field) {
  if (field) {
    for (const char* name : kLevelSetOnly)
      if (line.has(name)) throw std::invalid_argument(std::string("--") + name + " cannot be used with --field");
    return;
  }
  for (const char* name : kFieldOnly)
    if (line.has(name)) throw std::invalid_argument(std::string("--") + name + " can be used with --field only");
  for (const auto& [name, value] : line.givenRecipe())
    if (name != "input" && name != "grid") throw std::invalid_argument("--" + name + " can be used with --field only");
}

/// Angles, field of view and zoom, for either way of rendering.
vdbtools::ViewAngles parseAngles(const CommandLine& line) {
  vdbtools::ViewAngles angles;
  const auto number = [&](const char* name, double& value, double low, double high, const char* domain) {
    if (!line.has(name)) return;
    value = line.number(name);
    if (!(value >= low && value <= high)) line.refuse(name, domain);
  };
  number("azimuth", angles.azimuth, -1e6, 1e6, "-1e6 to 1e6 degrees");
  number("elevation", angles.elevation, -90, 90, "-90 to 90 degrees");
  number("fov", angles.fieldOfView, 1, 150, "1 to 150 degrees");
  number("zoom", angles.zoom, 1e-3, 1e3, "0.001 to 1000");
  return angles;
}

/// Where the eye is: at a given place, or at angles around the object that is framed.
struct View {
  std::optional<openvdb::Vec3d> eye, lookAt;
  std::optional<openvdb::Vec3d> up;
  vdbtools::ViewAngles angles;

  /// What a turntable turns about.
  openvdb::Vec3d axis() const { return up.value_or(vdbtools::Camera().up); }

  vdbtools::Camera camera(const vdbtools::Scene& scene, const openvdb::BBoxd& region, double aspect) const {
    vdbtools::Camera camera;
    camera.fieldOfView = angles.fieldOfView;
    if (!eye || !lookAt) camera = vdbtools::cameraAround(vdbtools::frameSet(scene.source(), region), angles, aspect);
    const openvdb::Vec3d arm = camera.eye - camera.lookAt;
    if (lookAt) camera.lookAt = *lookAt;
    camera.eye = eye ? *eye : camera.lookAt + arm;
    if (up) camera.up = *up;
    if ((camera.eye - camera.lookAt).length() == 0)
      throw std::invalid_argument("--eye and --look-at are the same point; move one of them");
    return camera;
  }
};

View parseView(const CommandLine& line) {
  View view;
  const auto vector = [&](const char* name) -> std::optional<openvdb::Vec3d> {
    if (!line.has(name)) return std::nullopt;
    return vdbtools::parseVector(name, line.text(name));
  };
  view.eye = vector("eye");
  view.lookAt = vector("look-at");
  view.up = vector("up");
  if (view.up && view.up->length() == 0) throw std::invalid_argument("--up is '0,0,0'; it must be a direction");
  for (const char* name : {"azimuth", "elevation", "zoom"})
    if (view.eye && line.has(name))
      throw std::invalid_argument(std::string("--eye and --") + name +
                                  " both set the position of the eye; give only one of them");
  view.angles = parseAngles(line);
  return view;
}

int renderLevelSet(const CommandLine& line) {
  const std::string input = line.text("input");
  if (input.empty()) throw std::invalid_argument("no VDB was given");
  vdbtools::PreviewOptions options;
  parseSize(line.text("size"), options);
  options.view = parseAngles(line);
  parseSamples(line, options);
  if (line.has("roots")) options.balls = ballsOf(line.text("roots"));
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o F.png");
  Outputs outputs;
  std::ostream& file = outputs.add("output", line.text("output"), ".png .exr").stream();
  const auto grid = vdbtools::chooseFloatGrid(vdbtools::readVdb(input), line.text("grid"), input);
  const vdbtools::Image image = vdbtools::renderPreview(*grid, options, line.progress());
  file << vdbtools::encodeImage(image, formatOf(line.text("output"), ".png"));
  outputs.commit();
  std::cerr << "wrote " << outputs.names() << ": " << image.width << " x " << image.height << '\n';
  return kDone;
}

vdbtools::FieldColour parseColour(const CommandLine& line) {
  using vdbtools::FieldColour;
  return line.choice<FieldColour>("colour", {{"direction", FieldColour::Direction},
                                             {"versor", FieldColour::Versor},
                                             {"iterations", FieldColour::Iterations},
                                             {"trap", FieldColour::Trap},
                                             {"clay", FieldColour::Clay}});
}

vdbtools::FieldRenderOptions parseFieldOptions(const CommandLine& line) {
  vdbtools::FieldRenderOptions options;
  parseSize(line.text("size"), options);
  parseSamples(line, options);
  if (line.has("colour")) options.colour = parseColour(line);
  if (line.has("epsilon")) {
    options.clarity.epsilon = line.number("epsilon");
    if (!(options.clarity.epsilon >= 1e-9)) line.refuse("epsilon", "at least 1e-9");
  }
  if (line.has("alpha-clarity")) {
    options.clarity.alpha = line.number("alpha-clarity");
    if (!(*options.clarity.alpha >= 0)) line.refuse("alpha-clarity", "at least 0");
  }
  if (line.has("delta")) options.clarity.delta = line.choice<int>("delta", {{"0", 0}, {"1", 1}, {"2", 2}});
  options.skip = !line.has("no-skip");
  return options;
}

/// The number of a turntable's frames; none for a single picture.
std::optional<int> parseFrames(const CommandLine& line) {
  constexpr int kMost = 100000;
  return line.has("frames") ? std::optional(line.integer("frames", 1, kMost)) : std::nullopt;
}

/// Renders one frame under a name of its own: "render, frame 3 of 24".
class FrameMonitor final : public vdbtools::Monitor {
 public:
  FrameMonitor(Progress& progress, std::string suffix) : mProgress(progress), mSuffix(std::move(suffix)) {}
  void begin(std::string_view phase, std::uint64_t total) override {
    mProgress.begin(std::string(phase) + mSuffix, total);
  }
  void advance(std::uint64_t steps) override { mProgress.advance(steps); }
  bool cancelled() const override { return mProgress.cancelled(); }

 private:
  Progress& mProgress;
  std::string mSuffix;
};

/// Where the rays go: the box that was asked for, or all of the set.
openvdb::BBoxd regionOf(const vdbtools::Scene& scene) {
  if (scene.options.lattice.box) return *scene.options.lattice.box;
  return scene.exponent ? vdbtools::meshBox(vdbtools::planScene(scene)) : scene.region;
}

int renderMap(const CommandLine& line) {
  const View view = parseView(line);
  vdbtools::FieldRenderOptions options = parseFieldOptions(line);
  const std::optional<int> frames = parseFrames(line);
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o F.png");
  const vdbtools::FractalOptions fractal = vdbtools::parseFractalOptions(sceneRecipe(line, line.text("input")));
  const std::string output = line.text("output"), format = formatOf(output, ".png");
  const auto claim = [&](Outputs& outputs) -> std::ostream& {
    return outputs.add("output", output, ".png .exr").stream();
  };
  const auto frameNumber = [&](int frame) { return frames ? std::optional(frame) : std::nullopt; };
  // The first place is claimed before the work begins, the others with their frames.
  auto outputs = std::make_unique<Outputs>(frameNumber(1));
  std::ostream* file = &claim(*outputs);

  const vdbtools::Scene scene = vdbtools::makeScene(fractal, line.progress());
  const openvdb::BBoxd region = regionOf(scene);
  const vdbtools::Camera camera = view.camera(scene, region, static_cast<double>(options.width) / options.height);
  options.orbit = scene.orbit;
  options.dropAxis = fractal.map->embedding().dropped;
  options.background = vdbtools::lowerCase(format) != ".exr";
  vdbtools::FieldRenderer renderer(scene.source(), region);
  const int count = frames.value_or(1);
  for (int frame = 1; frame <= count; ++frame) {
    if (frame > 1) {
      outputs = std::make_unique<Outputs>(frameNumber(frame));
      file = &claim(*outputs);
    }
    options.camera = vdbtools::turned(camera, view.axis(), 360.0 * (frame - 1) / count);
    FrameMonitor monitor(line.progress(),
                         frames ? ", frame " + std::to_string(frame) + " of " + std::to_string(count) : std::string());
    const auto start = std::chrono::steady_clock::now();
    const vdbtools::FieldImage image = renderer.render(options, monitor);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    *file << vdbtools::encodeFieldImage(image, format);
    outputs->commit();
    std::cerr << "wrote " << outputs->names() << ": " << options.width << " x " << options.height << ", " << image.rays
              << " rays, " << static_cast<std::uint64_t>(static_cast<double>(image.rays) / seconds.count())
              << " a second, " << image.evaluations << " samples evaluated\n";
  }
  return kDone;
}

}  // namespace

int runRender(const Arguments& arguments) {
  CommandLine line(kUsageText, vdbtools::fractalOptionTable());
  const auto text = [](const char* name) { return po::value<std::string>()->value_name(name); };
  line.addOptions()("output,o", text("F.png"), "the picture to write: .png or .exr")(
      "size", po::value<std::string>()->default_value("800x800")->value_name("WxH"), "pixels")(
      "azimuth", text("DEG"), "angle about the vertical axis, 0 being the front (default -30)")(
      "elevation", text("DEG"), "angle above the horizon (default 15)")(
      "fov", text("DEG"), "vertical field of view (default 30)")("samples", text("N"),
                                                                 "rays per pixel: 1, 4, 9 or 16 (default 4)")(
      "zoom", text("F"), "magnification: above 1 comes closer (default 1)")(
      "roots", text("F.json"),
      "show the roots of a map that 'juliavdb fit' made: top roots in blue, bottom roots in red")(
      "field", po::bool_switch(),
      "show the set of the map itself and not the level set of a VDB. The following options go with it:")(
      "eye", text("X,Y,Z"), "the position of the eye, in the target's units, instead of azimuth, elevation and zoom")(
      "look-at", text("X,Y,Z"), "the point in the middle of the picture (default: the middle of the set)")(
      "up", text("X,Y,Z"), "the direction that is up in the picture (default 0,1,0)")(
      "colour", text("NAME"),
      "what to colour by: direction (of the first step, as RGB; the default), versor, iterations, trap, or clay for "
      "none")("epsilon", text("E"), "the shortest step of a ray, in fractal space (default 5e-5)")(
      "alpha-clarity", text("A"),
      "the length of a ray's steps is A d^D at the distance d from the eye (default: as long as a pixel is wide)")(
      "delta", text("D"), "the exponent D: 0, 1 or 2 (default 1)")(
      "frames", text("N"), "make a turntable of N pictures, with names such as name.####.png")(
      "no-skip", po::value<std::string>()->implicit_value("true")->zero_tokens(),
      "evaluate every sample, even where the map is proved to be empty; for checking");
  if (!line.parse(arguments)) return kDone;
  const bool field = line.values()["field"].as<bool>();
  requireFits(line, field);
  return field ? renderMap(line) : renderLevelSet(line);
}

}  // namespace cli
