// SPDX-License-Identifier: Apache-2.0
/// @file exr_header.h
/// A check of what OpenEXR takes on trust.
#pragma once

#include <string_view>

namespace vdbtools {

/// The C++ reader of OpenEXR 3.1 allocates what an attribute of a header says it has, up to 2 GB, and reads some kinds
/// by their own sizes, whatever the file says these are, so that what follows is read out of step.
/// @param bytes  of a file that begins as an EXR
/// @return  whether all attributes have the sizes of their kinds and lie within the file
bool isExrHeaderSound(std::string_view bytes);

}  // namespace vdbtools
