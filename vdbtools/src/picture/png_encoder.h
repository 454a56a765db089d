// SPDX-License-Identifier: Apache-2.0
/// @file png_encoder.h
/// Encodes pictures for the screen with libpng alone, because OpenImageIO takes longer to load than most pictures take
/// to make.
#pragma once

#include <cstdint>
#include <string>

namespace vdbtools {

/// Returns the bytes of an 8-bit PNG that is marked as sRGB.
/// @param codes  sRGB, three for each pixel, row by row from the top left
/// @param alpha  whether each pixel has a fourth code, its alpha; colours are not premultiplied
/// @throw std::invalid_argument  more pixels than libpng can count, about 1.4e9
/// @throw std::bad_alloc         memory is short
std::string encodePng(int width, int height, const std::uint8_t* codes, bool alpha = false);

}  // namespace vdbtools
