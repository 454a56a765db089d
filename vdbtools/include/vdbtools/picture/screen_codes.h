// SPDX-License-Identifier: Apache-2.0
/// @file screen_codes.h
/// Converts an image to screen codes.
#pragma once

#include "vdbtools/picture/image.h"

#include <cstdint>
#include <vector>

namespace vdbtools {

/// Returns red, green and blue of each pixel, row by row from the top left, as 8-bit sRGB codes: the contents of a PNG
/// of the image.
std::vector<std::uint8_t> screenCodes(const Image& image);

}  // namespace vdbtools
