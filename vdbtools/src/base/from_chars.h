// SPDX-License-Identifier: Apache-2.0
/// @file from_chars.h
/// std::from_chars() for floats and doubles, also with libc++ before its version 20, which lacks it.
#pragma once

#include <charconv>
#include <version>

#ifndef __cpp_lib_to_chars
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <string>
#include <system_error>
#include <type_traits>
#endif

namespace vdbtools {

template <class Real>
std::from_chars_result fromChars(const char* first, const char* last, Real& value) {
#ifdef __cpp_lib_to_chars
  return std::from_chars(first, last, value);
#else
  // The C library's functions are exact, too. They also take blanks, plus signs and hexadecimal digits.
  std::string text(first, last);
  if (const std::size_t x = text.find_first_of("xX"); x != text.npos) text.resize(x);
  const std::size_t sign = text.starts_with('-') ? 1 : 0;
  if (sign == text.size() || text[sign] == '+' || text[sign] == '-' ||
      std::isspace(static_cast<unsigned char>(text[sign])))
    return {first, std::errc::invalid_argument};
  char* end = nullptr;
  errno = 0;
  Real read;
  if constexpr (std::is_same_v<Real, float>)
    read = std::strtof(text.c_str(), &end);
  else
    read = std::strtod(text.c_str(), &end);
  if (end == text.c_str()) return {first, std::errc::invalid_argument};
  const char* const rest = first + (end - text.c_str());
  if (errno == ERANGE && (read == 0 || std::isinf(read))) return {rest, std::errc::result_out_of_range};
  value = read;
  return {rest, std::errc()};
#endif
}

}  // namespace vdbtools
