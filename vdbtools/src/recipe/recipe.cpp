// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/recipe/recipe.h"

#include <algorithm>

namespace vdbtools {
namespace {

constexpr const char* kPrefix = "julia_";
constexpr const char* kCommandName = "julia_command";
constexpr const char* kVersionName = "julia_version";

}  // namespace

std::string metadataName(const std::string& option) {
  std::string name = kPrefix + option;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

std::map<std::string, std::string> recipeToMetadata(const Recipe& recipe, const std::string& command) {
  std::map<std::string, std::string> metadata;
  for (const auto& [option, value] : recipe) metadata[metadataName(option)] = value;
  metadata[kCommandName] = command;
  metadata[kVersionName] = JULIAVDB_VERSION;
  return metadata;
}

std::string commandOfMetadata(const std::map<std::string, std::string>& metadata) {
  const auto command = metadata.find(kCommandName);
  return command == metadata.end() ? std::string() : command->second;
}

Recipe recipeFromMetadata(const std::map<std::string, std::string>& metadata, const OptionTable& table) {
  Recipe recipe;
  const auto take = [&](const std::string& option) {
    for (const std::string& name : {formerName(option), option})
      if (const auto found = metadata.find(metadataName(name)); found != metadata.end()) recipe[option] = found->second;
  };
  for (const std::string& option : table.names()) take(option);
  for (const std::string& hash : table.hashNames()) take(hash);
  return recipe;
}

}  // namespace vdbtools
