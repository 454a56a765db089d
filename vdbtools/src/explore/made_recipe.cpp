// SPDX-License-Identifier: Apache-2.0
#include "explore/made_recipe.h"

#include "base/json_text.h"
#include "formats/vdb_head.h"
#include "mesh_files/mesh_comments.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/recipe/option_list.h"
#include "vdbtools/recipe/option_name.h"
#include "vdbtools/records/recorded_recipe.h"
#include "vdbtools/scene/fractal_options.h"

#include <nlohmann/json.hpp>

#include <bit>
#include <cstdint>
#include <cstring>
#include <sstream>
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

/// The texts among the extras of the asset, where a GLB stores its recipe.
std::map<std::string, std::string> glbExtras(std::string_view bytes) {
  static_assert(std::endian::native == std::endian::little, "the numbers are read as they lie in the file");
  // The magic number, the version and the total length; then the length and the type of the first chunk.
  constexpr std::size_t kHead = 20;
  std::uint32_t words[kHead / 4] = {};
  if (bytes.size() < kHead || !bytes.starts_with("glTF"))
    throw DataError("this is not a GLB: it does not begin as one does");
  std::memcpy(words, bytes.data(), kHead);
  const std::string_view rest = bytes.substr(kHead);
  constexpr std::uint32_t kMostDescription = 16 << 20;  // bytes; this program writes a few thousand
  if (words[3] > rest.size()) throw DataError("the GLB ends before its description does");
  if (words[3] > kMostDescription) throw DataError("the GLB's description is too large to be one of this program");
  const nlohmann::json description = parsedJson<nlohmann::json>(rest.substr(0, words[3]));
  std::map<std::string, std::string> metadata;
  if (!description.is_object() || !description.contains("asset")) return metadata;
  const nlohmann::json& asset = description["asset"];
  if (!asset.is_object() || !asset.contains("extras") || !asset["extras"].is_object()) return metadata;
  for (const auto& [key, value] : asset["extras"].items())
    if (value.is_string()) metadata[key] = value.get<std::string>();
  return metadata;
}

}  // namespace

Recipe recipeOfMadeFile(const std::string& name, std::string_view bytes) {
  const std::string extension = lowerExtension(name);
  Recipe recipe;
  if (extension == ".txt" || extension == ".cfg" || extension == ".conf" || extension == ".ini") {
    recipe = recipeOfText(bytes);
  } else {
    std::map<std::string, std::string> metadata;
    if (extension == ".vdb") {
      metadata = vdbHeadMetadata(bytes);
    } else if (extension == ".ply" || extension == ".obj") {
      std::istringstream stream{std::string(bytes)};
      metadata = readMeshComments(stream, extension);
    } else if (extension == ".glb") {
      metadata = glbExtras(bytes);
    } else {
      throw std::invalid_argument(
          "'" + inOneLine(name) +
          "' cannot hold a recipe; drop a VDB, PLY, OBJ or GLB that this program made, or a text of "
          "lines NAME = VALUE");
    }
    auto [command, recorded] = recordedRecipe(metadata);
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
