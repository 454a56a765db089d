// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/job/sheet_job.h"

#include "base/json_text.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/recipe/recipe.h"

#include <nlohmann/json.hpp>

#include <stdexcept>

namespace vdbtools {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kKind = "sheet";
constexpr int kVersion = 1;

/// "sheet.json#7" in two parts; the second is empty if there is none.
std::pair<std::string, std::string> partsOf(const std::string& name) {
  const std::size_t mark = name.rfind('#');
  if (mark == std::string::npos) return {name, {}};
  return {name.substr(0, mark), name.substr(mark + 1)};
}

/// The JSON of a contact sheet; a value of another kind if the file is not one.
Json parsed(const std::filesystem::path& path) {
  Json json = parsedJson<Json>(readWholeFile(path));
  const bool ours = json.is_object() && json.value("juliavdb", Json()) == kKind;
  return ours ? std::move(json) : Json();
}

Recipe recipeOf(const Json& json) {
  Recipe recipe;
  for (const auto& [option, value] : json.items()) recipe[currentName(option)] = value.get<std::string>();
  return recipe;
}

}  // namespace

std::string encodeSheet(const Sheet& sheet) {
  Json vary = Json::array(), cells = Json::array();
  for (const VariedOption& option : sheet.varied) vary.push_back({{"option", option.name}, {"values", option.values}});
  for (const SheetCell& cell : sheet.cells) {
    Json entry{{"number", cells.size() + 1}, {"varied", cell.varied}, {"recipe", cell.recipe}};
    if (!cell.view.empty()) entry["view"] = cell.view;
    if (!cell.error.empty()) entry["error"] = cell.error;
    if (!cell.finer.empty()) entry["finer"] = cell.finer;
    cells.push_back(std::move(entry));
  }
  const Json json{{"juliavdb", kKind},  {"version", kVersion},      {"program", JULIAVDB_VERSION},
                  {"vary", vary},       {"rows", sheet.rows},       {"columns", sheet.columns},
                  {"view", sheet.view}, {"cells", std::move(cells)}};
  // Names of files may contain bytes that are not UTF-8.
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + '\n';
}

bool isSheetFile(const std::filesystem::path& path) {
  try {
    return !parsed(path).is_null();
  } catch (const std::runtime_error&) {
    return false;
  }
}

bool isSheetCell(const std::string& name) { return lowerExtension(sheetOfCell(name)) == ".json"; }

std::string sheetOfCell(const std::string& name) { return partsOf(name).first; }

std::vector<SheetCell> readSheetCells(const std::filesystem::path& path) {
  const Json json = parsed(path);
  if (json.is_null()) throw DataError("'" + path.string() + "' is no contact sheet of juliavdb");
  try {
    if (json.at("version") != kVersion)
      throw DataError("'" + path.string() +
                      "' is a contact sheet of another version of juliavdb; make the sheet again");
    std::vector<SheetCell> cells;
    for (const Json& cell : json.at("cells"))
      cells.push_back({recipeOf(cell.at("varied")), recipeOf(cell.at("recipe")), cell.value("error", ""),
                       cell.value("finer", ""), recipeOf(cell.value("view", Json::object()))});
    return cells;
  } catch (const nlohmann::json::exception&) {
    throw DataError("'" + path.string() + "' is a broken contact sheet; make the sheet again");
  }
}

SheetCell readSheetCell(const std::string& name) {
  const auto [file, number] = partsOf(name);
  std::vector<SheetCell> cells = readSheetCells(file);
  const std::string which = "'" + file + "' has the cells 1 to " + std::to_string(cells.size());
  if (number.empty()) throw std::invalid_argument(which + "; name one of them, as in " + file + "#1");
  const std::optional<std::size_t> cell = wholeFromText<std::size_t>(number);
  if (!cell || *cell < 1 || *cell > cells.size())
    throw std::invalid_argument(which + "; there is no cell '" + number + "'");
  return std::move(cells[*cell - 1]);
}

}  // namespace vdbtools
