// SPDX-License-Identifier: Apache-2.0
/// @file exr_header.h
/// Checks what OpenEXR does not.
#pragma once

#include <string_view>

namespace vdbtools {

/// The C++ reader of OpenEXR 3.1 allocates the size that a header states for an attribute, up to 2 GB. It reads some
/// types with their own sizes instead of the stated ones, so that everything after them is misread.
/// @param bytes  a file that begins like an EXR
/// @return whether all attributes have the sizes of their types and lie within the file
bool isExrHeaderSound(std::string_view bytes);

}  // namespace vdbtools
