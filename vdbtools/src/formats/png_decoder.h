// SPDX-License-Identifier: Apache-2.0
/// @file png_decoder.h
/// Decodes PNG by libpng itself. OpenImageIO 2.4 leaves libpng's errors and warnings to libpng, which prints them on
/// the stderr of the whole process; they belong into the reason.
#pragma once

#include "formats/image_decoder.h"

namespace vdbtools {

/// As juliavdbDecodeImage() decodes other formats: colours as they are in the file, not multiplied by alpha, from 0
/// to 1. May be called in several threads.
/// @param bytes   of a file
/// @param room    bytes that the picture may take
/// @param reason  where it returns false, why; empty: there is no room, and @a image has the size without the values
/// @throw std::bad_alloc
bool decodePng(std::string_view bytes, double room, DecodedImage& image, std::string& reason);

}  // namespace vdbtools
