// SPDX-License-Identifier: Apache-2.0
/// @file json_text.h
/// JSON that nobody vouches for, read with nlohmann-json. It parses arrays and objects within each other to any depth,
/// but copies, compares and writes them by recursion, so that a file of a hundred thousand brackets would overflow the
/// stack; and it turns 1e300 into an int without a check.
#pragma once

#include <nlohmann/json.hpp>

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>

namespace vdbtools {

/// How deep the values of a file may lie within each other. Ours have six levels, and a glTF hardly more.
inline constexpr std::size_t kMostJsonDepth = 100;

/// Whether a JSON text goes deeper. What it says of a text that is not JSON means nothing.
inline bool nestsTooDeep(std::string_view text) {
  std::size_t depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      if (c == '\\') ++i;
      if (c == '"') quoted = false;
    } else if (c == '"') {
      quoted = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kMostJsonDepth) return true;
    } else if ((c == ']' || c == '}') && depth > 0) {
      --depth;
    }
  }
  return false;
}

/// A discarded value where the text is not JSON, or goes too deep.
template <class Json>
Json parsedJson(std::string_view text) {
  if (nestsTooDeep(text)) return Json(Json::value_t::discarded);
  return Json::parse(text, nullptr, /*allow_exceptions=*/false);
}

/// @throw nlohmann::json::exception  the value is not a whole number, or not one that an Integer can be
template <class Integer, class Json>
Integer wholeOf(const Json& value) {
  // The larger half of the unsigned numbers shows as negative ones here, and means nothing in our files.
  const auto whole = value.template get_ref<const std::int64_t&>();
  if (!std::in_range<Integer>(whole) || (value.is_number_unsigned() && whole < 0))
    throw Json::out_of_range::create(406, "a whole number is too large", &value);
  return static_cast<Integer>(whole);
}

}  // namespace vdbtools
