// SPDX-License-Identifier: Apache-2.0
/// @file option_rows.h
/// Options whose values are members of a struct. One row has everything about an option: its name and help, the member
/// that takes its value, and the values that it accepts. Its default is the value of the member in a
/// default-constructed struct.
///
///     const OptionRows<SurfaceOptions>& surfaceRows() {
///       static const OptionRows<SurfaceOptions> rows{
///           {{.name = "tolerance", .argument = "T", .help = "..."},
///            number(&SurfaceOptions::tolerance, within(0, 0.5))},
///           {{.name = "cap", .help = "..."}, flag(&SurfaceOptions::cap)}};
///       return rows;
///     }
///
/// A pointer names the member, or, for members of members, a generic function that returns a reference to it. An option
/// whose member is a std::optional has no default. Rules between several options are functions, called after read().
#pragma once

#include "vdbtools/recipe/option_table.h"
#include "vdbtools/recipe/recipe_reader.h"

#include <cstddef>
#include <functional>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbtools {

template <class Options>
class OptionRows {
 public:
  struct Row {
    /// @param value  flag(), number() and so on
    template <class Value>
    Row(OptionSpec option, Value value) : spec(std::move(option)) {
      spec.type = value.type;
      if (spec.argument.empty() && value.namesWords) spec.argument = joined(spec.type.words, "|");
      if (!spec.defaultValue && !spec.defaultFor) spec.defaultValue = value.text(Options{});
      read = [name = spec.name, value = std::move(value)](const RecipeReader& reader, Options& options) {
        if (reader.has(name)) value.read(reader, name, options);
      };
    }

    OptionSpec spec;
    std::function<void(const RecipeReader&, Options&)> read;
  };

  OptionRows(std::initializer_list<Row> rows) : mRows(rows) {}

  std::vector<OptionSpec> specs() const {
    std::vector<OptionSpec> specs;
    for (const Row& row : mRows) specs.push_back(row.spec);
    return specs;
  }

  /// Reads every option that is given or has a default into its member.
  /// @throw std::invalid_argument  naming the option, its value, and the values that it accepts
  void read(const RecipeReader& reader, Options& options) const {
    for (const Row& row : mRows) row.read(reader, options);
  }
  /// The same into new options.
  Options read(const RecipeReader& reader) const {
    Options options;
    read(reader, options);
    return options;
  }

 private:
  std::vector<Row> mRows;
};

/// How the text of an option becomes the value of a member, and back.
/// @tparam Text  std::optional<std::string>(const Options&): the default, if there is one
/// @tparam Read  void(const RecipeReader&, const std::string& name, Options&)
template <class Text, class Read>
struct RowValue {
  OptionType type;
  Text text;
  Read read;
  bool namesWords = false;  ///< whether the help shows the words of the type as the option's value
};
template <class Text, class Read>
RowValue(OptionType, Text, Read, bool = false) -> RowValue<Text, Read>;

namespace option_rows {

/// @param text  of a value, without the std::optional about it
template <class Member, class TextOf>
auto defaultOf(Member member, TextOf textOf) {
  return [member, textOf](const auto& options) -> std::optional<std::string> {
    const auto& value = std::invoke(member, options);
    if constexpr (requires { value.has_value(); })
      return value ? std::optional<std::string>(textOf(*value)) : std::nullopt;
    else
      return textOf(value);
  };
}

/// Of a value that has none.
inline constexpr auto noDefault = [](const auto&) { return std::optional<std::string>(); };

}  // namespace option_rows

// The bounds of numbers.
inline OptionType within(double low, double high) {
  return {.kind = OptionType::Kind::Number, .low = low, .high = high};
}
inline OptionType atLeast(double low) { return within(low, std::numeric_limits<double>::infinity()); }
inline OptionType above(double low, double high = std::numeric_limits<double>::infinity()) {
  return {.kind = OptionType::Kind::Number, .low = low, .high = high, .excludesLow = true};
}
/// Above one bound and below the other.
inline OptionType between(double low, double high) {
  return {.kind = OptionType::Kind::Number, .low = low, .high = high, .excludesLow = true, .excludesHigh = true};
}

/// A number in a range. @throw std::invalid_argument
double readNumber(const RecipeReader& reader, const std::string& name, const OptionType& range);
/// The places in @a words of those that an option lists. @throw std::invalid_argument  another word, or one twice
std::vector<std::size_t> listedWords(const RecipeReader& reader, const std::string& name,
                                     const std::vector<std::string>& words);

/// The word for a value; "" if there is none.
template <class Value>
std::string wordFor(const Value& value, const Choices<Value>& choices) {
  for (const auto& [word, meant] : choices)
    if (meant == value) return word;
  return {};
}

