// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/render/view_options.h"

#include "recipe/option_rows.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

namespace vdbtools {
namespace {

constexpr int kLargestSide = 32768;  // pixels

/// The options that a position of the eye replaces.
constexpr std::array kAnglesOfEye{"azimuth", "elevation", "zoom"};

void parseSize(const RecipeReader& reader, const std::string& name, ViewOptions& options) {
  const std::vector<std::string> sides = split(reader.text(name), 'x');
  const auto side = [&](std::size_t i) {
    const std::optional<int> pixels = sides.size() == 2 ? wholeFromText<int>(sides[i]) : std::nullopt;
    if (!pixels || *pixels < 1 || *pixels > kLargestSide) reader.refuse(name, "WIDTHxHEIGHT, each 1 to 32768");
    return *pixels;
  };
  options.width = side(0);
  options.height = side(1);
}

void parseUp(const RecipeReader& reader, const std::string& name, ViewOptions& options) {
  const std::string text = reader.text(name);
  if (text == "keep" || text == "auto") return;  // both are what the file has
  if (text == "y" || text == "z") {
    options.upAxis = text == "y" ? UpAxis::Y : UpAxis::Z;
  } else {
    if (text.find(',') == std::string::npos) reader.refuse(name, "keep, y, z, auto, or a direction X,Y,Z");
    options.up = reader.vector(name);
    if (options.up->length() == 0) reader.refuse(name, "a direction");
  }
}

const OptionRows<ViewOptions>& viewRows() {
  static const OptionRows<ViewOptions> rows{
      {{.name = "size", .argument = "WxH", .help = "pixels"}, parsedBy(parseSize)},
      {{.name = "azimuth", .argument = "DEG", .help = "angle about the vertical axis, 0 being the front"},
       number(
           [](auto& view) -> auto& { return view.angles.azimuth; }, within(-1e6, 1e6))},
      {{.name = "elevation", .argument = "DEG", .help = "angle above the horizon"},
       number(
           [](auto& view) -> auto& { return view.angles.elevation; }, within(-90, 90))},
      {{.name = "fov", .argument = "DEG", .help = "vertical field of view"},
       number(
           [](auto& view) -> auto& { return view.angles.fieldOfView; }, within(1, 150))},
      {{.name = "samples", .argument = "N", .help = "rays per pixel: 1, 4, 9 or 16; rough pixels get twice as many"},
       choice<int>(&ViewOptions::samples, {{"1", 1}, {"4", 4}, {"9", 9}, {"16", 16}})},
      {{.name = "zoom", .argument = "F", .help = "magnification: above 1 comes closer"},
       number(
           [](auto& view) -> auto& { return view.angles.zoom; }, within(1e-3, 1e3))},
      {{.name = "up",
        .argument = "keep|y|z|auto|X,Y,Z",
        .help = "the axis of the world that points up: y, z, or, with keep and auto, that of the file or of "
                "--target-up; or, with --field, the direction that is up in the picture alone",
        .defaultNote = "keep"},
       parsedBy(parseUp)}};
  return rows;
}

/// What a picture of a map's set takes besides: the eye and the steps of rays.
const OptionRows<FieldPicture>& fieldViewRows() {
  static const OptionRows<FieldPicture> rows{
      {{.name = "eye",
        .argument = "X,Y,Z",
        .help = "the position of the eye, in the target's units, instead of azimuth, elevation and zoom"},
       vector([](auto& picture) -> auto& { return picture.view.eye; })},
      {{.name = "look-at",
        .argument = "X,Y,Z",
        .help = "the point in the middle of the picture",
        .defaultNote = "the middle of the set"},
       vector([](auto& picture) -> auto& { return picture.view.lookAt; })},
      {{.name = "epsilon", .argument = "E", .help = "the shortest step of a ray, in fractal space"},
       number(
           [](auto& picture) -> auto& { return picture.render.clarity.epsilon; }, atLeast(1e-9))},
      {{.name = "alpha-clarity",
        .argument = "A",
        .help = "the length of a ray's steps is A d^D at the distance d from the eye",
        .defaultNote = "as long as a pixel is wide"},
       number(
           [](auto& picture) -> auto& { return picture.render.clarity.alpha; }, atLeast(0))},
      {{.name = "delta", .argument = "D", .help = "the exponent D: 0, 1 or 2"},
       choice<int>([](auto& picture) -> auto& { return picture.render.clarity.delta; },
                   {{"0", 0}, {"1", 1}, {"2", 2}})},
      {{.name = "no-skip", .help = "evaluate every sample, even where the map is proved to be empty; for checking"},
       parsedBy([](const RecipeReader& reader, const std::string& name,
                   FieldPicture& picture) { picture.render.skip = !reader.flag(name); },
                {.kind = OptionType::Kind::Flag})}};
  return rows;
}

}  // namespace

std::vector<OptionSpec> viewOptionSpecs(const std::string& size) {
  std::vector<OptionSpec> options = viewRows().specs();
  options.front().defaultValue = size;
  return options;
}

ViewOptions parseViewOptions(const RecipeReader& reader) { return viewRows().read(reader); }

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

std::vector<OptionSpec> fieldViewOptionSpecs() { return fieldViewRows().specs(); }

std::vector<OptionSpec> fieldPictureOptionSpecs(const std::string& size) {
  std::vector<OptionSpec> options = viewOptionSpecs(size);
  for (OptionSpec& option : fieldViewOptionSpecs()) options.push_back(std::move(option));
  return options;
}

FieldPicture parseFieldPicture(const Recipe& given, const OptionTable& table) {
  const RecipeReader reader(given, table);
  const ViewOptions common = parseViewOptions(reader);
  FieldPicture picture{.view = {.up = common.up, .angles = common.angles, .upAxis = common.upAxis},
                       .render = {.width = common.width, .height = common.height, .samples = common.samples}};
  fieldViewRows().read(reader, picture);
  for (const char* name : kAnglesOfEye)
    if (picture.view.eye && given.contains(name))
      throw std::invalid_argument(std::string("--eye and --") + name +
                                  " both set the position of the eye; give only one of them");
  if (table.knows("colour")) picture.colour = parseColour(reader);
  if (table.knows("material")) picture.render.look = parseLook(reader);
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
