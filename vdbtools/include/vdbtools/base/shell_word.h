// SPDX-License-Identifier: Apache-2.0
/// @file shell_word.h
/// Words of commands that can be pasted into a shell.
#pragma once

#include <string>
#include <string_view>

namespace vdbtools {

/// One word of a POSIX shell that stands for exactly @a word, in quotes where they are needed.
std::string shellWord(std::string_view word);

}  // namespace vdbtools
