// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/maps/map_options.h"

#include "recipe/option_rows.h"

#include <stdexcept>

namespace vdbtools {
namespace {

constexpr const char* kDetail = "0.3";
constexpr const char* kOutward = "0.3";
constexpr const char* kAlpha = "40";
constexpr const char* kBeta = "0";
constexpr const char* kEscapeOfDetail = "2";
constexpr const char* kIterations = "3";
constexpr const char* kIterationsOfDetail = "5";

bool isNumeric(const Recipe& recipe) { return recipe.contains("alpha") || recipe.contains("beta"); }

/// @param ifNumeric  the default where alpha or beta is given, else only where neither is
std::function<std::optional<std::string>(const Recipe&)> defaultWhere(bool ifNumeric, const char* value) {
  return [ifNumeric, value](const Recipe& recipe) {
    return isNumeric(recipe) == ifNumeric ? std::optional<std::string>(value) : std::nullopt;
  };
}

const OptionRows<ShellSettings>& shellRows() {
  using Shell = ShellSettings;
  using julia::Interpolation;
  const OptionType share{.kind = OptionType::Kind::Control, .low = 0, .high = 1};
  static const OptionRows<Shell> rows{
      {{.name = "detail",
        .argument = "D",
        .help = "how deep detail eats into the shape, as a share of its local thickness: 0.1 decorates it, 0.25 covers "
                "it, 0.8 leaves a thin core. From 0 to 1; a number, a ramp such as x:0.1:0.6:smooth, FILE.vdb[:GRID], "
                "or a painted control (docs/controls.md)",
        .defaultFor = defaultWhere(false, kDetail),
        .defaultNote = kDetail,
        .alternative = "alpha",
        .displaces = {"beta"},
        .hash = "detail-sha256",
        .kept = true},
       parsed(&Shell::detail, parseShare, share)},
      {{.name = "outward",
        .argument = "O",
        .help = "how far detail reaches out of the shape, as a share of the same. Takes the same values as --detail",
        .defaultFor = defaultWhere(false, kOutward),
        .defaultNote = kOutward,
        .displaces = {"alpha", "beta"},
        .hash = "outward-sha256",
        .kept = true},
       parsed(&Shell::outward, parseShare, share)},
      {{.name = "mask",
        .argument = "M",
        .defaultValue = "1",
        .help = "where it is 0 the result is the plain target, where it is 1 the fractal. Takes the same values as "
                "--detail",
        .hash = "mask-sha256",
        .kept = true},
       parsed(&Shell::mask, parseShare, share)},
      {{.name = "alpha",
        .argument = "A",
        .help =
            "instead of detail, the papers' number for how thin the shell of detail is: 6 eats deep into the shape, "
            "40 decorates it, 300 is nearly smooth. Above 0; takes the same values as --detail",
        .defaultFor = defaultWhere(true, kAlpha),
        .defaultNote = std::string(kAlpha) + " where beta is given",
        .alternative = "detail",
        .displaces = {"outward"},
        .hash = "alpha-sha256",
        .kept = true},
       parsed(&Shell::alpha, parseControl, {.kind = OptionType::Kind::Control, .low = 0, .excludesLow = true})},
      {{.name = "beta",
        .argument = "B",
        .help =
            "instead of outward, the offset of that shell, as a share of the target's longest side; positive values "
            "move it outward. Takes the same values as --detail",
        .defaultFor = defaultWhere(true, kBeta),
        .defaultNote = std::string(kBeta) + " where alpha is given",
        .displaces = {"detail", "outward"},
        .hash = "beta-sha256",
        .kept = true},
       parsed(&Shell::beta, parseControl, {.kind = OptionType::Kind::Control})},
      {{.name = "sampling",
        .defaultValue = "auto",
        .help =
            "how the target's distances are interpolated; quadratic shows no creases in deep zooms. auto: quadratic "
            "for pictures of the set itself, trilinear, which is faster, for meshes and VDBs",
        .kept = true},
       choice<std::optional<Interpolation>>(&Shell::interpolation, {{"auto", std::nullopt},
                                                                    {"trilinear", Interpolation::Trilinear},
                                                                    {"quadratic", Interpolation::Quadratic}})}};
  return rows;
}

}  // namespace

std::vector<ControlSetting> ShellSettings::controls() const {
  std::vector<ControlSetting> controls;
  for (const ControlSetting& control : {alpha, beta, detail, outward, mask})
    if (control) controls.push_back(control);
  return controls;
}

ControlSetting parseShare(const RecipeReader& reader, const std::string& option) {
  if (const std::optional<double> value = numberFromText(reader.text(option)); value && !(*value >= 0 && *value <= 1))
    reader.refuse(option, "from 0 to 1, or a ramp, a grid, a painted attribute, a picture or a formula");
  return parseControl(reader, option);
}

std::vector<OptionSpec> shellOptions() { return shellRows().specs(); }

OptionSpec shellIterationsOption() {
  OptionSpec option = iterationsOption(kIterations);
  option.defaultFor = [](const Recipe& recipe) -> std::optional<std::string> {
    return isNumeric(recipe) ? kIterations : kIterationsOfDetail;
  };
  option.defaultNote = std::string(kIterations) + ", or " + kIterationsOfDetail + " with detail";
  return option;
}

OptionSpec shellEscapeOption() {
  OptionSpec option = escapeOption();
  const std::string usual = option.defaultValue.value();
  option.defaultFor = [usual](const Recipe& recipe) -> std::optional<std::string> {
    return isNumeric(recipe) ? usual : kEscapeOfDetail;
  };
  option.defaultNote = usual + ", or " + kEscapeOfDetail + " with detail";
  return option;
}

ShellSettings parseShell(const RecipeReader& reader) {
  for (const char* share : {"detail", "outward"})
    for (const char* number : {"alpha", "beta"})
      if (reader.has(share) && reader.has(number))
        throw std::invalid_argument("--" + std::string(share) + " is '" + reader.text(share) + "' and --" + number +
                                    " is '" + reader.text(number) +
                                    "', but the one takes the place of the other; give --detail and --outward, or "
                                    "--alpha and --beta");
  return shellRows().read(reader);
}

}  // namespace vdbtools
