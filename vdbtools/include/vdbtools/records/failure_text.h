// SPDX-License-Identifier: Apache-2.0
/// @file failure_text.h
/// What a failure is called where there are options: the exception's text, and the option that would help. The program
/// and the Python module say the same.
#pragma once

#include "vdbtools/base/errors.h"
#include "vdbtools/base/memory.h"

#include <string>

namespace vdbtools {

/// The text of the exception, and behind it the options that do what its Remedy asks for.
std::string failureText(const DataError& error);

/// The text of the exception, and the options that make the work smaller.
std::string failureText(const MemoryError& error);

/// Of any other std::bad_alloc.
inline constexpr const char* kOutOfMemory = "out of memory; use larger voxels, a lower --sdf-resolution, or a --box";

}  // namespace vdbtools
