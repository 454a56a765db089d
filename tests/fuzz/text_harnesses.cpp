// SPDX-License-Identifier: Apache-2.0
// What users type: expressions, controls and ramps, options, keys of sequences, lists of options.
#include "harness.h"

#include "config_list.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/control/control.h"
#include "vdbtools/farm/plans.h"
#include "vdbtools/job/sdf_job.h"
#include "vdbtools/recipe/recipe.h"
#include "vdbtools/recipe/recipe_reader.h"
#include "vdbtools/scene/fractal_options.h"

#include "julia/expression.h"
#include "julia/expression_pair.h"

#include <array>
#include <stdexcept>
#include <string>
#include <vector>

namespace fuzz {
namespace {

using namespace vdbtools;
using namespace vdbtools::farm;

/// Longer texts than these say nothing new, and take the time of their parsers' squares.
constexpr std::size_t kMostText = 4096;

std::vector<std::string> linesOf(std::string_view bytes) {
  std::vector<std::string> lines;
  while (!bytes.empty()) {
    const std::size_t end = std::min(bytes.find('\n'), bytes.size());
    lines.emplace_back(bytes.substr(0, end));
    bytes.remove_prefix(std::min(end + 1, bytes.size()));
  }
  return lines;
}

void readExpression(std::string_view bytes) {
  const std::string text(bytes.substr(0, kMostText));
  julia::namesInExpression(text);
  julia::Expression expression(text, {"x", "y", "z", "phi"});
  expression.at(std::array{0.5, -0.25, 2.0, 0.0});
}

void readPair(std::string_view bytes) {
  const std::string_view text = bytes.substr(0, kMostText);
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view rest = text.substr(std::min(end + 1, text.size()));
  const julia::ExpressionPair pair(std::string(text.substr(0, end)), std::string(rest));
}

void readControl(std::string_view bytes) {
  static const OptionTable table({{.name = "alpha", .argument = "A", .defaultValue = "1"}});
  const auto parsed = [](const std::string& text) {
    return parseControl(RecipeReader({{"alpha", text}}, table), "alpha");
  };
  const std::shared_ptr<const ControlSource> source = parsed(std::string(bytes.substr(0, kMostText)));
  const std::string text = source->text();
  if (parsed(text)->text() != text) throw std::logic_error("a control's text does not describe it");
  if (!source->files().empty() || source->needsTarget()) return;
  const openvdb::BBoxd box(openvdb::Vec3d(-1, 0, 2), openvdb::Vec3d(1, 0.5, 5));
  const Control control = source->bind({.targetBox = box});
  const auto [least, most] = control.range();
  const double value = control.at({0.25, 0.25, 3});
  if (!(value >= least && value <= most)) throw std::logic_error("a control leaves its range");
}

void readOptions(std::string_view bytes) {
  const bool sdf = takeChoice(bytes, 2) == 1;
  Recipe recipe;
  for (const std::string& line : linesOf(bytes)) {
    const std::size_t equals = std::min(line.find('='), line.size());
    recipe[line.substr(0, equals)] = equals < line.size() ? line.substr(equals + 1) : "true";
  }
  if (sdf)
    parseSdfOptions(recipe);
  else
    parseFractalOptions(recipe);
}

void readKeys(std::string_view bytes) {
  static const OptionTable table = fractalOptionTable();
  constexpr std::size_t kMostValues = 1000;
  const std::size_t kind = takeChoice(bytes, 3);
  if (kind == 0) {
    parseFrames(std::string(bytes));
  } else if (kind == 1) {
    parseVaried(std::string(bytes), table, kMostValues);
  } else {
    for (const KeyedOption& option : parseKeys(linesOf(bytes), {}, table))
      for (const int frame : {-1, 1, 7, 100}) valueAt(option, frame);
  }
}

/// What --config reads, from its bytes to the job.
void readConfig(std::string_view bytes) {
  static const OptionTable tables[] = {fractalOptionTable(), sdfOptionTable()};
  const std::size_t kind = takeChoice(bytes, std::size(tables));
  const Recipe list = cli::readConfigList(std::string(bytes), "options.txt", tables[kind]);
  const Recipe recipe = completeRecipe(overridden(list, {{"input", "given.obj"}}, tables[kind]), tables[kind]);
  if (kind == 0)
    parseFractalOptions(recipe);
  else
    parseSdfOptions(recipe);
}

constexpr std::array<Harness, 6> kTextHarnesses = {{
    {"expression", readExpression, Refusal::Usage},
    {"pair", readPair, Refusal::Usage},
    {"control", readControl, Refusal::Usage},
    {"options", readOptions, Refusal::Usage},
    {"keys", readKeys, Refusal::Usage},
    {"config", readConfig, Refusal::Usage},
}};

}  // namespace

std::span<const Harness> textHarnesses() { return kTextHarnesses; }

}  // namespace fuzz
