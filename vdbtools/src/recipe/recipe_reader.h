// SPDX-License-Identifier: Apache-2.0
/// @file recipe_reader.h
/// Recipes into options: every command's registry of options is read by the same rules and refused in the same words.
#pragma once

#include "vdbtools/recipe/recipe.h"

#include <algorithm>
#include <charconv>
#include <initializer_list>
#include <optional>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace vdbtools {

// Facts that are recorded beside the options: what the input files held.
inline constexpr const char* kHashOptions[] = {"source-sha256", "versor-sha256"};

[[noreturn]] inline void refuse(const std::string& option, const std::string& text, const std::string& wanted) {
  throw std::invalid_argument("--" + option + " is '" + text + "'; it must be " + wanted);
}

inline std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  if (text.empty() || text.back() == separator) parts.emplace_back();
  return parts;
}

/// What a recipe says of an option, if anything.
inline std::optional<std::string> given(const Recipe& recipe, const std::string& option) {
  const auto found = recipe.find(option);
  return found == recipe.end() ? std::nullopt : std::optional(found->second);
}

/// The map of a recipe; of an unknown one, which parsing refuses, the first.
MapKind mapOf(const Recipe& recipe);

/// Reads a recipe's entries by the registry: known names only, defaults filled in.
class RecipeReader {
 public:
  RecipeReader(const Recipe& recipe, std::span<const OptionSpec> specs)
      : mRecipe(completeRecipe(recipe, specs)), mSpecs(specs) {
    for (const auto& [name, value] : recipe) {
      const bool hash = std::find(std::begin(kHashOptions), std::end(kHashOptions), name) != std::end(kHashOptions);
      const OptionSpec* spec = find(name);
      if (!hash && !spec) throw std::invalid_argument("--" + name + " is not an option here; see --help");
      if (spec && !(spec->maps & mapBit(mapOf(recipe)))) refuseOfMap(name, value);
    }
  }

  [[noreturn]] void refuse(const std::string& name, const std::string& wanted) const {
    vdbtools::refuse(name, text(name), wanted);
  }

  bool has(const std::string& name) const { return mRecipe.contains(name); }

  std::string text(const std::string& name) const { return given(mRecipe, name).value_or(""); }

  bool flag(const std::string& name) const {
    const std::string value = text(name);
    if (value.empty() || value == "false") return false;
    if (value != "true") vdbtools::refuse(name, value, "true or false");
    return true;
  }

  double number(const std::string& name) const { return parseNumber(name, text(name)); }

  double positive(const std::string& name) const {
    const double value = number(name);
    if (!(value > 0)) vdbtools::refuse(name, text(name), "above 0");
    return value;
  }

  double notNegative(const std::string& name) const {
    const double value = number(name);
    if (!(value >= 0)) vdbtools::refuse(name, text(name), "0 or more");
    return value;
  }

  template <class Integer = int>
  Integer integer(const std::string& name, Integer low, Integer high) const {
    const std::string value = text(name);
    Integer result{};
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), result);
    if (error != std::errc{} || end != value.data() + value.size() || result < low || result > high)
      vdbtools::refuse(name, value, "a whole number from " + std::to_string(low) + " to " + std::to_string(high));
    return result;
  }

  openvdb::Vec3d vector(const std::string& name) const {
    const std::vector<double> values = parseNumbers(name, text(name), 3);
    return {values[0], values[1], values[2]};
  }

  template <class Enum>
  Enum choice(const std::string& name, std::initializer_list<std::pair<const char*, Enum>> choices) const {
    return choice<Enum>(name, std::span(choices.begin(), choices.size()));
  }
  template <class Enum>
  Enum choice(const std::string& name, std::span<const std::pair<const char*, Enum>> choices) const {
    const std::string value = text(name);
    std::string list;
    for (const auto& [word, result] : choices) {
      if (value == word) return result;
      list += (list.empty() ? "" : ", ") + std::string(word);
    }
    vdbtools::refuse(name, value, "one of " + list);
  }

  VoxelChoice voxels(const std::string& resolution, const std::string& voxelSize) const {
    VoxelChoice choice;
    if (has(resolution) && has(voxelSize))
      throw std::invalid_argument("--" + resolution + " and --" + voxelSize + " say the same; give one of them");
    if (has(voxelSize)) choice.voxelSize = positive(voxelSize);
    if (!has(voxelSize)) choice.resolution = positive(resolution);
    return choice;
  }

 private:
  const OptionSpec* find(const std::string& name) const {
    for (const OptionSpec& spec : mSpecs)
      if (name == spec.name) return &spec;
    return nullptr;
  }

  [[noreturn]] void refuseOfMap(const std::string& option, const std::string& value) const {
    if (option == "input")
      throw std::invalid_argument("the map " + text("map") + " has no target; leave '" + value + "' out");
    throw std::invalid_argument("--" + option + " means nothing to the map " + text("map") + "; leave it out" +
                                (option == "escape" ? ", or give --radius" : "") +
                                (option == "radius" ? ", or give --escape" : ""));
  }

  Recipe mRecipe;
  std::span<const OptionSpec> mSpecs;
};

}  // namespace vdbtools
