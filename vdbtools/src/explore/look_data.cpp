// SPDX-License-Identifier: Apache-2.0
#include "explore/look_data.h"

#include "base/base64.h"
#include "explore/scene_data.h"
#include "scene/scene_colouring.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/picture/gradient.h"
#include "vdbtools/recipe/recipe_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace vdbtools::explore {
namespace {

using nlohmann::json;
using openvdb::Vec3d;

constexpr double kMostPictureSide = 4096;  // pixels

const OptionTable& lookTable() {
  static const OptionTable table(lookOptionSpecs());
  return table;
}

json numbersOf(const Vec3d& v) { return {v[0], v[1], v[2]}; }

json dataOf(const Material& material) {
  return {{"albedo", numbersOf(material.albedo)},
          {"gloss", numbersOf(material.gloss)},
          {"sharpness", material.sharpness},
          {"mirrors", material.mirrors}};
}

const char* kindOf(FieldColour by) {
  switch (by) {
    case FieldColour::Direction: return "direction";
    case FieldColour::Versor: return "versor";
    case FieldColour::Iterations: return "iterations";
    case FieldColour::Trap: return "trap";
    case FieldColour::Depth: return "depth";
    case FieldColour::Clay: return "clay";
  }
  return "";
}

/// The stops of a gradient, but no more than a texture has texels.
json stopsOf(const Gradient& gradient) {
  constexpr std::size_t kMost = 256;
  const std::vector<Gradient::Stop>& stops = gradient.stops();
  const std::size_t count = std::min(stops.size(), kMost);
  json list = json::array();
  for (std::size_t i = 0; i < count; ++i) {
    const Gradient::Stop& stop = stops[count > 1 ? i * (stops.size() - 1) / (count - 1) : 0];
    list.push_back({stop[0], stop[1], stop[2]});
  }
  return list;
}

/// The distances on a lattice over the target and over its surroundings up to @a around; all in fractal space.
json distanceData(const Scene& scene, const DepthColouring& depth, double around, Monitor& monitor) {
  constexpr int kSide = 64;
  const FractalSpace& space = scene.field.space;
  openvdb::BBoxd box(Vec3d(space.toFractal(scene.target->distances.box.min()).data()),
                     Vec3d(space.toFractal(scene.target->distances.box.max()).data()));
  box.expand(std::max(0.0, around));
  const double step = box.extents()[box.maxExtent()] / (kSide - 1);
  std::array<int, 3> dims{};
  for (int axis = 0; axis < 3; ++axis)
    dims[static_cast<std::size_t>(axis)] =
        std::clamp(static_cast<int>(std::ceil(box.extents()[axis] / step - 1e-6)) + 1, 2, kSide);
  std::string bytes;
  std::vector<Vec3d> places(static_cast<std::size_t>(dims[0]));
  std::vector<double> values(places.size());
  for (int k = 0; k < dims[2]; ++k) {
    monitor.throwIfCancelled();
    for (int j = 0; j < dims[1]; ++j) {
      for (std::size_t i = 0; i < places.size(); ++i) {
        const Vec3d at = box.min() + step * Vec3d(static_cast<double>(i), j, k);
        places[i] = space.toWorld({at[0], at[1], at[2]});
      }
      depth.distance.sample(places, values);
      for (const double value : values) appendHalf(bytes, static_cast<float>(value / space.scale));
    }
  }
  return {{"dims", dims}, {"origin", numbersOf(box.min())}, {"step", step}, {"values", base64(bytes)}};
}

}  // namespace

std::string numberText(const json& value, const std::string& name) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number()) return numbersText({value.get<double>()});
  std::vector<double> numbers;
  for (const json& part : value.is_array() ? value : json::array()) {
    if (!part.is_number()) throw std::invalid_argument("'" + name + "' must be a list of numbers");
    numbers.push_back(part.get<double>());
  }
  if (numbers.empty()) throw std::invalid_argument("'" + name + "' must be a number or a list of numbers");
  return numbersText(numbers);
}

