// SPDX-License-Identifier: Apache-2.0
/// @file shell_word.h
/// Quotes words of commands that can be pasted into a shell.
#pragma once

#include <string>
#include <string_view>

namespace vdbtools {

/// Returns a word of a POSIX shell that stands for exactly @a word, quoted if necessary.
std::string shellWord(std::string_view word);

}  // namespace vdbtools
