// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/maps/versor_options.h"

#include "control/control_kinds.h"
#include "control/control_lattice.h"
#include "vdbtools/formats/vdb_file.h"

#include "julia/expression.h"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

namespace vdbtools {
namespace {

constexpr const char* kNone = "none";
constexpr const char* kFunction = "function";
constexpr const char* kFormula = "expr:";
constexpr const char* kField = "field:";
constexpr const char* kWaves = "waves:";

std::string overOf(const Recipe& recipe) {
  const auto over = recipe.find("texture-over");
  return over == recipe.end() ? kNone : over->second;
}

/// Of an option of the layer over the versor.
std::string idleWithoutOver(const OptionRun& run) {
  return overOf(run.recipe) == kNone ? "there is no layer over the versor; leave it out, or give --texture-over" : "";
}

/// A default where there is such a layer.
std::function<std::optional<std::string>(const Recipe&)> defaultWithOver(const char* value) {
  return [value](const Recipe& recipe) {
    return overOf(recipe) == kNone ? std::nullopt : std::optional<std::string>(value);
  };
}

bool overFollowsThickness(const Recipe& recipe) { return followsThickness(overOf(recipe)); }

std::string idleOverSeed(const OptionRun& run) {
  if (const std::string why = idleWithoutOver(run); !why.empty()) return why;
  const std::string over = overOf(run.recipe);
  const Texture* const texture = findTexture(over);
  if (over == "random" || (texture && texture->varies())) return {};
  return "--texture-over " + over + " has nothing random; leave it out, or give a texture that has";
}

std::string idleOverFrequency(const OptionRun& run) {
  if (const std::string why = idleWithoutOver(run); !why.empty()) return why;
  if (overFollowsThickness(run.recipe) || (hasGrain(run.recipe) && followsGrain(overOf(run.recipe)))) return {};
  return "--texture-over " + overOf(run.recipe) +
         " is as large as it is; leave it out, or give a texture that follows the thickness";
}

VersorFormula parseFormula(const RecipeReader& reader, const std::string& option, const std::string& text) {
  constexpr const char* kWanted = "a formula of three or four components with commas between them, such as expr:-y,x,0";
  VersorFormula formula{text, julia::componentsOfExpression(text), {}};
  if (formula.components.size() != 3 && formula.components.size() != 4) reader.refuse(option, kWanted);
  std::set<std::string> names;
  for (std::size_t i = 0; i < formula.components.size(); ++i) {
    try {
      for (const std::string& name : julia::namesInExpression(formula.components[i])) names.insert(name);
    } catch (const std::invalid_argument& error) {
      reader.refuse(option, std::string(kWanted) + "; in component " + std::to_string(i + 1) + ", " + error.what());
    }
  }
  formula.names.assign(names.begin(), names.end());
  return formula;
}

VersorSource::Field parseField(const RecipeReader& reader, const std::string& option, const std::string& text) {
  constexpr const char* kWanted =
      "field:FILE.vdb:GRID with a grid of vectors, or field:FILE.vdb:A,B,C,D with three or four grids of floats";
  if (isVdbPath(text)) return {reader.file(option, text), {}};
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos || !isVdbPath(text.substr(0, colon))) reader.refuse(option, kWanted);
  const std::vector<std::string> grids = split(text.substr(colon + 1), ',');
  const bool isNamed = std::none_of(grids.begin(), grids.end(), [](const std::string& name) { return name.empty(); });
  if (!isNamed || grids.size() == 2 || grids.size() > 4) reader.refuse(option, kWanted);
  return {reader.file(option, text.substr(0, colon)), grids};
}

/// What is neither a texture nor roots; nothing for those.
std::optional<VersorSource> parseDirections(const RecipeReader& reader, const std::string& option, bool hasFunction) {
  const std::string text = reader.text(option);
  VersorSource source{.option = option};
  if (const std::optional<std::string> formula = afterPrefix(text, kFormula)) {
    source.formula = parseFormula(reader, option, *formula);
  } else if (const std::optional<std::string> field = afterPrefix(text, kField)) {
    source.field = parseField(reader, option, *field);
  } else if (const std::optional<std::string> waves = afterPrefix(text, kWaves)) {
    if (waves->empty()) reader.refuse(option, "waves:FILE.json");
    source.waves = reader.file(option, *waves);
    const std::string frequency = option == "texture" ? "frequency" : "texture-over-frequency";
    source.roots.frequency = parseFrequency(reader, frequency);
  } else if (text == kFunction) {
    if (!hasFunction)
      throw std::invalid_argument("--" + option +
                                  " is 'function', a function of a Python program, which no recipe can hold; make the "
                                  "fractal with that program again, or give another versor");
    source.isFunction = true;
  } else {
    return std::nullopt;
  }
  source.roots.scale = reader.number("texture-scale");
  if (source.roots.scale == 0) reader.refuse("texture-scale", "other than 0");
  source.roots.translate = reader.vector("texture-translate");
  return source;
}

std::optional<julia::Symmetry> parseSymmetry(const RecipeReader& reader) {
  const std::string text = reader.text("texture-symmetry");
  if (text == kNone) return std::nullopt;
  const auto refuse = [&] {
    reader.refuse("texture-symmetry",
                  "none; mirror:AXES, such as mirror:x or mirror:xz; or N:AXIS with N from 2 to 64, such as 6:y, or "
                  "6:y:mirror for a kaleidoscope");
  };
  const std::vector<std::string> parts = split(text, ':');
  const auto axisOf = [&](char letter) {
    if (letter < 'x' || letter > 'z') refuse();
    return letter - 'x';
  };
  julia::Symmetry symmetry;
  if (parts.size() == 2 && parts[0] == "mirror") {
    if (parts[1].empty()) refuse();
    for (const char letter : parts[1]) {
      bool& mirrored = symmetry.mirrored[static_cast<std::size_t>(axisOf(letter))];
      if (mirrored) refuse();
      mirrored = true;
    }
    return symmetry;
  }
  const std::optional<int> fold = wholeFromText<int>(parts[0]);
  if (!fold || *fold < 2 || *fold > julia::kMostFold || parts.size() < 2 || parts.size() > 3 || parts[1].size() != 1)
    refuse();
  if (parts.size() == 3 && parts[2] != "mirror") refuse();
  symmetry.fold = *fold;
  symmetry.axis = axisOf(parts[1][0]);
  symmetry.kaleidoscope = parts.size() == 3;
  return symmetry;
}

/// What is a coordinate of the place, and needs no grid.
bool isCoordinate(const std::string& name) {
  constexpr const char* kKnown[] = {"x", "y", "z", "w", "hx", "hy", "hz", "height"};
  return std::find(std::begin(kKnown), std::end(kKnown), name) != std::end(kKnown);
}

std::vector<const VersorSource*> sourcesOf(const VersorSettings& settings) {
  std::vector<const VersorSource*> sources{&settings.under};
  if (settings.over) sources.push_back(&*settings.over);
  return sources;
}

}  // namespace

