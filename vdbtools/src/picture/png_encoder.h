// SPDX-License-Identifier: Apache-2.0
/// @file png_encoder.h
/// Encodes pictures for the screen, with libpng alone: OpenImageIO takes longer to load than most pictures take to
/// make.
#pragma once

#include <cstdint>
#include <string>

namespace vdbtools {

/// The bytes of a PNG of 8 bits, which says that it is sRGB.
/// @param codes  sRGB, three for each pixel, row by row from the top left
/// @param alpha  whether there are four, the last of which is the alpha; the colours are not multiplied by it
/// @throw std::invalid_argument  it has more pixels than libpng counts, some 1.4e9
/// @throw std::bad_alloc         memory is short
std::string encodePng(int width, int height, const std::uint8_t* codes, bool alpha = false);

}  // namespace vdbtools
