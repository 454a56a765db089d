// SPDX-License-Identifier: Apache-2.0
#include "explore/made_recipe.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/file_formats.h"
#include "vdbtools/recipe/recipe.h"
#include "vdbtools/records/recorded_recipe.h"
#include "vdbtools/scene/fractal_options.h"

#include <stdexcept>

namespace vdbtools::explore {
namespace {

Recipe recipeOfText(std::string_view text) {
  Recipe recipe;
  for (const auto& [line, name, value] : listedOptions(text)) {
    if (name.empty()) throw DataError("the line '" + inOneLine(value) + "' is not NAME = VALUE");
    if (!recipe.emplace(currentName(name), value.empty() ? "true" : value).second)
      throw DataError("'" + inOneLine(name) + "' is set twice; keep only one of them");
  }
  return recipe;
}

}  // namespace

Recipe recipeOfMadeFile(const std::string& name, std::string_view bytes) {
  const std::string extension = lowerExtension(name);
  Recipe recipe;
  if (extension == ".txt" || extension == ".cfg" || extension == ".conf" || extension == ".ini") {
    recipe = recipeOfText(bytes);
  } else {
    if (const FileFormat* const format = findFormat(name); !format || !format->recipe)
      throw std::invalid_argument("'" + inOneLine(name) + "' cannot hold a recipe; drop a " +
                                  namesOf(&FileFormat::recipe) +
                                  " that this program made, or a text of lines NAME = VALUE");
    auto [command, recorded] = recordedRecipe(fileTexts(name, bytes));
    if (command != "fractal")
      throw DataError("'" + inOneLine(name) + "' holds no recipe of 'juliavdb fractal'" +
                      (command.empty() ? "" : "; it was made by 'juliavdb " + inOneLine(command) + "'"));
    recipe = std::move(recorded);
  }
  try {
    parseFractalOptions(recipe);
  } catch (const std::invalid_argument& error) {
    throw DataError("the recipe in '" + inOneLine(name) + "' is broken: " + error.what());
  }
  return recipe;
}

Recipe overTarget(Recipe recorded, const Recipe& target) {
  const bool hadTarget = recorded.contains("input");
  std::vector<OptionSpec> options = targetOptionSpecs();
  for (const OptionSpec& option : options) {
    recorded.erase(option.name);
    if (!option.hash.empty()) recorded.erase(option.hash);
  }
  if (!hadTarget) return recorded;
  for (const OptionSpec& option : options)
    if (const auto entry = target.find(option.name); entry != target.end()) recorded[entry->first] = entry->second;
  return recorded;
}

}  // namespace vdbtools::explore
