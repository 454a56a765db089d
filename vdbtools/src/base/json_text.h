// SPDX-License-Identifier: Apache-2.0
/// @file json_text.h
/// Reads untrusted JSON with nlohmann-json. The library parses nested arrays and objects to any depth, but it copies,
/// compares and writes them recursively, so a file of a hundred thousand brackets would overflow the stack. It also
/// converts 1e300 to an int without a check.
#pragma once

#include <nlohmann/json.hpp>

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>

namespace vdbtools {

/// The maximum nesting depth of a file. The project's own files have six levels, and a glTF hardly more.
inline constexpr std::size_t kMostJsonDepth = 100;

/// Whether a JSON text is nested more deeply. For a text that is not JSON the result is meaningless.
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

/// Returns a discarded value if the text is not JSON, or is nested too deeply.
template <class Json>
Json parsedJson(std::string_view text) {
  if (nestsTooDeep(text)) return Json(Json::value_t::discarded);
  return Json::parse(text, nullptr, /*allow_exceptions=*/false);
}

/// @throw nlohmann::json::exception  the value is not an integer, or does not fit Integer
template <class Integer, class Json>
Integer wholeOf(const Json& value) {
  // The upper half of the unsigned numbers appears as negative numbers here, and never occurs in valid files.
  const auto whole = value.template get_ref<const std::int64_t&>();
  if (!std::in_range<Integer>(whole) || (value.is_number_unsigned() && whole < 0))
    throw Json::out_of_range::create(406, "a whole number is too large", &value);
  return static_cast<Integer>(whole);
}

}  // namespace vdbtools
