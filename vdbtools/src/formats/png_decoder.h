// SPDX-License-Identifier: Apache-2.0
/// @file png_decoder.h
/// Decodes PNG with libpng. OpenImageIO 2.4 leaves libpng's errors and warnings to libpng, which prints them to the
/// stderr of the process, while they belong in the error message.
#pragma once

#include "formats/image_decoder.h"

namespace vdbtools {

/// Decodes like juliavdbDecodeImage() does for other formats: colours as they are in the file, not multiplied by alpha,
/// from 0 to 1. Several threads may call it at once.
/// @param bytes   the bytes of a file
/// @param room    bytes that the picture may take
/// @param reason  set if the result is false; empty: the room is insufficient, and @a image has the size without the
///                values
/// @throw std::bad_alloc
bool decodePng(std::string_view bytes, double room, DecodedImage& image, std::string& reason);

}  // namespace vdbtools
