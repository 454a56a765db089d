// SPDX-License-Identifier: Apache-2.0
/// @file near_words.h
/// Which of some words was meant by one that is misspelt.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace vdbtools {

/// How many letters have to be added, left out, replaced, or exchanged with their neighbour to make one word of the
/// other, where no part is changed twice ([Dam64]).
std::size_t editDistance(std::string_view a, std::string_view b);

/// The word that was probably meant: one that begins with @a word, or else one that differs from it in up to a third of
/// its letters, whatever their case. The nearest, and of equally near ones the first; none if no word is that near.
std::optional<std::string> nearestWord(std::string_view word, std::span<const std::string> known);

/// "; did you mean 'x'?", or nothing.
/// @param prefix  what stands before the word where it is typed
std::string didYouMean(std::string_view word, std::span<const std::string> known, const std::string& prefix = "");

}  // namespace vdbtools
