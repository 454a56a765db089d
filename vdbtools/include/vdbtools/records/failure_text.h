// SPDX-License-Identifier: Apache-2.0
/// @file failure_text.h
/// The messages of errors for front ends with options: the text of the exception, and the option that would help. The
/// program and the Python module use the same messages.
#pragma once

#include "vdbtools/base/errors.h"
#include "vdbtools/base/memory.h"

#include <string>

namespace vdbtools {

/// The text of the exception, followed by the options that do what its Remedy asks for.
std::string failureText(const DataError& error);

/// The text of the exception, followed by the options that make the work smaller.
std::string failureText(const MemoryError& error);

/// The message for any other std::bad_alloc.
inline constexpr const char* kOutOfMemory = "out of memory; use larger voxels, a lower --sdf-resolution, or a --box";

}  // namespace vdbtools
