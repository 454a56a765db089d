// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/explore/shell_command.h"

#include <algorithm>

namespace vdbtools {
namespace {

/// Characters that mean themselves to every shell, wherever they stand.
bool isPlain(char c) {
  constexpr std::string_view kOthers = "%+,-./:@_";
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || kOthers.find(c) != kOthers.npos;
}

}  // namespace

std::string shellWord(std::string_view word) {
  if (!word.empty() && std::all_of(word.begin(), word.end(), isPlain)) return std::string(word);
  std::string quoted = "'";
  for (const char c : word) {
    if (c == '\'')
      quoted += "'\\''";
    else
      quoted += c;
  }
  return quoted + "'";
}

std::string fractalCommand(const Recipe& recipe, const OptionTable& table,
                           const std::vector<std::pair<std::string, std::string>>& outputs) {
  std::string command = "juliavdb fractal";
  if (const auto input = recipe.find("input"); input != recipe.end())
    command += ' ' + (input->second.starts_with('-') ? "--input=" : std::string()) + shellWord(input->second);
  const auto option = [&](const std::string& name, const std::string& value) {
    // A value that begins with a dash would be taken for an option.
    command += ' ' + name + (value.starts_with('-') ? '=' : ' ') + shellWord(value);
  };
  std::vector<std::string> files;
  for (const auto& [name, file] : outputs) files.push_back(file);
  const OptionRun run{completeRecipe(recipe, table), productsOf(files)};
  for (const std::string& name : table.names()) {
    const auto entry = recipe.find(name);
    const OptionSpec* spec = table.find(name, recipe);
    if (name == "input" || entry == recipe.end() || !spec || !table.idle(name, run).empty()) continue;
    if (!spec->argument.empty()) {
      if (!entry->second.empty()) option("--" + name, entry->second);
    } else if (entry->second == "true") {
      command += " --" + name;
    }
  }
  for (const auto& [name, file] : outputs) option(name, file.starts_with('-') ? "./" + file : file);
  return command;
}

Recipe shortestRecipe(const Recipe& recipe, const OptionTable& table) {
  const Recipe completed = completeRecipe(recipe, table);
  Recipe shortest = recipe;
  // What one entry says may follow from others only once a third is gone.
  for (std::size_t before = 0; before != shortest.size();) {
    before = shortest.size();
    for (const auto& [name, value] : Recipe(shortest)) {
      shortest.erase(name);
      if (completeRecipe(shortest, table) != completed) shortest[name] = value;
    }
  }
  return shortest;
}

}  // namespace vdbtools
