// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/recipe/option_table.h"

#include "vdbtools/base/text.h"
#include "vdbtools/recipe/option_value.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

const OptionSpec* findIn(const std::vector<OptionSpec>& options, const std::string& name) {
  const auto found = std::find_if(options.begin(), options.end(), [&](const auto& spec) { return spec.name == name; });
  return found == options.end() ? nullptr : &*found;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::vector<std::string> namesOf(const std::vector<OptionVariant>& variants) {
  std::vector<std::string> names;
  for (const OptionVariant& each : variants) names.push_back(each.name);
  return names;
}

std::string defaultText(const OptionSpec& spec) {
  return spec.defaultNote.empty() ? spec.defaultValue.value_or("") : spec.defaultNote;
}

/// The variants that say the same of an option.
struct Saying {
  std::string text;
  std::vector<std::string> variants;
};

void say(std::vector<Saying>& sayings, const std::string& text, const std::string& variant) {
  for (Saying& saying : sayings)
    if (saying.text == text) return saying.variants.push_back(variant);
  sayings.push_back({text, {variant}});
}

/// Everything that is said, with the variants' names in front where not all say it.
/// @param usual  a variant that needs no naming
std::string merged(const std::vector<Saying>& sayings, const std::string& usual, const char* separator) {
  std::string text;
  for (const Saying& saying : sayings) {
    if (saying.text.empty()) continue;
    if (!text.empty()) text += separator;
    if (!contains(saying.variants, usual)) text += joined(saying.variants) + ": ";
    text += saying.text;
  }
  return text;
}

std::string withDefault(const std::string& help, const std::string& text) {
  return text.empty() ? help : help + " (default " + text + ")";
}

std::optional<std::string> defaultOf(const OptionSpec& spec, const Recipe& recipe) {
  if (recipe.contains(spec.alternative)) return std::nullopt;
  return spec.defaultFor ? spec.defaultFor(recipe) : spec.defaultValue;
}

}  // namespace

bool OptionRun::makesAny(std::initializer_list<Product> products) const {
  if (makes.contains(Product::Recipe)) return true;
  return std::any_of(products.begin(), products.end(), [&](Product product) { return makes.contains(product); });
}

std::string OptionRun::text(const std::string& option) const {
  const auto found = recipe.find(option);
  return found == recipe.end() ? std::string() : found->second;
}

std::string OptionType::bounds() const {
  const std::string least = numberText(low), most = numberText(high);
  if (std::isinf(high)) return excludesLow ? "above " + least : least + " or more";
  if (!excludesLow && !excludesHigh) return "a number from " + least + " to " + most;
  return (excludesLow ? "above " : "at least ") + least + " and " + (excludesHigh ? "below " : "at most ") + most;
}

IdleRule idleWithout(std::set<Product> makes, std::string products) {
  return [makes = std::move(makes), products = std::move(products)](const OptionRun& run) -> std::string {
    for (const Product product : makes)
      if (run.makesAny({product})) return {};
    return "it is for " + products + ", and this run makes none; leave it out";
  };
}

IdleRule idleWithoutFlag(std::string flag) {
  return [flag = std::move(flag)](const OptionRun& run) -> std::string {
    const std::string value = run.text(flag);
    return !value.empty() && value != "false" ? "" : "it goes with --" + flag + "; give that too, or leave it out";
  };
}

IdleRule idleByAny(std::vector<IdleRule> rules) {
  return [rules = std::move(rules)](const OptionRun& run) {
    std::string why;
    for (const IdleRule& rule : rules)
      if (why.empty()) why = rule(run);
    return why;
  };
}

OptionTable::OptionTable(std::vector<OptionSpec> options, std::string selector, std::vector<OptionVariant> variants)
    : mCommon(std::move(options)), mSelector(std::move(selector)), mVariants(std::move(variants)) {
  const OptionSpec* spec = findIn(mCommon, mSelector);
  if (!spec || !variant(spec->defaultValue.value_or("")))
    throw std::invalid_argument("the option '" + mSelector + "' selects nothing by default");
  std::set<std::string> names;
  for (const OptionVariant& each : mVariants)
    if (!names.insert(each.name).second)
      throw std::invalid_argument("two variants of '" + mSelector + "' are called '" + each.name + "'");
}

