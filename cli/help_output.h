// SPDX-License-Identifier: Apache-2.0
/// @file help_output.h
/// Help on the standard output.
#pragma once

#include <string_view>

namespace cli {

/// Writes all of @a text, or as much of it as somebody reads: 'juliavdb fractal --help | head' is no error, while data
/// that do not arrive are.
/// @throw vdbtools::IoError  it cannot be written for another reason
void writeHelp(std::string_view text);

}  // namespace cli
