// SPDX-License-Identifier: Apache-2.0
/// @file pixel_font.h
/// Lettering for pictures: glyphs of 5 by 9 pixels, the last two rows for what hangs below the line.
#pragma once

namespace vdbtools {

inline constexpr int kGlyphWidth = 5, kGlyphHeight = 9, kGlyphAscent = 7;

/// Whether column x, row y of a character is ink. One that the font lacks is a box.
bool glyphInk(char character, int x, int y);

}  // namespace vdbtools
