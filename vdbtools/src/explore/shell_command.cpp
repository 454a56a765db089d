// SPDX-License-Identifier: Apache-2.0
#include "explore/shell_command.h"

#include "vdbtools/base/text.h"

#include <algorithm>
#include <set>

namespace vdbtools::explore {
namespace {

void appendOption(std::string& command, const std::string& name, const std::string& value) {
  // A value that begins with a dash would be taken for an option.
  command += ' ' + name + (value.starts_with('-') ? '=' : ' ') + shellWord(value);
}

/// Appends the target, and the options that have an effect in any of the runs.
void appendRecipe(std::string& command, const Recipe& recipe, const OptionTable& table,
                  const std::vector<OptionRun>& runs) {
  if (const auto input = recipe.find("input"); input != recipe.end())
    command += ' ' + (input->second.starts_with('-') ? "--input=" : std::string()) + shellWord(input->second);
  for (const std::string& name : table.names()) {
    const auto entry = recipe.find(name);
    const OptionSpec* spec = table.find(name, recipe);
    if (name == "input" || entry == recipe.end() || !spec) continue;
    if (std::all_of(runs.begin(), runs.end(), [&](const OptionRun& run) { return !table.idle(name, run).empty(); }))
      continue;
    if (!spec->argument.empty()) {
      if (!entry->second.empty()) appendOption(command, "--" + name, entry->second);
    } else if (entry->second == "true") {
      command += " --" + name;
    }
  }
}

}  // namespace

std::string fractalCommand(const Recipe& recipe, const OptionTable& table,
                           const std::vector<std::pair<std::string, std::string>>& outputs) {
  std::vector<std::string> files;
  for (const auto& [name, file] : outputs) files.push_back(file);
  std::string command = "juliavdb fractal";
  appendRecipe(command, recipe, table, {{completeRecipe(recipe, table), productsOf(files)}});
  for (const auto& [name, file] : outputs) appendOption(command, name, file.starts_with('-') ? "./" + file : file);
  return command;
}

std::string pictureCommand(const Recipe& recipe, const OptionTable& table, const Recipe& picture,
                           const std::string& file) {
  std::string command = "juliavdb render --field";
  appendRecipe(command, recipe, table, {{completeRecipe(recipe, table), {Product::Picture}}});
  for (const auto& [name, value] : picture) {
    if (value == "true")
      command += " --" + name;
    else if (value != "false" && !value.empty())
      appendOption(command, "--" + name, value);
  }
  appendOption(command, "-o", file.starts_with('-') ? "./" + file : file);
  return command;
}

std::string framesCommand(const farm::FramePlanOptions& options, const std::string& list, const OptionTable& table,
                          const std::string& folder) {
  std::string command = "juliavdb plan frames";
  const std::vector<std::string> files{"frame.vdb"};
  std::set<int> frames;
  for (const farm::KeyedOption& option : options.keys)
    for (const auto& [frame, value] : option.keys) frames.insert(frame);
  std::vector<OptionRun> runs;
  for (const int frame : frames)
    runs.push_back({completeRecipe(farm::recipeAt(options, frame), table), productsOf(files)});
  appendRecipe(command, options.base, table, runs);
  appendOption(command, "--frames", list);
  for (const farm::KeyedOption& option : options.keys) {
    for (const auto& [frame, value] : option.keys)
      appendOption(command, "--key", option.name + '@' + std::to_string(frame) + '=' + value);
    if (option.ease != farm::Ease::Linear)
      appendOption(command, "--ease", option.name + (option.ease == farm::Ease::Smooth ? "=smooth" : "=step"));
  }
  if (!options.name.empty()) appendOption(command, "--name", options.name);
  appendOption(command, "-o", folder.starts_with('-') ? "./" + folder : folder);
  return command;
}

Recipe shortestRecipe(const Recipe& recipe, const OptionTable& table) {
  const Recipe completed = completeRecipe(recipe, table);
  Recipe shortest = recipe;
  // An entry may follow from others only after a third entry has been removed.
  for (std::size_t before = 0; before != shortest.size();) {
    before = shortest.size();
    for (const auto& [name, value] : Recipe(shortest)) {
      shortest.erase(name);
      if (completeRecipe(shortest, table) != completed) shortest[name] = value;
    }
  }
  return shortest;
}

}  // namespace vdbtools::explore
