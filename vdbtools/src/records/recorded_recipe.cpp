// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/records/recorded_recipe.h"

#include "base/json_text.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/file_formats.h"
#include "vdbtools/job/sdf_job.h"
#include "vdbtools/job/sheet_job.h"
#include "vdbtools/recipe/recipe.h"
#include "vdbtools/render/view_options.h"
#include "vdbtools/scene/fractal_options.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <stdexcept>
#include <vector>

namespace vdbtools {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr const char* kRecipeKind = "recipe";
constexpr int kRecipeVersion = 1;

/// The content of a recipe file; null if the file is not one.
OrderedJson recipeJson(const std::filesystem::path& path) {
  OrderedJson json = parsedJson<OrderedJson>(readWholeFile(path));
  const bool ours = json.is_object() && json.value("juliavdb", OrderedJson()) == kRecipeKind;
  return ours ? std::move(json) : OrderedJson();
}

/// @throw DataError
RecordedRecipe readRecipeFile(const std::filesystem::path& path, const MapRegistry& maps) {
  const std::string file = "'" + path.string() + "'";
  const OrderedJson json = recipeJson(path);
  if (json.value("version", OrderedJson()) != kRecipeVersion)
    throw DataError(file + " is a recipe of another version of juliavdb; write it again with 'juliavdb recipe'");
  const OrderedJson command = json.value("command", OrderedJson()), entries = json.value("recipe", OrderedJson());
  if ((command != "fractal" && command != "sdf") || !entries.is_object())
    throw DataError(file +
                    " is a broken recipe: it needs a 'command', which is fractal or sdf, and a 'recipe' with the "
                    "options; write it again with 'juliavdb recipe'");
  const OptionTable table = command == "sdf" ? sdfOptionTable() : fractalOptionTable(maps);
  const std::vector<std::string> hashes = table.hashNames();
  RecordedRecipe recorded{command.get<std::string>(), {}};
  for (const auto& [name, value] : entries.items()) {
    if (!value.is_string())
      throw DataError("the recipe in " + file + " is broken: the value of '" + inOneLine(name) +
                      "' is not a text; put it in quotes");
    const std::string entry = currentName(name);
    if (!table.knows(entry) && std::ranges::find(hashes, entry) == hashes.end())
      throw DataError("the recipe in " + file + " is broken: there is no option '" + inOneLine(name) +
                      "' of 'juliavdb " + recorded.command + "'" + didYouMean(name, table.names()));
    if (!recorded.recipe.emplace(entry, value.get<std::string>()).second)
      throw DataError("the recipe in " + file + " is broken: it has '" + inOneLine(name) + "' twice");
  }
  return recorded;
}

}  // namespace

bool isRecipeFile(const std::filesystem::path& path) {
  if (lowerExtension(path) != ".json") return false;
  try {
    return !recipeJson(path).is_null();
  } catch (const std::runtime_error&) {
    return false;  // it does not exist, or cannot be read
  }
}

std::string noRecipeText(const std::filesystem::path& path) {
  return "'" + path.string() + "' holds no recipe of juliavdb; only a " + namesOf(&FileFormat::recipe) +
         " that it made does";
}

std::string encodeRecipe(const RecordedRecipe& recorded) {
  OrderedJson entries = OrderedJson::object();
  for (const auto& [name, value] : recorded.recipe) entries[name] = value;
  const OrderedJson json{{"juliavdb", kRecipeKind},
                         {"version", kRecipeVersion},
                         {"program", JULIAVDB_VERSION},
                         {"command", recorded.command},
                         {"recipe", std::move(entries)}};
  // Names of files may contain bytes that are not UTF-8.
  return json.dump(1, ' ', false, OrderedJson::error_handler_t::replace) + '\n';
}

RecordedRecipe recordedRecipe(const std::map<std::string, std::string>& metadata, const MapRegistry& maps) {
  const std::string command = commandOfMetadata(metadata);
  if (command.empty()) return {};
  RecordedRecipe recorded{command,
                          recipeFromMetadata(metadata, command == "sdf" ? sdfOptionTable() : fractalOptionTable(maps))};
  // Recipes record every option, but versions without this option kept all crumbs.
  if (command == "fractal") recorded.recipe.try_emplace("crumbs", "keep");
  return recorded;
}

RecordedRecipe readRecordedRecipe(const std::filesystem::path& path, const MapRegistry& maps) {
  RecordedRecipe recorded = isRecipeFile(path) ? readRecipeFile(path, maps)
                            : isSheetCell(path.string())
                                ? RecordedRecipe{"fractal", readSheetCell(path.string()).recipe}
                                : recordedRecipe(readFileTexts(path), maps);
  // A recipe file without one is for any target.
  const bool needsTarget = !isRecipeFile(path) || recorded.recipe.contains("input");
  try {
    if (recorded.command == "fractal") {
      const FractalOptions options = parseFractalOptions(recorded.recipe, maps);
      if (needsTarget) requireTarget(options);
    }
    if (recorded.command == "sdf" && needsTarget) parseSdfOptions(recorded.recipe);
  } catch (const std::invalid_argument& error) {
    throw DataError("the recipe in '" + path.string() + "' is broken: " + error.what());
  }
  return recorded;
}

Recipe readRecordedView(const std::filesystem::path& path) {
  if (!isSheetCell(path.string()) || isRecipeFile(path)) return {};
  const OptionTable table(pictureOptionSpecs("1x1", true));
  Recipe view = readSheetCell(path.string()).view;
  std::erase_if(view, [&](const auto& entry) { return !table.knows(entry.first) || !isAppearance(entry.first); });
  try {
    parseFieldPicture(view, table);
  } catch (const std::invalid_argument& error) {
    throw DataError("the view in '" + path.string() + "' is broken: " + error.what());
  }
  return view;
}

}  // namespace vdbtools
