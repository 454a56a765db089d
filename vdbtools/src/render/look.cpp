// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/render/look.h"

#include "base/srgb.h"
#include "recipe/option_rows.h"

#include "vdbtools/base/text.h"
#include "vdbtools/picture/gradient.h"

#include <array>
#include <cmath>
#include <string_view>
#include <utility>

namespace vdbtools {
namespace {

using openvdb::Vec3d;

struct NamedMaterial {
  const char* name;
  Material material;
};

const std::array<NamedMaterial, 8>& materials() {
  static const std::array<NamedMaterial, 8> all = {{
      {"clay", {}},
      {"plaster", {Vec3d(0.72, 0.70, 0.66), Vec3d(0.03), 8, false}},
      {"bone", {Vec3d(0.72, 0.62, 0.45), Vec3d(0.12), 24, false}},
      {"porcelain", {Vec3d(0.78, 0.78, 0.76), Vec3d(0.05), 400, true}},
      {"jade", {Vec3d(0.10, 0.34, 0.19), Vec3d(0.06), 160, true}},
      {"slate", {Vec3d(0.09, 0.10, 0.12), Vec3d(0.10), 12, false}},
      {"bronze", {Vec3d(0.10, 0.05, 0.02), Vec3d(0.62, 0.36, 0.16), 40, true}},
      {"gold", {Vec3d(0.12, 0.07, 0.01), Vec3d(0.95, 0.62, 0.22), 90, true}},
  }};
  return all;
}

/// Applies the finish that follows the colour of a custom material.
std::optional<Material> finished(const std::string& finish, const Vec3d& colour) {
  if (finish == "matt") return Material{colour, Vec3d(0.03), 8, false};
  if (finish == "satin") return Material{colour, Vec3d(0.10), 18, false};
  if (finish == "glossy") return Material{colour, Vec3d(0.05), 400, true};
  if (finish == "metal") return Material{0.12 * colour, 0.9 * colour, 60, true};
  return std::nullopt;
}

/// "#rrggbb" or "R,G,B" in sRGB, each 0 to 1, as linear RGB.
std::optional<Vec3d> colourFromText(const std::string& text) {
  Vec3d codes;
  if (text.starts_with('#')) {
    const std::optional<Gradient::Stop> code = Gradient::stopOf(std::string_view(text).substr(1));
    if (!code) return std::nullopt;
    codes = Vec3d((*code)[0], (*code)[1], (*code)[2]);
  } else {
    const std::vector<std::string> parts = split(text, ',');
    if (parts.size() != 3) return std::nullopt;
    for (int i = 0; i < 3; ++i) {
      const std::optional<double> value = numberFromText(parts[static_cast<std::size_t>(i)]);
      if (!value || !(*value >= 0 && *value <= 1)) return std::nullopt;
      codes[i] = *value;
    }
  }
  return Vec3d(linearFromSrgb(codes[0]), linearFromSrgb(codes[1]), linearFromSrgb(codes[2]));
}

Material parseMaterial(const RecipeReader& reader, const std::string& name) {
  const std::string text = reader.text(name);
  for (const NamedMaterial& named : materials())
    if (named.name == text) return named.material;
  const std::size_t colon = text.rfind(':');
  if (const std::optional<Vec3d> colour = colourFromText(text.substr(0, colon))) {
    const std::string finish = colon == std::string::npos ? "satin" : text.substr(colon + 1);
    if (const std::optional<Material> material = finished(finish, *colour)) return *material;
  }
  reader.refuse(name, joined(materialNames()) +
                          ", or a colour of one's own such as #c08040 or 0.8,0.5,0.2, followed by :matt, :satin, "
                          ":glossy or :metal" +
                          didYouMean(text, materialNames()));
}

void parseLight(const RecipeReader& reader, const std::string& name, Look& look) {
  constexpr double kMostAzimuth = 1e6, kMostElevation = 90;
  const std::vector<std::string> parts = split(reader.text(name), ',');
  std::array<double, 2> angles{};
  for (std::size_t i = 0; i < 2; ++i) {
    const std::optional<double> value = parts.size() == 2 ? numberFromText(parts[i]) : std::nullopt;
    if (!value || !(std::abs(*value) <= (i == 0 ? kMostAzimuth : kMostElevation)))
      reader.refuse(name, "AZIMUTH,ELEVATION in degrees, the elevation -90 to 90");
    angles[i] = *value;
  }
  look.keyAzimuth = angles[0];
  look.keyElevation = angles[1];
}

void parseBackground(const RecipeReader& reader, const std::string& name, Look& look) {
  const std::string text = reader.text(name);
  look.backdrop = text == "none" ? Backdrop::None : Backdrop::Plain;
  if (look.backdrop == Backdrop::None) return;
  const std::optional<Vec3d> colour = colourFromText(text);
  if (!colour) reader.refuse(name, "none, or a colour such as #203040 or 0.1,0.2,0.3");
  look.plain = *colour;
}

const OptionRows<Look>& lookRows() {
  static const OptionRows<Look> rows{
      {{.name = "material",
        .argument = "NAME|COLOUR",
        .defaultValue = "clay",
        .help = "what the surface is made of: " + joined(materialNames()) +
                "; or a colour such as #c08040 or 0.8,0.5,0.2, followed by :matt, :satin (as without), :glossy or "
                ":metal. The colours of a mesh's points take the place of the material's"},
       parsed(&Look::material, parseMaterial)},
      {{.name = "light",
        .argument = "AZ,EL",
        .defaultValue = numbersText({Look{}.keyAzimuth, Look{}.keyElevation}),
        .help = "where the key light stands: degrees from the viewer, positive to the right, and above the horizon. It "
                "goes along with the camera"},
       parsedBy(parseLight)},
      {{.name = "sky",
        .argument = "S",
        .help = "the brightness of the light from the sky, the floor and behind; 0 leaves the key light alone"},
       number(&Look::sky, within(0, 100))},
      {{.name = "ground", .help = "put a floor under the lowest point, which takes shadows"}, flag(&Look::ground)},
      {{.name = "background",
        .argument = "COLOUR|none",
        .help = "a plain colour such as #203040 or 0.1,0.2,0.3 behind the surface, or none for alpha",
        .defaultNote = "neutral"},
       parsedBy(parseBackground)},
      {{.name = "exposure", .argument = "EV", .help = "stops by which the light is brighter, -10 to 10"},
       number(&Look::exposure, within(-10, 10))}};
  return rows;
}

}  // namespace

std::vector<std::string> materialNames() {
  std::vector<std::string> names;
  for (const NamedMaterial& named : materials()) names.emplace_back(named.name);
  return names;
}

std::vector<OptionSpec> lookOptionSpecs() { return lookRows().specs(); }

Look parseLook(const RecipeReader& reader) {
  const Look look = lookRows().read(reader);
  if (look.ground && !(look.keyElevation > 0))
    throw std::invalid_argument("--light " + reader.text("light") +
                                " is below the floor of --ground, which would hide all; raise it above 0 degrees, or "
                                "leave out --ground");
  return look;
}

}  // namespace vdbtools
