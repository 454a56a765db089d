// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/recipe/option_name.h"

namespace vdbtools {
namespace {

constexpr std::string_view kVersor = "versor", kTexture = "texture";

/// The name with another first word, if @a from is its first word.
std::string renamed(std::string_view name, std::string_view from, std::string_view to) {
  const bool isFirst = name.starts_with(from) && (name.size() == from.size() || name[from.size()] == '-');
  return isFirst ? std::string(to) + std::string(name.substr(from.size())) : std::string(name);
}

}  // namespace

std::string optionName(std::string_view entry) { return renamed(entry, kVersor, kTexture); }

std::vector<std::string> optionNames(std::vector<std::string> entries) {
  for (std::string& entry : entries) entry = optionName(entry);
  return entries;
}

std::string recipeEntry(std::string_view name) { return renamed(name, kTexture, kVersor); }

}  // namespace vdbtools
