// SPDX-License-Identifier: Apache-2.0
/// @file utf8.h
/// Where text in UTF-8 may be cut.
#pragma once

#include <cstddef>
#include <string_view>

namespace vdbtools {

/// The last place at or before @a at where a character of @a text begins, or its end: no character is cut in two there.
/// In bytes that are no UTF-8, any place will do, and this is one that is not far.
/// @param at  in bytes, at most the size of @a text
std::size_t characterAt(std::string_view text, std::size_t at);

}  // namespace vdbtools
