// SPDX-License-Identifier: Apache-2.0
/// @file near_words.h
/// Suggests the word that was meant by a misspelt one.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace vdbtools {

/// The number of letters that must be inserted, deleted, replaced, or exchanged with their neighbour to turn one word
/// into the other, where no part is edited twice ([Dam64]).
std::size_t editDistance(std::string_view a, std::string_view b);

/// Returns the word that was probably meant: one that begins with @a word, or else one that differs from it in up to a
/// third of its letters, ignoring case. It is the nearest such word, and the first of equally near ones; nullopt if no
/// word is that near.
std::optional<std::string> nearestWord(std::string_view word, std::span<const std::string> known);

/// "; did you mean 'x'?", or an empty text.
/// @param prefix  what is typed before the word
std::string didYouMean(std::string_view word, std::span<const std::string> known, const std::string& prefix = "");

}  // namespace vdbtools