bool isDirections(const std::string& versor) {
  return versor.starts_with(kFormula) || versor.starts_with(kField) || versor.starts_with(kWaves) ||
         versor == kFunction;
}

bool followsThickness(const std::string& versor) {
  const Texture* const texture = findTexture(versor);
  return texture ? texture->followsThickness() : versor.starts_with(kWaves);
}

bool followsGrain(const std::string& versor) { return findTexture(versor) || versor.starts_with(kWaves); }

std::vector<OptionSpec> layerOptions() {
  return {
      {.name = "texture-over",
       .argument = "NAME|FILE|expr:...|none",
       .defaultValue = kNone,
       .help = "a second texture, which is mixed over the first; takes the same values as --texture",
       .hash = "texture-over-sha256"},
      {.name = "texture-over-seed",
       .argument = "S",
       .help = "the seed of the second texture",
       .defaultFor = defaultWithOver("1"),
       .defaultNote = "1",
       .type = {.kind = OptionType::Kind::Whole, .low = 0},
       .idle = idleOverSeed},
      {.name = "texture-over-frequency",
       .argument = "F",
       .help = "the frequency of the second texture; takes the same values as --frequency",
       .defaultFor = [](const Recipe& recipe) -> std::optional<std::string> {
         return overFollowsThickness(recipe) || (hasGrain(recipe) && followsGrain(overOf(recipe)))
                    ? std::optional<std::string>("medium")
                    : std::nullopt;
       },
       .defaultNote = "medium",
       .hash = "texture-over-frequency-sha256",
       .type = frequencyType(),
       .idle = idleOverFrequency},
      {.name = "texture-mix",
       .argument = "M",
       .help =
           "how much of the second texture there is at each place, from 0 (the first one alone) to 1 (the second one "
           "alone); takes the same values as --mask",
       .defaultFor = defaultWithOver("0.5"),
       .defaultNote = "0.5",
       .hash = "texture-mix-sha256",
       .type = {.kind = OptionType::Kind::Control, .low = 0, .high = 1},
       .idle = idleWithoutOver},
      {.name = "texture-symmetry",
       .argument = "N:AXIS|none",
       .defaultValue = kNone,
       .help = "makes the versors symmetric about the middle of the target: 6:y repeats them six times around Y, "
               "6:y:mirror is a kaleidoscope, mirror:x makes left and right alike, mirror:xz also front and back"}};
}

