// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/recipe/recipe.h"

namespace vdbtools {
namespace {

constexpr std::string_view kFormer = "versor", kNow = "texture";

/// The name with another first word, if @a from is its first word.
std::string renamed(std::string_view name, std::string_view from, std::string_view to) {
  const bool isFirst = name.starts_with(from) && (name.size() == from.size() || name[from.size()] == '-');
  return isFirst ? std::string(to) + std::string(name.substr(from.size())) : std::string(name);
}

}  // namespace

std::string currentName(std::string_view name) { return renamed(name, kFormer, kNow); }

std::string formerName(std::string_view name) { return renamed(name, kNow, kFormer); }

}  // namespace vdbtools
