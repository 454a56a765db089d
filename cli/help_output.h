// SPDX-License-Identifier: Apache-2.0
/// @file help_output.h
/// Help on the standard output.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace cli {

/// The maximum length of lines of help: the width of the terminal, between 60 and 120 characters; 110 without a
/// terminal.
unsigned helpWidth();

/// Rewraps a text. An empty line ends a paragraph. A line that begins with two spaces is a row of a
/// table, "  NAME   meaning"; lines that begin with more spaces continue the meaning.
std::string wrapped(std::string_view text, std::size_t width);

/// Writes @a text to the standard output. It is no error if the reader stops early, as in 'juliavdb fractal --help |
/// head'.
/// @throw vdbtools::IoError  writing failed for another reason
void writeHelp(std::string_view text);

}  // namespace cli
