// SPDX-License-Identifier: Apache-2.0
/// @file picture_file.h
/// Pictures as they are read: PNG, JPEG, TIFF, EXR and whatever else OpenImageIO knows.
#pragma once

#include "formats/image_decoder.h"

#include <filesystem>

namespace vdbtools {

/// Values as the file has them, integers scaled to 0..1: neither converted to linear light nor multiplied by alpha.
/// @throw MissingInputError  there is no such file, or it may not be opened
/// @throw DataError          it cannot be read as a picture, or has a value that is not finite
/// @throw IoError            OpenImageIO cannot be loaded
DecodedImage readPicture(const std::filesystem::path& path);

}  // namespace vdbtools
