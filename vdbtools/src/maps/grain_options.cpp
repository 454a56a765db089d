// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/maps/grain_options.h"

#include "control/control_lattice.h"
#include "vdbtools/base/text.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/maps/versor_options.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace vdbtools {
namespace {

constexpr const char* kNoGrain = "none";
constexpr const char* kGrainForms =
    "none, along, around, curvature, down, a vector X,Y,Z, uv:u, uv:v, paint:NAME with a vector attribute of the "
    "target's mesh, or field:FILE.vdb:GRID with a grid of vectors";

std::string grainOf(const Recipe& recipe) {
  const auto grain = recipe.find("grain");
  return grain == recipe.end() ? kNoGrain : grain->second;
}

/// Of --grain.
std::string idleGrain(const OptionRun& run) {
  const auto follows = [&](const char* option) {
    const auto texture = run.recipe.find(option);
    return texture != run.recipe.end() && followsGrain(texture->second);
  };
  if (run.text("map") == "shape-modulus" && !follows("texture") && !follows("texture-over"))
    return "it is for the textures of the shelf and for waves of a file; leave it out, or give such a texture";
  return {};
}

std::string idleGrainTurn(const OptionRun& run) {
  return hasGrain(run.recipe) ? idleGrain(run) : "there is no grain to turn; leave it out, or give --grain";
}

/// Three numbers, not all of them 0.
std::optional<openvdb::Vec3d> parseTowards(const std::string& text) {
  const std::vector<std::string> parts = split(text, ',');
  if (parts.size() != 3) return std::nullopt;
  openvdb::Vec3d towards;
  for (int axis = 0; axis < 3; ++axis) {
    const std::optional<double> part = finiteNumber(parts[static_cast<std::size_t>(axis)]);
    if (!part) return std::nullopt;
    towards[axis] = *part;
  }
  const double length = towards.length();
  return length > 0 && std::isfinite(length) ? std::optional(towards) : std::nullopt;
}

}  // namespace

bool hasGrain(const Recipe& recipe) { return grainOf(recipe) != kNoGrain; }

bool hasGrain(const RecipeReader& reader) { return reader.has("grain") && reader.text("grain") != kNoGrain; }

std::vector<OptionSpec> grainOptions() {
  return {
      {.name = "grain",
       .argument = "along|around|X,Y,Z|...",
       .defaultValue = kNoGrain,
       .help = "the directions on the target that textures follow: along its limbs, towards thin ends; around them; "
               "curvature, the least bending; down; a vector X,Y,Z; uv:u or uv:v, as the mesh is unwrapped; "
               "paint:NAME, a vector attribute of the mesh; field:FILE.vdb:GRID, a grid of vectors; or none, the axes "
               "of space",
       .hash = "grain-sha256",
       .idle = idleGrain},
      {.name = "grain-turn",
       .argument = "DEGREES",
       .help = "turns the grain in the surface, to the left as seen from outside; takes the same kinds of values as "
               "--detail",
       .defaultFor = [](const Recipe& recipe) -> std::optional<std::string> {
         return hasGrain(recipe) ? std::optional<std::string>("0") : std::nullopt;
       },
       .defaultNote = "0",
       .hash = "grain-turn-sha256",
       .type = {.kind = OptionType::Kind::Control},
       .idle = idleGrainTurn}};
}

std::optional<GrainSettings> parseGrain(const RecipeReader& reader) {
  GrainSettings grain{.text = reader.text("grain")};
  const std::string& text = grain.text;
  if (text == kNoGrain) return std::nullopt;
  if (text == "along") {
    grain.kind = GrainKind::Along;
  } else if (text == "around") {
    grain.kind = GrainKind::Around;
  } else if (text == "curvature") {
    grain.kind = GrainKind::Curvature;
  } else if (text == "down") {
    grain.kind = GrainKind::Towards;
    grain.towards = {0, -1, 0};
  } else if (const std::optional<openvdb::Vec3d> towards = parseTowards(text)) {
    grain.kind = GrainKind::Towards;
    grain.towards = *towards;
  } else {
    grain.kind = GrainKind::Given;
    if (const std::optional<std::string> uv = afterPrefix(text, "uv:")) {
      if (*uv != "u" && *uv != "v") reader.refuse("grain", kGrainForms);
      grain.uv = *uv == "u" ? 0 : 1;
    } else if (const std::optional<std::string> name = afterPrefix(text, "paint:")) {
      if (name->empty()) reader.refuse("grain", kGrainForms);
      grain.attribute = *name;
    } else if (const std::optional<std::string> field = afterPrefix(text, "field:")) {
      const std::size_t colon = isVdbPath(*field) ? std::string::npos : field->rfind(':');
      const std::string path = field->substr(0, colon);
      if (!isVdbPath(path)) reader.refuse("grain", kGrainForms);
      grain.file = reader.file("grain", path);
      if (colon != std::string::npos) grain.grids = split(field->substr(colon + 1), ',');
    } else {
      reader.refuse("grain", kGrainForms);
    }
  }
  grain.turn = parseControl(reader, "grain-turn");
  grain.scale = std::abs(reader.number("texture-scale"));
  if (!(grain.scale > 0)) reader.refuse("texture-scale", "other than 0");
  return grain;
}

}  // namespace vdbtools
