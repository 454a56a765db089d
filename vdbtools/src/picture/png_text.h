// SPDX-License-Identifier: Apache-2.0
/// @file png_text.h
/// Texts within PNG files (their chunks tEXt), which readers of pictures skip.
#pragma once

#include <string>
#include <string_view>

namespace vdbtools {

/// The file with a text behind its header.
/// @param png  as encodePng() makes it
/// @param key  1 to 79 letters of ASCII
/// @throw std::invalid_argument  the bytes do not begin as a PNG does
std::string withPngText(std::string_view png, std::string_view key, std::string_view text);

/// The first text under that key; empty if there is none, or if the file is broken before it.
std::string pngText(std::string_view png, std::string_view key);

}  // namespace vdbtools
