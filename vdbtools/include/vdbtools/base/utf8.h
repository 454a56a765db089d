// SPDX-License-Identifier: Apache-2.0
/// @file utf8.h
/// Where text in UTF-8 begins, and where it may be cut.
#pragma once

#include <cstddef>
#include <string_view>

namespace vdbtools {

/// The text behind the mark of three bytes that some editors and exporters put at the beginning of UTF-8. It says
/// nothing, and it is no part of the first word.
std::string_view withoutByteOrderMark(std::string_view text);

/// The last place at or before @a at where a character of @a text begins, or its end: no character is cut in two there.
/// In bytes that are no UTF-8, any place will do, and this is one that is not far.
/// @param at  in bytes, at most the size of @a text
std::size_t characterAt(std::string_view text, std::size_t at);

}  // namespace vdbtools
