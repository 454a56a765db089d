// SPDX-License-Identifier: Apache-2.0
/// @file help_output.h
/// Help on the standard output.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace cli {

/// How long lines of help may be: as wide as the terminal, between 60 and 120 letters; 110 where there is none.
unsigned helpWidth();

/// Text with its lines broken anew. An empty line ends a paragraph. A line that begins with two spaces is a row of a
/// table, "  NAME   meaning"; lines that begin with more of them continue the meaning.
std::string wrapped(std::string_view text, std::size_t width);

/// Writes all of @a text, or as much of it as somebody reads: 'juliavdb fractal --help | head' is no error, while data
/// that do not arrive are.
/// @throw vdbtools::IoError  it cannot be written for another reason
void writeHelp(std::string_view text);

}  // namespace cli
