// SPDX-License-Identifier: Apache-2.0
/// @file recipe_reader.h
/// Recipes into values: the options of every command are read by the same rules and refused in the same words. Errors
/// name the option as the command line has it, for this is where it is read.
#pragma once

#include "vdbtools/base/voxel_choice.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/recipe/option_table.h"
#include "vdbtools/recipe/option_value.h"

#include <openvdb/Types.h>
#include <openvdb/math/BBox.h>

#include <stdexcept>
#include <string>

namespace vdbtools {

/// A recipe by a table: known options only, defaults filled in. What it reads is checked when it is read.
class RecipeReader {
 public:
  /// @throw std::invalid_argument  as OptionTable::requireFits()
  RecipeReader(const Recipe& recipe, const OptionTable& table) : mRecipe(completeRecipe(recipe, table)), mTable(table) {
    table.requireFits(recipe);
  }

  const Recipe& recipe() const { return mRecipe; }

  /// @param wanted  what follows "it must be"
  [[noreturn]] void refuse(const std::string& name, const std::string& wanted) const {
    vdbtools::refuse(name, text(name), wanted);
  }

  /// Whether it was given or has a default.
  bool has(const std::string& name) const { return mRecipe.contains(name); }

  /// "" if there is none.
  std::string text(const std::string& name) const {
    const auto found = mRecipe.find(name);
    return found == mRecipe.end() ? std::string() : found->second;
  }

  bool flag(const std::string& name) const {
    const std::string value = text(name);
    if (value.empty() || value == "false") return false;
    if (value != "true") refuse(name, "true or false");
    return true;
  }

  double number(const std::string& name) const { return parseNumber(name, text(name)); }

  double positive(const std::string& name) const {
    const double value = number(name);
    if (!(value > 0)) refuse(name, "above 0");
    return value;
  }

  template <class Integer = int>
  Integer integer(const std::string& name, Integer low, Integer high) const {
    return parseInteger<Integer>(name, text(name), low, high);
  }

  openvdb::Vec3d vector(const std::string& name) const { return parseVector(name, text(name)); }

  VoxelChoice voxels(const std::string& resolution, const std::string& voxelSize) const {
    if (has(resolution) && has(voxelSize))
      throw std::invalid_argument("--" + resolution + " and --" + voxelSize +
                                  " set the same thing; give only one of them");
    if (has(voxelSize)) return {.voxelSize = positive(voxelSize)};
    return {.resolution = positive(resolution)};
  }

  /// The file that an option names, with the hash that the recipe has for it.
  NamedFile file(const std::string& name) const { return file(name, text(name)); }
  /// The same where the path is only a part of the value.
  NamedFile file(const std::string& name, const std::string& path) const {
    const OptionSpec* spec = mTable.find(name, mRecipe);
    const std::string hash = spec ? spec->hash : std::string();
    return {path, hash, text(hash)};
  }

 private:
  Recipe mRecipe;
  const OptionTable& mTable;
};

}  // namespace vdbtools
