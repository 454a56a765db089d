// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/records/recorded_recipe.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/sdf_job.h"
#include "vdbtools/job/sheet_file.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/render/view_options.h"
#include "vdbtools/scene/fractal_options.h"

#include <stdexcept>

namespace vdbtools {

RecordedRecipe recordedRecipe(const std::map<std::string, std::string>& metadata, const MapRegistry& maps) {
  const std::string command = commandOfMetadata(metadata);
  if (command.empty()) return {};
  RecordedRecipe recorded{command,
                          recipeFromMetadata(metadata, command == "sdf" ? sdfOptionTable() : fractalOptionTable(maps))};
  // Recipes record every option, and versions before this one kept all crumbs.
  if (command == "fractal") recorded.recipe.try_emplace("crumbs", "keep");
  return recorded;
}

RecordedRecipe readRecordedRecipe(const std::filesystem::path& path, const MapRegistry& maps) {
  RecordedRecipe recorded =
      isSheetCell(path.string())
          ? RecordedRecipe{"fractal", readSheetCell(path.string()).recipe}
          : recordedRecipe(isVdbPath(path) ? readVdbMetadata(path) : readMeshComments(path), maps);
  try {
    if (recorded.command == "fractal") requireTarget(parseFractalOptions(recorded.recipe, maps));
    if (recorded.command == "sdf") parseSdfOptions(recorded.recipe);
  } catch (const std::invalid_argument& error) {
    throw DataError("the recipe in '" + path.string() + "' is broken: " + error.what());
  }
  return recorded;
}

Recipe readRecordedView(const std::filesystem::path& path) {
  if (!isSheetCell(path.string())) return {};
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
