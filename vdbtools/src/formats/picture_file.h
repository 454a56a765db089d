// SPDX-License-Identifier: Apache-2.0
/// @file picture_file.h
/// Reads pictures in PNG, JPEG, TIFF and EXR, recognised by their first bytes and not by their names.
#pragma once

#include "formats/image_decoder.h"

#include <filesystem>

namespace vdbtools {

/// Returns the values of the file, with integers scaled to 0..1, neither converted to linear light nor multiplied by
/// alpha.
/// @throw MissingInputError  the file does not exist, or may not be opened
/// @throw DataError          it has another format, is broken, or has a value that is not finite
/// @throw MemoryError        the memory is insufficient
/// @throw IoError            OpenImageIO cannot be loaded
DecodedImage readPicture(const std::filesystem::path& path);

}  // namespace vdbtools
