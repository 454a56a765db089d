// SPDX-License-Identifier: Apache-2.0
#include "farm/variant_plan.h"

#include "records/file_names.h"
#include "scene/file_hashes.h"

#include "vdbtools/files/frames.h"
#include "vdbtools/recipe/option_value.h"
#include "vdbtools/scene/fractal_options.h"
#include "vdbtools/scene/scene.h"

#include <algorithm>
#include <map>
#include <stdexcept>

namespace vdbtools::farm {
namespace {

constexpr const char* kOut = "out/";

void requireNames(PlanKind kind, const VariantNames& names) {
  if (names.name.empty() || names.name.find('/') != std::string::npos || hasFramePattern(names.name))
    refuse("name", names.name, "a part of a file name, without a folder and without a place for the frame");
  requireMakes(kind, names.makes);
}

/// A complete and checked recipe with the hashes of its files.
Recipe checkedRecipe(const Variant& variant, const OptionTable& table, FileHashes& hashes,
                     const std::filesystem::path& folder) {
  try {
    Recipe recipe = completeRecipe(variant.recipe, table);
    const FractalOptions options = parseFractalOptions(recipe);
    requireTarget(options);
    for (const auto& [name, hash] : hashes.of(options)) recipe[name] = hash;
    withAbsoluteNames(recipe, folder);
    return recipe;
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(variant.called + ": " + error.what());
  }
}

bool isIn(const Recipe& recipe, const Recipe::value_type& entry) {
  const auto found = recipe.find(entry.first);
  return found != recipe.end() && found->second == entry.second;
}

/// Moves the entries that all tasks share to the plan. Entries that a task's own entries would displace there, such as
/// the hash of a file with a different name in each task, stay with the tasks.
void shareEntries(Manifest& manifest) {
  std::vector<Recipe> whole;
  for (const PlannedTask& task : manifest.tasks) whole.push_back(task.recipe);
  Recipe& shared = manifest.recipe;
  shared = whole.at(0);
  for (const Recipe& recipe : whole) std::erase_if(shared, [&](const auto& entry) { return !isIn(recipe, entry); });
  for (bool isStable = false; !isStable;) {
    isStable = true;
    for (std::size_t i = 0; i < whole.size(); ++i) {
      Recipe& own = manifest.tasks[i].recipe = whole[i];
      std::erase_if(own, [&](const auto& entry) { return isIn(shared, entry); });
    }
    for (std::size_t i = 0; i < whole.size(); ++i) {
      const Recipe together = taskRecipe(manifest, i + 1);
      for (const auto& entry : whole[i])
        if (!isIn(together, entry) && shared.erase(entry.first) > 0) isStable = false;
    }
  }
}

}  // namespace

void requireMakes(PlanKind kind, const std::vector<std::string>& makes) {
  if (kind == PlanKind::Tiles && makes == std::vector<std::string>{kMakeCount}) return;
  const std::vector<std::string> known = writtenFormats();
  std::vector<std::string> seen;
  std::string wanted = "a list of " + joined(writtenFormats());
  if (kind == PlanKind::Tiles) wanted += std::string("; or ") + kMakeCount + " alone";
  for (const std::string& extension : makes) {
    if (std::find(known.begin(), known.end(), extension) == known.end()) refuse("make", extension, wanted);
    if (std::find(seen.begin(), seen.end(), extension) != seen.end())
      refuse("make", extension, "a list in which nothing occurs twice");
    seen.push_back(extension);
  }
  if (seen.empty()) refuse("make", "", wanted);
}

Manifest planVariants(PlanKind kind, const std::vector<Variant>& variants, const VariantNames& names) {
  requireNames(kind, names);
  const OptionTable table = fractalOptionTable();
  const std::filesystem::path folder = std::filesystem::current_path();
  Manifest manifest{.kind = kind, .makes = names.makes, .metadata = {{kFolderFact, folder.string()}}};
  FileHashes hashes;
  for (const Variant& variant : variants) {
    PlannedTask& task = manifest.tasks.emplace_back();
    task.recipe = checkedRecipe(variant, table, hashes, folder);
    for (const std::string& extension : names.makes)
      task.writes.push_back(kOut + expandFrame(names.name + "." + extension, variant.number));
  }
  shareEntries(manifest);
  return manifest;
}

std::filesystem::path folderOfNames(const Manifest& manifest) { return manifest.metadata.at(kFolderFact); }

Recipe withAbsoluteNames(const Recipe& recipe, const std::filesystem::path& folder) {
  std::map<std::string, std::string> names;
  for (const NamedFile& file : filesOf(parseFractalOptions(recipe)))
    if (file.path.is_relative()) names[file.path.string()] = (folder / file.path).string();
  if (names.empty()) return recipe;
  Recipe result = withFileNames(recipe, names, fractalOptionTable());
  for (const NamedFile& file : filesOf(parseFractalOptions(result)))
    if (file.path.is_relative())
      throw std::invalid_argument("the name of '" + file.path.string() +
                                  "' cannot be made independent of the working folder; give an absolute one");
  return result;
}

}  // namespace vdbtools::farm
