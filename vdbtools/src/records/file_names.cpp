// SPDX-License-Identifier: Apache-2.0
#include "records/file_names.h"

#include "vdbtools/recipe/option_value.h"

namespace vdbtools {
namespace {

std::string renamed(const std::string& value, const std::map<std::string, std::string>& names) {
  const auto other = [&](const std::string& text) {
    const auto found = names.find(text);
    return found == names.end() ? text : found->second;
  };
  if (names.contains(value)) return other(value);
  std::string result;
  for (const std::string& part : split(value, ':')) result += ':' + other(part);
  return result.substr(1);
}

}  // namespace

Recipe withFileNames(const Recipe& recipe, const std::map<std::string, std::string>& names, const OptionTable& table) {
  Recipe result = recipe;
  for (auto& [name, value] : result)
    if (const OptionSpec* option = table.find(name, recipe); option && !option->hash.empty())
      value = renamed(value, names);
  return result;
}

}  // namespace vdbtools
