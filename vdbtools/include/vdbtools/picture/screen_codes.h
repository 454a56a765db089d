// SPDX-License-Identifier: Apache-2.0
/// @file screen_codes.h
/// An image as a screen shows it.
#pragma once

#include "vdbtools/picture/image.h"

#include <cstdint>
#include <vector>

namespace vdbtools {

/// Red, green and blue of each pixel, row by row from the top left, 8 bits each, in sRGB: what a PNG of the image
/// holds.
std::vector<std::uint8_t> screenCodes(const Image& image);

}  // namespace vdbtools