VersorSettings parseVersor(const RecipeReader& reader, bool hasFunction) {
  VersorSettings settings;
  if (std::optional<VersorSource> directions = parseDirections(reader, "texture", hasFunction)) {
    refuseRandomOnly(reader);
    settings.under = std::move(*directions);
  } else {
    settings.under = {.option = "texture", .roots = parseRoots(reader, "texture")};
  }
  settings.grain = parseGrain(reader);
  settings.symmetry = parseSymmetry(reader);
  if (reader.text("texture-over") == kNone) return settings;
  settings.over = parseDirections(reader, "texture-over", hasFunction);
  if (!settings.over) settings.over = {.option = "texture-over", .roots = parseOverRoots(reader)};
  settings.mix = parseShare(reader, "texture-mix");
  return settings;
}

std::vector<NamedFile> filesOf(const VersorSettings& settings) {
  std::vector<NamedFile> files;
  const auto add = [&](const ControlSetting& control) {
    if (!control) return;
    for (NamedFile& file : control->files()) files.push_back(std::move(file));
  };
  for (const VersorSource* source : sourcesOf(settings)) {
    if (source->roots.file) files.push_back(*source->roots.file);
    if (source->field) files.push_back(source->field->file);
    if (source->waves) files.push_back(*source->waves);
    add(source->roots.frequency);
  }
  add(settings.mix);
  if (settings.grain) {
    if (settings.grain->file) files.push_back(*settings.grain->file);
    add(settings.grain->turn);
  }
  return files;
}

std::vector<std::string> grainGridNames(const std::string& control) {
  std::vector<std::string> names;
  for (const char* field : {"-along-cosine", "-along-sine", "-across-cosine", "-across-sine", "-depth"})
    names.push_back(control + field);
  return names;
}

std::vector<std::string> gridNames(const MapControl& control) {
  if (control.kind == MapControl::Kind::Grain) return grainGridNames(control.name);
  return {control.name};
}

std::vector<MapControl> controlsOf(const VersorSettings& settings) {
  std::vector<MapControl> controls;
  std::set<std::string> known;
  for (const VersorSource* source : sourcesOf(settings)) {
    if (!source->formula) continue;
    for (const std::string& name : source->formula->names)
      if (!isCoordinate(name) && known.insert(name).second)
        controls.push_back({"at-" + name, source->option, ControlSetting(expressionSource(name, source->option))});
  }
  const auto addGrain = [&](const char* name, const VersorSource& source) {
    if (settings.grain && source.followsGrain())
      controls.push_back({name, "grain", source.roots.frequency, MapControl::Kind::Grain, settings.grain});
  };
  addGrain("grain", settings.under);
  if (settings.over) addGrain("over-grain", *settings.over);
  if (!settings.over) return controls;
  controls.push_back({"mix", "texture-mix", settings.mix, MapControl::Kind::Share});
  if (settings.over->followsThickness() && !settings.grain)
    controls.push_back(
        {"over-octave", "texture-over-frequency", settings.over->roots.frequency, MapControl::Kind::Frequency});
  return controls;
}

MapFiles readFiles(const VersorSettings& settings) {
  const auto directions = [](const VersorSource& source) {
    return source.field
               ? std::optional(readDirectionGrids(source.field->file.path, source.field->grids, "--" + source.option))
               : std::nullopt;
  };
  const auto waves = [](const VersorSource& source) {
    return source.waves ? std::optional(readWaveFile(source.waves->path)) : std::nullopt;
  };
  MapFiles files{.roots = readRoots(settings.under.roots),
                 .directions = directions(settings.under),
                 .waves = waves(settings.under)};
  if (!settings.over) return files;
  files.overRoots = readRoots(settings.over->roots);
  files.overDirections = directions(*settings.over);
  files.overWaves = waves(*settings.over);
  return files;
}

}  // namespace vdbtools
