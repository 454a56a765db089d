// SPDX-License-Identifier: Apache-2.0
#include "scene_recipe.h"

#include "report.h"

#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/records/recorded_recipe.h"
#include "vdbtools/scene/fractal_options.h"

#include <ostream>
#include <utility>
#include <vector>

namespace cli {
namespace {

constexpr const char* kSearchHelp =
    "where to look for the files of a recipe that a VDB, PLY or OBJ holds, if they are neither where it says nor "
    "beside it: by name, then by SHA-256; any number of times";

struct SceneRecipe {
  vdbtools::Recipe given;
  std::filesystem::path holder;  ///< the file that contains it; empty: it was typed
};

SceneRecipe sceneRecipeFor(const CommandLine& line, const std::string& input) {
  vdbtools::Recipe given = line.givenRecipe();
  // The command line may name the inputs of all frames.
  if (!input.empty()) given["input"] = input;
  if (!vdbtools::isVdbPath(input)) return {given, line.configHolder()};
  auto [command, recipe] = vdbtools::readRecordedRecipe(input);
  if (command != "fractal") return {given, line.configHolder()};
  given.erase("input");
  return {vdbtools::overridden(std::move(recipe), given, vdbtools::fractalOptionTable()), input};
}

}  // namespace

void addSearchOption(CommandLine& line) {
  line.addOptions()("search", boost::program_options::value<std::vector<std::string>>()->value_name("DIR"),
                    kSearchHelp);
}

vdbtools::Recipe withFoundFiles(const CommandLine& line, const vdbtools::Recipe& recipe,
                                const std::filesystem::path& holder, const std::string& wayOut) {
  line.requireUse(!holder.empty(), {"search"},
                  "it is for the files of a recipe that the program recorded, and none is read here; leave it out");
  if (holder.empty()) return recipe;
  vdbtools::FileSearch search{.holder = holder, .wayOut = wayOut};
  for (const std::string& folder : line.texts("search")) search.folders.emplace_back(folder);
  vdbtools::FoundFiles found = vdbtools::findRecordedFiles(recipe, search);
  for (const auto& [recorded, path] : found.elsewhere)
    report().text() << "note: '" << recorded.string() << "' of the recipe was found as '" << path.string() << "'\n";
  return std::move(found.recipe);
}

vdbtools::Recipe givenSceneRecipe(const CommandLine& line, const std::string& input) {
  const auto [given, holder] = sceneRecipeFor(line, input);
  return withFoundFiles(line, given, holder);
}

vdbtools::Recipe sceneRecipe(const CommandLine& line, const std::string& input) {
  return vdbtools::completeRecipe(givenSceneRecipe(line, input), vdbtools::fractalOptionTable());
}

}  // namespace cli
