// SPDX-License-Identifier: Apache-2.0
/// @file picture_file.h
/// Pictures as they are read: PNG, JPEG, TIFF and EXR, by their first bytes and not by their names.
#pragma once

#include "formats/image_decoder.h"

#include <filesystem>

namespace vdbtools {

/// Values as the file has them, integers scaled to 0..1: neither converted to linear light nor multiplied by alpha.
/// @throw MissingInputError  there is no such file, or it may not be opened
/// @throw DataError          it is of another format or broken, or has a value that is not finite
/// @throw MemoryError        it does not fit into the memory
/// @throw IoError            OpenImageIO cannot be loaded
DecodedImage readPicture(const std::filesystem::path& path);

}  // namespace vdbtools