const OptionVariant* OptionTable::variant(const std::string& name) const {
  const auto found =
      std::find_if(mVariants.begin(), mVariants.end(), [&](const auto& each) { return each.name == name; });
  return found == mVariants.end() ? nullptr : &*found;
}

std::string OptionTable::selected(const Recipe& recipe) const {
  if (mSelector.empty()) return {};
  const auto given = recipe.find(mSelector);
  return given != recipe.end() ? given->second : findIn(mCommon, mSelector)->defaultValue.value();
}

const OptionVariant* OptionTable::variantOf(const Recipe& recipe) const { return variant(selected(recipe)); }

std::string OptionTable::variantList() const { return joined(namesOf(mVariants)); }

const OptionSpec* OptionTable::find(const std::string& name, const Recipe& recipe) const {
  const OptionVariant* chosen = variantOf(recipe);
  if (chosen) {
    if (const OptionSpec* own = findIn(chosen->options, name)) return own;
    if (contains(chosen->excludes, name)) return nullptr;
  }
  if (const OptionSpec* common = findIn(mCommon, name)) return common;
  for (const OptionVariant& each : mVariants)
    if (const OptionSpec* spec = findIn(each.options, name); spec && spec->kept) return spec;
  return nullptr;
}

bool OptionTable::knows(const std::string& name) const { return contains(names(), name); }

std::vector<std::string> OptionTable::names() const {
  std::vector<std::string> names;
  const auto add = [&](const OptionSpec& spec) {
    if (!contains(names, spec.name)) names.push_back(spec.name);
  };
  for (const OptionSpec& spec : mCommon) {
    add(spec);
    if (spec.name != mSelector) continue;
    for (const OptionVariant& each : mVariants)
      for (const OptionSpec& own : each.options) add(own);
  }
  return names;
}

std::vector<const OptionSpec*> OptionTable::optionsOf(const Recipe& recipe) const {
  std::vector<const OptionSpec*> options;
  for (const std::string& name : names())
    if (const OptionSpec* spec = find(name, recipe)) options.push_back(spec);
  return options;
}

std::vector<OptionListing> OptionTable::listing() const {
  std::vector<OptionListing> result;
  for (const std::string& name : names()) {
    if (const OptionSpec* common = findIn(mCommon, name)) {
      result.push_back({name, common->argument, withDefault(common->help, defaultText(*common))});
      continue;
    }
    const std::string usual = findIn(mCommon, mSelector)->defaultValue.value();
    std::vector<Saying> helps, defaults, both;
    OptionListing listing{name, {}, {}};
    for (const OptionVariant& each : mVariants)
      if (const OptionSpec* spec = findIn(each.options, name)) {
        listing.argument = std::max(listing.argument, spec->argument,
                                    [](const auto& a, const auto& b) { return a.size() < b.size(); });
        say(helps, spec->help, each.name);
        say(defaults, defaultText(*spec), each.name);
        say(both, withDefault(spec->help, defaultText(*spec)), each.name);
      }
    // One help with several defaults is said once.
    if (helps.size() == 1 && defaults.size() > 1)
      listing.help = merged(helps, usual, "") + " (default " + merged(defaults, usual, "; ") + ")";
    else
      listing.help = merged(both, usual, "; ");
    result.push_back(std::move(listing));
  }
  return result;
}

std::vector<std::string> OptionTable::hashNames() const {
  std::vector<std::string> hashes;
  const auto add = [&](const std::vector<OptionSpec>& options) {
    for (const OptionSpec& spec : options)
      if (!spec.hash.empty() && !contains(hashes, spec.hash)) hashes.push_back(spec.hash);
  };
  add(mCommon);
  for (const OptionVariant& each : mVariants) add(each.options);
  return hashes;
}

