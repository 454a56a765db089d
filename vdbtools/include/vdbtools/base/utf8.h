// SPDX-License-Identifier: Apache-2.0
/// @file utf8.h
/// Finds where UTF-8 text begins and where it may be cut.
#pragma once

#include <cstddef>
#include <string_view>

namespace vdbtools {

/// Returns the text after the byte order mark, if there is one. Some editors and exporters put these three bytes at the
/// beginning of UTF-8; they carry no meaning and are not part of the first word.
std::string_view withoutByteOrderMark(std::string_view text);

/// Returns the last position at or before @a at where a character of @a text begins or the text ends, so that cutting
/// there splits no character. In bytes that are not UTF-8, any position is acceptable, and the result is close to @a
/// at.
/// @param at  in bytes, at most the size of @a text
std::size_t characterAt(std::string_view text, std::size_t at);

}  // namespace vdbtools
