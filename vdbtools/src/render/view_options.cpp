// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/render/view_options.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

namespace vdbtools {
namespace {

constexpr int kLargestSide = 32768;  // pixels

/// The options that a position of the eye replaces.
constexpr std::array kAnglesOfEye{"azimuth", "elevation", "zoom"};

void parseSize(const RecipeReader& reader, ViewOptions& options) {
  const std::vector<std::string> sides = split(reader.text("size"), 'x');
  const auto side = [&](std::size_t i) {
    const std::optional<int> pixels = sides.size() == 2 ? wholeFromText<int>(sides[i]) : std::nullopt;
    if (!pixels || *pixels < 1 || *pixels > kLargestSide) reader.refuse("size", "WIDTHxHEIGHT, each 1 to 32768");
    return *pixels;
  };
  options.width = side(0);
  options.height = side(1);
}

/// @param domain  the text that follows "it must be"
double numberWithin(const RecipeReader& reader, const char* name, double low, double high, const char* domain) {
  const double value = reader.number(name);
  if (!(value >= low && value <= high)) reader.refuse(name, domain);
  return value;
}

void parseUp(const RecipeReader& reader, ViewOptions& options) {
  if (!reader.has("up")) return;
  const std::string text = reader.text("up");
  if (text == "keep" || text == "auto") return;  // both are what the file has
  if (text == "y" || text == "z") {
    options.upAxis = text == "y" ? UpAxis::Y : UpAxis::Z;
  } else {
    if (text.find(',') == std::string::npos) reader.refuse("up", "keep, y, z, auto, or a direction X,Y,Z");
    options.up = reader.vector("up");
    if (options.up->length() == 0) reader.refuse("up", "a direction");
  }
}

FieldView parseView(const RecipeReader& reader, const ViewOptions& common) {
  const auto vector = [&](const char* name) {
    return reader.has(name) ? std::optional(reader.vector(name)) : std::nullopt;
  };
  return {.eye = vector("eye"),
          .lookAt = vector("look-at"),
          .up = common.up,
          .angles = common.angles,
          .upAxis = common.upAxis};
}

}  // namespace

std::vector<OptionSpec> viewOptionSpecs(const std::string& size) {
  return {{.name = "size", .argument = "WxH", .defaultValue = size, .help = "pixels"},
          {.name = "azimuth",
           .argument = "DEG",
           .defaultValue = "-30",
           .help = "angle about the vertical axis, 0 being the front"},
          {.name = "elevation", .argument = "DEG", .defaultValue = "15", .help = "angle above the horizon"},
          {.name = "fov", .argument = "DEG", .defaultValue = "30", .help = "vertical field of view"},
          {.name = "samples",
           .argument = "N",
           .defaultValue = "4",
           .help = "rays per pixel: 1, 4, 9 or 16; rough pixels get twice as many"},
          {.name = "zoom", .argument = "F", .defaultValue = "1", .help = "magnification: above 1 comes closer"},
          {.name = "up",
           .argument = "keep|y|z|auto|X,Y,Z",
           .help = "the axis of the world that points up: y, z, or, with keep and auto, that of the file or of "
                   "--target-up; or, with --field, the direction that is up in the picture alone",
           .defaultNote = "keep"}};
}

ViewOptions parseViewOptions(const RecipeReader& reader) {
  ViewOptions options;
  parseSize(reader, options);
  options.samples = reader.choice<int>("samples", {{"1", 1}, {"4", 4}, {"9", 9}, {"16", 16}});
  options.angles = {.azimuth = numberWithin(reader, "azimuth", -1e6, 1e6, "-1e6 to 1e6 degrees"),
                    .elevation = numberWithin(reader, "elevation", -90, 90, "-90 to 90 degrees"),
                    .fieldOfView = numberWithin(reader, "fov", 1, 150, "1 to 150 degrees"),
                    .zoom = numberWithin(reader, "zoom", 1e-3, 1e3, "0.001 to 1000")};
  parseUp(reader, options);
  return options;
}

Camera FieldView::camera(const FieldSource& source, const openvdb::BBoxd& region, double aspect, UpAxis usual) const {
  Camera camera;
  camera.fieldOfView = angles.fieldOfView;
  const UpAxis world = upAxis.value_or(usual);
  camera.up = directionOf(world);
  if (!eye || !lookAt) camera = cameraAround(frameSet(source, region), angles, aspect, world);
  const openvdb::Vec3d arm = camera.eye - camera.lookAt;
  if (lookAt) camera.lookAt = *lookAt;
  camera.eye = eye ? *eye : camera.lookAt + arm;
  if (up) camera.up = *up;
  if ((camera.eye - camera.lookAt).length() == 0)
    throw std::invalid_argument("--eye and --look-at are the same point; move one of them");
  return camera;
}

std::vector<OptionSpec> fieldViewOptionSpecs() {
  return {{.name = "eye",
           .argument = "X,Y,Z",
           .help = "the position of the eye, in the target's units, instead of azimuth, elevation and zoom"},
          {.name = "look-at",
           .argument = "X,Y,Z",
           .help = "the point in the middle of the picture",
           .defaultNote = "the middle of the set"},
          {.name = "epsilon",
           .argument = "E",
           .defaultValue = "5e-5",
           .help = "the shortest step of a ray, in fractal space"},
          {.name = "alpha-clarity",
           .argument = "A",
           .help = "the length of a ray's steps is A d^D at the distance d from the eye",
           .defaultNote = "as long as a pixel is wide"},
          {.name = "delta", .argument = "D", .defaultValue = "1", .help = "the exponent D: 0, 1 or 2"},
          {.name = "no-skip", .help = "evaluate every sample, even where the map is proved to be empty; for checking"}};
}

std::vector<OptionSpec> fieldPictureOptionSpecs(const std::string& size) {
  std::vector<OptionSpec> options = viewOptionSpecs(size);
  for (OptionSpec& option : fieldViewOptionSpecs()) options.push_back(std::move(option));
  return options;
}

FieldPicture parseFieldPicture(const Recipe& given, const OptionTable& table) {
  const RecipeReader reader(given, table);
  const ViewOptions common = parseViewOptions(reader);
  FieldPicture picture{.view = parseView(reader, common)};
  for (const char* name : kAnglesOfEye)
    if (picture.view.eye && given.contains(name))
      throw std::invalid_argument(std::string("--eye and --") + name +
                                  " both set the position of the eye; give only one of them");
  FieldRenderOptions& render = picture.render;
  render.width = common.width;
  render.height = common.height;
  render.samples = common.samples;
  if (table.knows("colour")) picture.colour = parseColour(reader);
  render.clarity.epsilon = reader.number("epsilon");
  if (!(render.clarity.epsilon >= 1e-9)) reader.refuse("epsilon", "at least 1e-9");
  if (reader.has("alpha-clarity")) {
    render.clarity.alpha = reader.number("alpha-clarity");
    if (!(*render.clarity.alpha >= 0)) reader.refuse("alpha-clarity", "at least 0");
  }
  render.clarity.delta = reader.choice<int>("delta", {{"0", 0}, {"1", 1}, {"2", 2}});
  render.skip = !reader.flag("no-skip");
  if (table.knows("material")) render.look = parseLook(reader);
  return picture;
}

std::vector<OptionSpec> pictureOptionSpecs(const std::string& size, bool field) {
  std::vector<OptionSpec> options = field ? fieldPictureOptionSpecs(size) : viewOptionSpecs(size);
  for (OptionSpec& option : lookOptionSpecs()) options.push_back(std::move(option));
  return options;
}

bool isAppearance(const std::string& option) { return option != "size" && option != "samples" && option != "no-skip"; }

Recipe overriddenView(Recipe base, const Recipe& given) {
  const auto isGiven = [&](const char* name) { return given.contains(name); };
  if (isGiven("eye"))
    for (const char* name : kAnglesOfEye) base.erase(name);
  if (std::any_of(kAnglesOfEye.begin(), kAnglesOfEye.end(), isGiven)) base.erase("eye");
  for (const auto& [name, value] : given) base[name] = value;
  return base;
}

Recipe completeView(Recipe view, const OptionTable& table) {
  const bool hasPlace = view.contains("eye");
  view = completeRecipe(std::move(view), table);
  if (hasPlace)
    for (const char* name : kAnglesOfEye) view.erase(name);
  return view;
}

}  // namespace vdbtools
