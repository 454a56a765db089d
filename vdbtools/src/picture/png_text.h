// SPDX-License-Identifier: Apache-2.0
/// @file png_text.h
/// Texts in PNG files (tEXt chunks), which other readers of pictures skip.
#pragma once

#include <string>
#include <string_view>

namespace vdbtools {

/// Returns the file with a text added after its header.
/// @param png  as returned by encodePng()
/// @param key  1 to 79 ASCII letters
/// @throw std::invalid_argument  the bytes do not begin like a PNG
std::string withPngText(std::string_view png, std::string_view key, std::string_view text);

/// The first text with that key; empty if there is none, or if the file is broken before it.
std::string pngText(std::string_view png, std::string_view key);

}  // namespace vdbtools