void OptionTable::requireFits(const Recipe& recipe) const {
  const std::string name = selected(recipe);
  if (!mSelector.empty() && !variant(name))
    throw std::invalid_argument("--" + mSelector + " is '" + name + "'; it must be one of " + variantList() +
                                didYouMean(name, namesOf(mVariants)));
  const std::vector<std::string> hashes = hashNames();
  for (const auto& [option, value] : recipe) {
    if (contains(hashes, option)) continue;
    if (const OptionSpec* spec = find(option, recipe)) {
      const OptionVariant* chosen = variantOf(recipe);
      if (spec->check && chosen && !findIn(chosen->options, option)) spec->check(value);
      continue;
    }
    if (!knows(option))
      throw std::invalid_argument("--" + option + " is not an option of this command; see --help" +
                                  didYouMean(option, names(), "--"));
    const std::string chosen = "--" + mSelector + " " + name;
    if (option == "input") throw std::invalid_argument(chosen + " has no target; leave '" + value + "' out");
    std::string instead;
    for (const OptionVariant& each : mVariants)
      if (const OptionSpec* other = findIn(each.options, option); other && find(other->alternative, recipe))
        instead = ", or give --" + other->alternative;
    throw std::invalid_argument("--" + option + " does not apply to " + chosen + "; leave it out" + instead);
  }
}

std::string OptionTable::idle(const std::string& option, const OptionRun& run) const {
  const OptionVariant* chosen = variantOf(run.recipe);
  if (chosen && !findIn(mCommon, option) && !findIn(chosen->options, option)) {
    std::vector<std::string> owners;
    for (const OptionVariant& each : mVariants)
      if (findIn(each.options, option)) owners.push_back(each.name);
    return "it is for --" + mSelector + ' ' + joined(owners) + ", and --" + mSelector + " is " + chosen->name +
           "; leave it out";
  }
  const OptionSpec* spec = find(option, run.recipe);
  return spec && spec->idle ? spec->idle(run) : std::string();
}

bool RequiredEffects::add(const OptionRun& run) {
  mFirst.clear();
  for (auto name = mIdle.begin(); name != mIdle.end();) {
    const std::string why = mTable.idle(*name, run);
    if (!why.empty() && mFirst.empty()) {
      mFirst = *name;
      mWhy = why;
    }
    name = why.empty() ? mIdle.erase(name) : std::next(name);
  }
  return mIdle.empty();
}

void RequiredEffects::require() const {
  if (!mFirst.empty()) throw std::invalid_argument("--" + mFirst + " has no effect: " + mWhy);
}

Recipe completeRecipe(Recipe recipe, const OptionTable& table) {
  for (const OptionSpec* spec : table.optionsOf(recipe)) {
    if (recipe.contains(spec->name)) continue;
    if (const std::optional<std::string> value = defaultOf(*spec, recipe)) recipe.emplace(spec->name, *value);
  }
  return recipe;
}

std::vector<std::string> displacedOptions(const Recipe& base, const std::string& option, const std::string& value,
                                          const OptionTable& table) {
  const auto before = base.find(option);
  if (before != base.end() && before->second == value) return {};
  Recipe after = base;
  after[option] = value;
  std::vector<std::string> displaced;
  if (const OptionSpec* spec = table.find(option, after)) {
    if (!spec->alternative.empty()) displaced.push_back(spec->alternative);
    displaced.insert(displaced.end(), spec->displaces.begin(), spec->displaces.end());
    if (before != base.end()) displaced.insert(displaced.end(), spec->qualifies.begin(), spec->qualifies.end());
  }
  if (option == table.selector() && before != base.end())
    for (const std::string& name : table.names()) {
      const OptionSpec* spec = table.find(name, after);
      if (!spec || spec->followsSelector) displaced.push_back(name);
    }
  return displaced;
}

Recipe overridden(Recipe base, const Recipe& given, const OptionTable& table) {
  const Recipe before = base;
  const auto drop = [&](const std::string& name) {
    if (const OptionSpec* spec = table.find(name, before); spec && !spec->hash.empty()) base.erase(spec->hash);
    base.erase(name);
  };
  // The selector first: what the others mean is known then.
  if (const auto selector = given.find(table.selector()); selector != given.end()) {
    for (const std::string& other : displacedOptions(before, selector->first, selector->second, table)) drop(other);
    base[selector->first] = selector->second;
  }
  const Recipe chosen = base;
  for (const auto& [name, value] : given) {
    if (name == table.selector()) continue;
    for (const std::string& other : displacedOptions(chosen, name, value, table)) drop(other);
    if (const OptionSpec* spec = table.find(name, chosen); spec && !spec->hash.empty()) base.erase(spec->hash);
  }
  for (const auto& [name, value] : given) base[name] = value;
  return base;
}

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