Recipe lookTexts(const json& body) {
  Recipe texts;
  const auto look = body.find("look");
  if (look == body.end() || look->is_null()) return texts;
  if (!look->is_object()) throw std::invalid_argument("'look' must be an object of options");
  for (const auto& [name, value] : look->items()) {
    if (!lookTable().knows(name)) throw std::invalid_argument("a look has no option '" + inOneLine(name) + "'");
    if (!value.is_string()) throw std::invalid_argument("the option '" + name + "' must be a text");
    texts[name] = value.get<std::string>();
  }
  return texts;
}

json lookData(const Recipe& texts) {
  const Look look = parseLook(RecipeReader(texts, lookTable()));
  const json background = look.backdrop == Backdrop::None    ? json("none")
                          : look.backdrop == Backdrop::Plain ? numbersOf(look.plain)
                                                             : json();
  return {{"material", dataOf(look.material)},
          {"light", {look.keyAzimuth, look.keyElevation}},
          {"sky", look.sky},
          {"ground", look.ground},
          {"background", background},
          {"exposure", look.exposure}};
}

json materialData() {
  json materials = json::object();
  for (const std::string& name : materialNames())
    materials[name] = dataOf(parseLook(RecipeReader({{"material", name}}, lookTable())).material);
  return materials;
}

json lookOptionData() {
  json all = json::array();
  for (const OptionSpec& option : lookOptionSpecs())
    all.push_back({{"name", option.name}, {"help", option.help}, {"default", option.defaultValue.value_or("")}});
  return all;
}

json gradientData() { return gradientNames(); }

json colouringData(const Scene& scene, const ColourChoice& choice, Monitor& monitor) {
  const FieldColouring colouring = sceneColouring(scene, choice);
  monitor.throwIfCancelled();
  json data = {{"by", kindOf(colouring.by)}, {"stops", json::array()}};
  GradientRange range = colouring.range.value_or(GradientRange{});
  switch (colouring.by) {
    case FieldColour::Clay:
    case FieldColour::Direction:
    case FieldColour::Versor: return data;
    case FieldColour::Trap: break;
    case FieldColour::Iterations:
      if (!colouring.range) range = {0, static_cast<double>(scene.field.orbit.maxIterations)};
      break;
    case FieldColour::Depth: {
      const DepthColouring& depth = colouring.depth.value();
      if (!colouring.range) range = {depth.low, depth.high};
      const double scale = scene.field.space.scale;
      data["distance"] = distanceData(scene, depth, depth.high / scale, monitor);
      break;
    }
  }
  data["low"] = range.low;
  data["high"] = range.high;
  data["stops"] = stopsOf(colouring.gradient);
  return data;
}

Recipe pictureTexts(const json& body) {
  Recipe given = lookTexts(body);
  const auto take = [&](const json& object, const char* entry, const char* option) {
    if (const auto found = object.find(entry); found != object.end() && !found->is_null())
      given[option] = numberText(*found, entry);
  };
  const json view = body.value("view", json());
  if (!view.is_object() && !view.is_null()) throw std::invalid_argument("'view' must be an object");
  if (view.is_object()) {
    take(view, "lookAt", "look-at");
    for (const char* name : {"eye", "up", "fov", "azimuth", "elevation", "zoom"}) take(view, name, name);
  }
  for (const char* name : {"samples", "colour", "epsilon", "delta"}) take(body, name, name);
  take(body, "alphaClarity", "alpha-clarity");
  if (body.contains("width") || body.contains("height")) {
    const json width = body.value("width", json(800)), height = body.value("height", json(600));
    if (!width.is_number_unsigned() || !height.is_number_unsigned() || width > kMostPictureSide ||
        height > kMostPictureSide)
      throw std::invalid_argument("'width' and 'height' must be whole numbers of pixels, at most 4096");
    given["size"] = width.dump() + 'x' + height.dump();
  }
  return given;
}

FieldPicture pictureOf(const json& body) {
  static const OptionTable table = [] {
    std::vector<OptionSpec> options = pictureOptionSpecs("800x600", true);
    options.push_back(colourOptionSpec());
    return OptionTable(std::move(options));
  }();
  return parseFieldPicture(pictureTexts(body), table);
}

}  // namespace vdbtools::explore