template <class Member>
auto flag(Member member) {
  return RowValue{OptionType{.kind = OptionType::Kind::Flag}, option_rows::noDefault,
                  [member](const RecipeReader& reader, const std::string& name, auto& options) {
                    std::invoke(member, options) = reader.flag(name);
                  }};
}

template <class Member>
auto number(Member member, OptionType range = {.kind = OptionType::Kind::Number}) {
  return RowValue{range, option_rows::defaultOf(member, [](double value) { return numberText(value); }),
                  [member, range](const RecipeReader& reader, const std::string& name, auto& options) {
                    std::invoke(member, options) = readNumber(reader, name, range);
                  }};
}

/// A whole number; both bounds are allowed.
template <class Member, class Integer>
auto whole(Member member, Integer low, Integer high) {
  return RowValue{
      OptionType{.kind = OptionType::Kind::Whole, .low = static_cast<double>(low), .high = static_cast<double>(high)},
      option_rows::defaultOf(member, [](auto value) { return std::to_string(value); }),
      [member, low, high](const RecipeReader& reader, const std::string& name, auto& options) {
        std::invoke(member, options) = reader.integer<Integer>(name, low, high);
      }};
}

/// One of some words.
template <class Value, class Member>
auto choice(Member member, Choices<Value> choices) {
  return RowValue{OptionType{.kind = OptionType::Kind::Choice, .words = wordsOf(choices)},
                  option_rows::defaultOf(member, [choices](const Value& value) { return wordFor(value, choices); }),
                  [member, choices](const RecipeReader& reader, const std::string& name, auto& options) {
                    std::invoke(member, options) = chosen(name, reader.text(name), choices);
                  },
                  true};
}

/// A list of some words with commas between them, each at most once.
template <class Value, class Member>
auto list(Member member, Choices<Value> choices) {
  return RowValue{OptionType{.kind = OptionType::Kind::List, .words = wordsOf(choices)},
                  option_rows::defaultOf(member,
                                         [choices](const std::vector<Value>& values) {
                                           return joined(values, ",",
                                                         [&](const Value& value) { return wordFor(value, choices); });
                                         }),
                  [member, choices](const RecipeReader& reader, const std::string& name, auto& options) {
                    std::vector<Value>& values = std::invoke(member, options);
                    values.clear();
                    for (const std::size_t place : listedWords(reader, name, wordsOf(choices)))
                      values.push_back(choices[place].second);
                  }};
}

/// Three numbers.
template <class Member>
auto vector(Member member) {
  return RowValue{OptionType{.kind = OptionType::Kind::Vector},
                  option_rows::defaultOf(member,
                                         [](const auto& value) {
                                           return numbersText({value[0], value[1], value[2]});
                                         }),
                  [member](const RecipeReader& reader, const std::string& name, auto& options) {
                    const openvdb::Vec3d value = reader.vector(name);
                    auto& to = std::invoke(member, options);
                    if constexpr (requires { to.has_value(); })
                      to.emplace(value);
                    else
                      to = {value[0], value[1], value[2]};
                  }};
}

/// A text as it stands.
template <class Member>
auto text(Member member) {
  return RowValue{OptionType{}, option_rows::defaultOf(member, [](const std::string& value) { return value; }),
                  [member](const RecipeReader& reader, const std::string& name, auto& options) {
                    std::invoke(member, options) = reader.text(name);
                  }};
}

/// The same value for an option that is not given by default, whatever its member is then.
template <class Value>
auto withoutDefault(Value value) {
  return RowValue{value.type, option_rows::noDefault, value.read, value.namesWords};
}

/// A value that @a parse reads by itself. It gets the reader, the option's name and the struct.
template <class Parse>
auto parsedBy(Parse parse, OptionType type = {}) {
  return RowValue{
      type, option_rows::noDefault,
      [parse](const RecipeReader& reader, const std::string& name, auto& options) { parse(reader, name, options); }};
}

/// The value that @a parse makes of the reader and the option's name.
template <class Member, class Parse>
auto parsed(Member member, Parse parse, OptionType type = {}) {
  return parsedBy([member, parse](const RecipeReader& reader, const std::string& name,
                                  auto& options) { std::invoke(member, options) = parse(reader, name); },
                  std::move(type));
}

/// An option that the room reads by a rule between several options. @param words  accepted besides numbers
inline auto readByRule(OptionType type = {}, std::vector<std::string> words = {}) {
  type.words = std::move(words);
  return parsedBy([](const RecipeReader&, const std::string&, auto&) {}, std::move(type));
}

}  // namespace vdbtools
