// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/recipe/option_table.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

using nlohmann::json;

/// Whether a variant reads the option, and does not only keep it for others.
bool reads(const OptionVariant& variant, const OptionSpec& spec) {
  return !spec.kept || std::any_of(variant.options.begin(), variant.options.end(),
                                   [&](const OptionSpec& own) { return own.name == spec.name; });
}

/// The defaults of a recipe that says no more than its variant and, where it takes one, that it has a target.
Recipe defaultsOf(Recipe recipe, const OptionTable& table) {
  constexpr const char* kTarget = "input";
  if (table.find(kTarget, recipe)) recipe.emplace(kTarget, "");
  recipe = completeRecipe(std::move(recipe), table);
  recipe.erase(kTarget);
  return recipe;
}

const char* nameOf(OptionType::Kind kind) {
  switch (kind) {
    case OptionType::Kind::Text: return "text";
    case OptionType::Kind::Flag: return "flag";
    case OptionType::Kind::Number: return "number";
    case OptionType::Kind::Whole: return "whole";
    case OptionType::Kind::Choice: return "choice";
    case OptionType::Kind::List: return "list";
    case OptionType::Kind::Vector: return "vector";
    case OptionType::Kind::Control: return "control";
  }
  return "";
}

json typeData(const OptionSpec& spec) {
  const OptionType& type = spec.type;
  json data = {{"kind", nameOf(spec.argument.empty() ? OptionType::Kind::Flag : type.kind)}};
  if (std::isfinite(type.low)) data["low"] = type.low;
  if (std::isfinite(type.high)) data["high"] = type.high;
  if (type.excludesLow) data["excludesLow"] = true;
  if (type.excludesHigh) data["excludesHigh"] = true;
  if (!type.words.empty()) data["words"] = type.words;
  return data;
}

}  // namespace

std::string optionData(const OptionTable& table) {
  std::vector<std::pair<const OptionVariant*, Recipe>> variants;
  for (const OptionVariant& variant : table.variants())
    variants.emplace_back(&variant, defaultsOf({{table.selector(), variant.name}}, table));
  if (variants.empty()) variants.emplace_back(nullptr, defaultsOf({}, table));

  json all = json::array();
  for (const OptionListing& listing : table.listing()) {
    json data = {
        {"name", listing.name}, {"argument", listing.argument}, {"help", listing.help}, {"displaces", json::array()}};
    if (!table.selector().empty()) data.update({{"maps", json::array()}, {"defaults", json::object()}});
    for (const auto& [variant, recipe] : variants) {
      const OptionSpec* const spec = table.find(listing.name, recipe);
      if (!spec || (variant && !reads(*variant, *spec))) continue;
      if (!data.contains("type")) data["type"] = typeData(*spec);
      if (!spec->alternative.empty()) data["alternative"] = spec->alternative;
      if (!spec->displaces.empty()) data["displaces"] = spec->displaces;
      if (variant) data["maps"].push_back(variant->name);
      const auto found = recipe.find(listing.name);
      const std::optional<std::string> value = found != recipe.end() ? found->second : spec->defaultValue;
      if (!value) continue;
      data.emplace("default", *value);
      if (variant) data["defaults"][variant->name] = *value;
    }
    all.push_back(std::move(data));
  }
  return all.dump();
}

}  // namespace vdbtools
