// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/recipe/option_data.h"

#include "vdbtools/recipe/option_name.h"

#include <nlohmann/json.hpp>

#include <algorithm>
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

}  // namespace

std::string optionData(const OptionTable& table) {
  std::vector<std::pair<const OptionVariant*, Recipe>> variants;
  for (const OptionVariant& variant : table.variants())
    variants.emplace_back(&variant, defaultsOf({{table.selector(), variant.name}}, table));
  if (variants.empty()) variants.emplace_back(nullptr, defaultsOf({}, table));

  json all = json::array();
  for (const OptionListing& listing : table.listing()) {
    json data = {{"name", optionName(listing.name)},
                 {"entry", listing.name},
                 {"argument", listing.argument},
                 {"help", listing.help},
                 {"displaces", json::array()}};
    if (!table.selector().empty()) data.update({{"maps", json::array()}, {"defaults", json::object()}});
    for (const auto& [variant, recipe] : variants) {
      const OptionSpec* const spec = table.find(listing.name, recipe);
      if (!spec || (variant && !reads(*variant, *spec))) continue;
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
