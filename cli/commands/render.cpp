// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"
#include "output.h"
#include "report.h"
#include "scene_recipe.h"
#include "sequence.h"
#include "target_text.h"

#include "vdbtools/farm/plans.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/frames.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/formats/versor_file.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/records/recorded_recipe.h"
#include "vdbtools/render/look.h"
#include "vdbtools/render/preview.h"
#include "vdbtools/render/view_options.h"
#include "vdbtools/scene/file_axes.h"
#include "vdbtools/scene/scene.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <ostream>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace po = boost::program_options;

namespace cli {
namespace {

/// Whether an input is a mesh and not a VDB.
bool isMesh(const std::string& input) { return !input.empty() && !vdbtools::isVdbPath(input); }

/// The picture of a mesh.
/// @throw std::invalid_argument  a value of --colour that a mesh does not have; what reading the mesh throws
vdbtools::ShadedImage imageOfMesh(const CommandLine& line, const std::string& input,
                                  const vdbtools::PreviewOptions& picture, vdbtools::Monitor& monitor) {
  if (line.has("colour") && line.text("colour") != "clay")
    line.refuse("colour", "clay for a mesh, or left out for the colours that the mesh itself has");
  monitor.begin(vdbtools::PhaseKind::Reading, 0);
  vdbtools::Mesh mesh = vdbtools::readMesh(input);
  return vdbtools::renderMeshPreview(std::move(mesh), {.picture = picture, .colours = !line.has("colour")}, monitor);
}

constexpr Usage kRenderUsage = {
    "render",
    "F.vdb|MESH -o F.png [--size WxH] [--azimuth DEG] [--elevation DEG] [options]\n"
    "       juliavdb render --field [MESH|SDF.vdb|FRACTAL.vdb] -o F.png [options]",
    "Makes a shaded picture of a level set or of a mesh, framed automatically. A mesh may be open, and has the colours "
    "of its points if they have any, or with --colour clay none. With --field it sends rays through a map itself "
    "instead of through a grid, which shows the set finer than any voxels. The map is that of a fractal that this "
    "program made, or is given by the options of 'fractal', with or without a target. An EXR then holds R, G, B "
    "(premultiplied, without a background), A, the normal N.x, N.y, N.z, the depth Z along the view axis (1e10 where "
    "there is nothing), and id.",
    "  juliavdb render bunny.vdb -o bunny.png\n"
    "  juliavdb render bunny.obj -o mesh.png --size 400x400\n"
    "  juliavdb render bunny.vdb -o back.exr --size 1280x720 --azimuth 200 --zoom 1.5\n"
    "  juliavdb render --field bunny.vdb -o field.png --size 400x400\n"
    "  juliavdb render --field --map cross --pair A -o triplex.png --size 400x400\n"
    "  juliavdb render --field --map quadratic --c=-0.2,0.6,0.2,0.2 --iterations 8 -o julia.exr --size 400x400\n"
    "  juliavdb render --field --map quadratic --c=-1,0.2,0,0 --iterations 8 -o turn.####.png --frames 1-2 --turn 360 "
    "--size 200x200\n",
    "fractal",
    nullptr,
    "up"};

constexpr const char* kSize = "800x800";

/// The passes that pictures of level sets and meshes support.
const std::set<vdbtools::Pass> kSurfacePasses{vdbtools::Pass::Beauty, vdbtools::Pass::Normal, vdbtools::Pass::Depth,
                                              vdbtools::Pass::Albedo, vdbtools::Pass::Ao,     vdbtools::Pass::Id};

/// The passes that pictures of a map's set support.
const std::set<vdbtools::Pass> kFieldPasses = [] {
  std::set<vdbtools::Pass> passes = kSurfacePasses;
  passes.insert(vdbtools::Pass::Trap);
  return passes;
}();

std::vector<vdbtools::OptionSpec> lookAndPassesSpecs() {
  std::vector<vdbtools::OptionSpec> options = vdbtools::lookOptionSpecs();
  options.push_back(vdbtools::passesOptionSpec());
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

/// The options of the camera, the light and the passes, in one table.
vdbtools::OptionTable pictureTable(bool field) {
  std::vector<vdbtools::OptionSpec> options = vdbtools::pictureOptionSpecs(kSize, field);
  options.push_back(vdbtools::passesOptionSpec());
  return vdbtools::OptionTable(std::move(options));
}

/// Those of them that may change from frame to frame.
vdbtools::OptionTable keyTable(bool field) {
  std::vector<vdbtools::OptionSpec> options = vdbtools::pictureOptionSpecs(kSize, field);
  std::erase_if(options, [](const vdbtools::OptionSpec& option) { return !vdbtools::isAppearance(option.name); });
  return vdbtools::OptionTable(std::move(options));
}

/// Refuses options that only the other way of rendering supports.
void requireFits(const CommandLine& line, bool field) {
  if (field) {
    if (line.has("roots")) throw std::invalid_argument("--roots cannot be used with --field");
    return;
  }
  vdbtools::Recipe given = line.given(vdbtools::OptionTable(vdbtools::fieldViewOptionSpecs()));
  if (line.has("search")) given["search"] = "";
  given.insert(line.givenRecipe().begin(), line.givenRecipe().end());
  if (isMesh(line.text("input"))) {
    if (given.contains("grid")) throw std::invalid_argument("--grid chooses a grid of a VDB, and a mesh has none");
    given.erase("colour");
  }
  for (const auto& [name, value] : given)
    if (name != "input" && name != "grid") throw std::invalid_argument("--" + name + " can be used with --field only");
}

/// A picture to take: a still, or a frame of a sequence.
struct Shot {
  std::optional<int> frame;
  vdbtools::Recipe view;  ///< options of pictureTable(): the given ones, and those of the keys
  double turn = 0;        ///< degrees by which the camera has turned
  std::string input;

  bool isAs(const Shot& other) const { return view == other.view && turn == other.turn && input == other.input; }
};

/// Refuses the form of a turntable before version 1, when --frames was a count.
void requireNoCount(const CommandLine& line, bool field, const std::vector<int>& frames) {
  if (!field || frames.size() != 1 || frames.front() < 2 || line.has("turn") || line.has("key")) return;
  const std::string text = line.text("frames");
  if (vdbtools::hasFramePattern(line.text("input")) || text.find_first_not_of("0123456789") != std::string::npos)
    return;
  throw std::invalid_argument("--frames " + text + " is frame " + text + " alone, and no count; write --frames 1-" +
                              text + " --turn 360 for a turntable of " + text + " frames, or --frames " + text + '-' +
                              text + " for that frame");
}

/// The pictures to take, in the order in which they are made.
/// @throw vdbtools::MissingInputError  the input of a frame is missing
std::vector<Shot> shotsOf(const CommandLine& line, bool field) {
  const std::string input = line.text("input");
  const vdbtools::Recipe given = line.given(pictureTable(field));
  // A cell of a sheet is shown in its own view.
  const vdbtools::Recipe base =
      field && line.has("config") ? vdbtools::readRecordedView(line.text("config")) : vdbtools::Recipe();
  line.requireUse(line.has("frames"), {"turn", "key", "ease"}, "it goes with --frames; give that too, or leave it out");
  line.requireUse(line.has("key"), {"ease"}, "it goes with --key; give that too, or leave it out");
  const std::vector<int> frames = framesOf(line, kOnlyOutput);
  if (frames.empty()) return {{std::nullopt, vdbtools::overriddenView(base, given), 0, input}};
  requireNoCount(line, field, frames);
  const bool isSequence = vdbtools::hasFramePattern(input);
  constexpr double kMostDegrees = 1e6;
  const double turn = line.has("turn") ? line.number("turn") : 0;
  if (line.has("turn") && !(turn != 0 && std::abs(turn) <= kMostDegrees))
    line.refuse("turn", "degrees other than 0, such as 360");
  const std::vector<vdbtools::farm::KeyedOption> keys =
      vdbtools::farm::parseKeys(line.texts("key"), line.texts("ease"), keyTable(field));
  for (const vdbtools::farm::KeyedOption& keyed : keys)
    if (given.contains(keyed.name))
      throw std::invalid_argument("--" + keyed.name + " is given and has keys; give only one of them");
  std::vector<int> inTime = frames;
  std::sort(inTime.begin(), inTime.end());
  vdbtools::FrameInputs inputs;
  std::vector<Shot> shots;
  for (const int frame : frames) {
    Shot shot{frame, given, 0, isSequence ? vdbtools::expandFrame(input, frame) : input};
    if (!input.empty()) inputs.add(shot.input, frame);
    for (const vdbtools::farm::KeyedOption& keyed : keys) shot.view[keyed.name] = vdbtools::farm::valueAt(keyed, frame);
    // In the order of time, whatever the order of the list.
    const auto before = std::lower_bound(inTime.begin(), inTime.end(), frame) - inTime.begin();
    shot.view = vdbtools::overriddenView(base, shot.view);
    shot.turn = turn * static_cast<double>(before) / static_cast<double>(frames.size());
    shots.push_back(std::move(shot));
  }
  inputs.requireNoneMissing();
  return shots;
}

/// The light and the passes of a picture.
struct Layers {
  vdbtools::Look look;
  std::set<vdbtools::Pass> passes;
  bool alpha = false;  ///< whether a PNG has an alpha channel
};

Layers layersOf(const vdbtools::RecipeReader& reader, const std::string& format,
                const std::set<vdbtools::Pass>& possible) {
  Layers layers{vdbtools::parseLook(reader), vdbtools::parsePasses(reader, possible, vdbtools::kUsualPasses)};
  if (vdbtools::lowerCase(format) != ".exr") {
    if (reader.has("passes"))
      throw std::invalid_argument("--passes are layers of an EXR; give -o a name that ends in .exr, or leave it out");
    layers.passes = {vdbtools::Pass::Beauty};
  } else if (layers.look.backdrop == vdbtools::Backdrop::Neutral) {
    // Compositors put their own background behind an EXR.
    layers.look.backdrop = vdbtools::Backdrop::None;
  }
  layers.alpha = layers.look.backdrop == vdbtools::Backdrop::None;
  return layers;
}

/// A finished picture.
struct Picture {
  vdbtools::ShadedImage image;
  std::string more;                               ///< what the summary says after the picture's size
  std::map<std::string, std::string> metadata{};  ///< of the scene, if the picture is of one
};

/// Makes the picture of a shot. @param shot  its index in the list
using PictureMaker = std::function<Picture(std::size_t shot, vdbtools::Monitor& monitor)>;

/// Makes the pictures one after another. All paths are checked before the first picture is made.
class Shooting {
 public:
  /// @param inputs  in addition to the command's own
  Shooting(const CommandLine& line, const std::vector<Shot>& shots, vdbtools::InputFiles inputs, std::string format)
      : mLine(line), mShots(shots), mInputs(std::move(inputs)), mFormat(std::move(format)) {
    for (const Shot& shot : shots) {
      if (!shot.input.empty()) mInputs.add(shot.input);
      if (shot.frame) mFrames.push_back(*shot.frame);
    }
    if (!mFrames.empty()) requireFramePlaces(line, mInputs, kOnlyOutput, mFrames);
  }

  /// @param layers  for each shot @return the exit code
  int make(const std::vector<Layers>& layers, const PictureMaker& pictureOf) const {
    if (mFrames.empty()) {
      makeOne(0, layers.front(), pictureOf, true, mLine.progress());
      report().count("frames", 1);
      return kDone;
    }
    std::optional<std::size_t> before;
    bool areEqual = true;
    const SequenceCounts counts =
        makeSequence(mLine, mFrames, [&](std::size_t i, bool isLast, vdbtools::Monitor& monitor) {
          monitor.throwIfCancelled();
          const bool isEqual = before && mShots[i].isAs(mShots[*before]);
          areEqual = areEqual && (isEqual || i == 0);
          if (!isEqual || !copyFrame(mLine, kOnlyOutput, mFrames[*before], mFrames[i], isLast))
            makeOne(i, layers[i], pictureOf, isLast, monitor);
          before = i;
          report().noteKept("finished frames are kept");
          return FrameOutcome::Made;
        });
    if (areEqual) noteEqualFrames(mFrames.size());
    return finishSequence(counts, /*keeps=*/false);
  }

 private:
  void makeOne(std::size_t shot, const Layers& layers, const PictureMaker& pictureOf, bool isLast,
               vdbtools::Monitor& monitor) const {
    // The path is claimed before the work begins.
    Outputs outputs(mLine, mInputs, mShots[shot].frame);
    std::ostream& file = outputs.add("output", mLine.text("output"), ".png .exr").stream();
    const Picture picture = pictureOf(shot, monitor);
    monitor.begin(vdbtools::PhaseKind::Writing, 0);
    file << vdbtools::encodeShadedImage(picture.image, mFormat, layers.alpha, layers.passes);
    outputs.commit(isLast);
    report().count("width", picture.image.beauty.width);
    report().count("height", picture.image.beauty.height);
    report().text() << "wrote " << outputs.names() << ": " << picture.image.beauty.width << " x "
                    << picture.image.beauty.height << picture.more << '\n';
    tellTarget(picture.metadata);
  }

  const CommandLine& mLine;
  const std::vector<Shot>& mShots;
  vdbtools::InputFiles mInputs;
  std::string mFormat;
  std::vector<int> mFrames;
};

std::string requireOutput(const CommandLine& line) {
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o F.png");
  return formatOf(line.text("output"), ".png");
}

/// Makes pictures of level sets or of meshes.
int renderSurface(const CommandLine& line) {
  if (line.text("input").empty()) throw std::invalid_argument("no VDB and no mesh was given");
  const std::vector<Shot> shots = shotsOf(line, false);
  const vdbtools::OptionTable table = pictureTable(false);
  std::vector<vdbtools::ViewOptions> views;
  std::vector<Layers> layers;
  const std::vector<vdbtools::PreviewBall> balls =
      line.has("roots") ? ballsOf(line.text("roots")) : std::vector<vdbtools::PreviewBall>();
  const std::string format = requireOutput(line);
  for (const Shot& shot : shots) {
    const vdbtools::RecipeReader reader(shot.view, table);
    views.push_back(vdbtools::parseViewOptions(reader));
    layers.push_back(layersOf(reader, format, kSurfacePasses));
    if (views.back().up) throw std::invalid_argument("--up X,Y,Z can be used with --field only; give y or z");
  }
  vdbtools::InputFiles inputs;
  if (line.has("roots")) inputs.add(line.text("roots"));
  std::optional<vdbtools::VdbFile> vdb;
  std::string vdbName;
  return Shooting(line, shots, std::move(inputs), format).make(layers, [&](std::size_t i, vdbtools::Monitor& monitor) {
    const Shot& shot = shots[i];
    const vdbtools::ViewOptions& view = views[i];
    vdbtools::PreviewOptions options{.width = view.width,
                                     .height = view.height,
                                     .samples = view.samples,
                                     .view = view.angles,
                                     .look = layers[i].look,
                                     .passes = layers[i].passes,
                                     .balls = balls};
    options.view.azimuth += shot.turn;
    const bool mesh = isMesh(shot.input);
    if (!mesh && (!vdb || shot.input != vdbName)) {
      vdb = vdbtools::readVdb(shot.input);
      vdbName = shot.input;
    }
    options.up = view.upAxis ? *view.upAxis
                             : vdbtools::recordedUpAxis(mesh ? vdbtools::readMeshTexts(shot.input) : vdb->metadata);
    return Picture{mesh ? imageOfMesh(line, shot.input, options, monitor)
                        : vdbtools::renderPreview(*vdbtools::chooseFloatGrid(*vdb, line.text("grid"), shot.input),
                                                  options, monitor),
                   ""};
  });
}

/// The set of a map, and its renderer.
struct FieldStage {
  FieldStage(const vdbtools::FractalOptions& options, vdbtools::Monitor& monitor)
      : scene(vdbtools::makeScene(options, monitor)),
        region(vdbtools::pictureRegion(scene)),
        renderer(scene.source(), region) {}

  vdbtools::Scene scene;
  openvdb::BBoxd region;
  vdbtools::FieldRenderer renderer;
};

/// Makes pictures of a map's set.
int renderMap(const CommandLine& line) {
  const std::vector<Shot> shots = shotsOf(line, true);
  const vdbtools::OptionTable table = pictureTable(true);
  const std::string format = requireOutput(line);
  std::vector<vdbtools::FieldPicture> pictures;
  std::vector<Layers> layers;
  std::vector<vdbtools::FractalOptions> fractals;
  std::vector<std::size_t> fractalOf;  // for each shot, the index of its fractal
  vdbtools::InputFiles inputs;
  for (std::size_t i = 0; i < shots.size(); ++i) {
    const vdbtools::RecipeReader reader(shots[i].view, table);
    pictures.push_back(vdbtools::parseFieldPicture(shots[i].view, table));
    layers.push_back(layersOf(reader, format, kFieldPasses));
    if (i == 0 || shots[i].input != shots[i - 1].input) {
      const vdbtools::Recipe recipe = sceneRecipe(line, shots[i].input);
      fractals.push_back(vdbtools::forPictures(vdbtools::parseFractalOptions(recipe)));
      line.requireEffect({{recipe, {vdbtools::Product::Picture}}});
      inputs.add(vdbtools::inputsOf(fractals.back()));
    }
    fractalOf.push_back(fractals.size() - 1);
  }
  std::optional<FieldStage> stage;
  std::size_t staged = 0;  // the index of the fractal that is staged
  return Shooting(line, shots, std::move(inputs), format).make(layers, [&](std::size_t i, vdbtools::Monitor& monitor) {
    if (!stage || staged != fractalOf[i]) {
      stage.emplace(fractals[fractalOf[i]], monitor);
      staged = fractalOf[i];
    }
    const vdbtools::FieldPicture& picture = pictures[i];
    vdbtools::FieldRenderOptions options = vdbtools::pictureOptions(stage->scene, stage->region, picture);
    options.camera =
        vdbtools::turned(options.camera, picture.view.axis(stage->scene.options.output.axes.target), shots[i].turn);
    options.look = layers[i].look;
    options.passes = layers[i].passes;
    const auto start = std::chrono::steady_clock::now();
    vdbtools::FieldImage image = stage->renderer.render(options, monitor);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    std::ostringstream more;
    more << ", " << image.rays << " rays, "
         << static_cast<std::uint64_t>(static_cast<double>(image.rays) / seconds.count()) << " a second, "
         << image.evaluations << " samples evaluated";
    return Picture{std::move(image), more.str(), stage->scene.metadata};
  });
}

}  // namespace

int runRender(const Arguments& arguments) {
  CommandLine line(kRenderUsage, vdbtools::fractalOptionTable());
  const auto text = [](const char* name) { return po::value<std::string>()->value_name(name); };
  const auto texts = [](const char* name) { return po::value<std::vector<std::string>>()->value_name(name); };
  line.addOptions()("output,o", text("F.png"), "the picture to write: .png or .exr");
  line.addOptions(vdbtools::viewOptionSpecs(kSize));
  line.addOptions(lookAndPassesSpecs());
  line.addOptions()("roots", text("F.json"),
                    "show the roots of a map that 'juliavdb fit' made: top roots in blue, bottom roots in red")(
      "field", po::bool_switch(),
      "show the set of the map itself and not the level set of a VDB. --eye, --look-at, --epsilon, --alpha-clarity, "
      "--delta, --no-skip, --search and the options of 'fractal' go with it")(
      "turn", text("DEG"), "the camera turns about the vertical axis by so much over all frames; 360 is a turntable")(
      "key", texts("NAME@FRAME=VALUE"),
      "what an option of the camera or the light is at a frame, such as zoom@48=3; any number of times")(
      "ease", texts("[NAME=]linear|smooth|step"),
      "how the numbers change between keys: of all options, or of the option NAME; any number of times");
  addFramesOption(line);
  line.addOptions(vdbtools::fieldViewOptionSpecs());
  addSearchOption(line);
  line.acceptStandardInput();
  if (!line.parse(arguments)) return kDone;
  const bool field = line.values()["field"].as<bool>();
  requireFits(line, field);
  return field ? renderMap(line) : renderSurface(line);
}

}  // namespace cli
