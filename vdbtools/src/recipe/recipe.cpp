// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/recipe/recipe.h"

#include "vdbtools/base/text.h"
#include "vdbtools/recipe/option_value.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string_view>

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

std::vector<ListedOption> listedOptions(std::string_view text) {
  std::vector<ListedOption> options;
  text = withoutByteOrderMark(text);
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = trimmed(text.substr(0, std::min(end, text.substr(0, end).find('#'))));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty()) continue;
    const std::size_t equals = line.find('=');
    const std::string_view name = equals == line.npos ? std::string_view() : trimmed(line.substr(0, equals));
    options.push_back({number, std::string(name), name.empty() ? line : trimmed(line.substr(equals + 1))});
  }
  return options;
}

namespace {

constexpr const char* kOption = "vary";
constexpr std::size_t kPlaces = 9;  ///< the most digits on either side of the point
constexpr std::int64_t kOne = 1'000'000'000;

bool areDigits(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

/// A decimal such as "-1.25", exactly, in units of 10^-9.
std::optional<std::int64_t> decimalFromText(std::string_view text) {
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  const std::size_t point = std::min(text.find('.'), text.size());
  const std::string_view whole = text.substr(0, point);
  std::string part(point < text.size() ? text.substr(point + 1) : std::string_view());
  if (whole.empty() && part.empty()) return std::nullopt;
  if (!areDigits(whole) || !areDigits(part) || whole.size() > kPlaces || part.size() > kPlaces) return std::nullopt;
  part.resize(kPlaces, '0');
  const std::int64_t value = wholeFromText<std::int64_t>(whole.empty() ? "0" : whole).value() * kOne +
                             wholeFromText<std::int64_t>(part).value();
  return negative ? -value : value;
}

/// The shortest decimal.
std::string textOf(std::int64_t decimal) {
  const std::int64_t size = decimal < 0 ? -decimal : decimal;
  std::string text = (decimal < 0 ? "-" : "") + std::to_string(size / kOne);
  if (size % kOne == 0) return text;
  const std::string part = std::to_string(size % kOne);
  text += '.' + std::string(kPlaces - part.size(), '0') + part;
  return text.substr(0, text.find_last_not_of('0') + 1);
}

[[noreturn]] void refuseCount(const std::string& text, std::size_t most) {
  refuse(kOption, text, "a list of at most " + std::to_string(most) + " values");
}

bool isRange(const std::vector<std::string>& parts) {
  return parts.size() == 3 && std::all_of(parts.begin(), parts.end(),
                                          [](const std::string& part) { return numberFromText(part).has_value(); });
}

void addRange(const std::string& text, const std::vector<std::string>& parts, std::size_t most,
              std::vector<std::string>& values) {
  const auto number = [&](std::size_t i) {
    const std::optional<std::int64_t> value = decimalFromText(parts[i]);
    if (!value)
      refuse(kOption, text, "a range of decimals such as -1.25, with at most 9 digits before the point and behind it");
    return *value;
  };
  const std::int64_t first = number(0), last = number(1), step = number(2);
  if (step == 0 || (last - first) / step < 0 || (last != first && (last < first) != (step < 0)))
    refuse(kOption, text, "A:B:STEP with a STEP that leads from A towards B");
  const auto count = static_cast<std::uint64_t>((last - first) / step) + 1;
  if (count > most) refuseCount(text, most);
  for (std::uint64_t i = 0; i < count; ++i) values.push_back(textOf(first + static_cast<std::int64_t>(i) * step));
}

}  // namespace

VariedOption parseVaried(const std::string& text, const OptionTable& table, std::size_t most) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    refuse(kOption, text, "NAME=VALUES, such as alpha=10,20,40 or alpha=10:40:10");
  VariedOption option{currentName(text.substr(0, equals)), {}};
  if (!table.knows(option.name))
    refuse(kOption, text,
           "an option of a fractal or of its picture; there is none with the name '" + text.substr(0, equals) + "'");
  const std::string list = text.substr(equals + 1);
  const char separator = list.find(';') == std::string::npos ? ',' : ';';
  std::vector<std::string> parts = split(list, separator);
  if (separator == ';' && parts.back().empty()) parts.pop_back();
  for (const std::string& part : parts) {
    if (part.empty()) refuse(kOption, text, "NAME=VALUES, with at least one value and no empty one");
    if (const std::vector<std::string> ends = split(part, ':'); isRange(ends))
      addRange(text, ends, most, option.values);
    else
      option.values.push_back(part);
    if (option.values.size() > most) refuseCount(text, most);
  }
  if (option.values.empty()) refuse(kOption, text, "NAME=VALUES, with at least one value and no empty one");
  return option;
}

}  // namespace vdbtools
