// SPDX-License-Identifier: Apache-2.0
/// @file option_value.h
/// The text of an option's value into what it means. Each function
/// @throw std::invalid_argument  naming the option, its value and what is expected
#pragma once

#include "vdbtools/base/text.h"

#include <openvdb/Types.h>
#include <openvdb/math/BBox.h>

#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace vdbtools {

/// @param wanted  what follows "it must be"
[[noreturn]] void refuse(const std::string& option, const std::string& text, const std::string& wanted);

/// Refuses a value that is none of the allowed words, and suggests the word that was probably meant.
[[noreturn]] void refuseChoice(const std::string& option, const std::string& text,
                               std::span<const std::string> choices);

/// The parts between separators; one empty part for an empty text.
std::vector<std::string> split(const std::string& text, char separator);

/// The values of a list such as "0,1.5,-2": @a count finite numbers.
std::vector<double> parseNumbers(const std::string& option, const std::string& text, std::size_t count);
double parseNumber(const std::string& option, const std::string& text);
openvdb::Vec3d parseVector(const std::string& option, const std::string& text);

/// "x0,y0,z0,x1,y1,z1", the smaller corner first.
openvdb::BBoxd parseBox(const std::string& option, const std::string& text);

template <class Integer>
Integer parseInteger(const std::string& option, const std::string& text, Integer low, Integer high) {
  const std::optional<Integer> value = wholeFromText<Integer>(text);
  if (!value || *value < low || *value > high)
    refuse(option, text, "a whole number from " + std::to_string(low) + " to " + std::to_string(high));
  return *value;
}

/// Words, in the order in which the help shows them, and what they mean.
template <class Value>
using Choices = std::vector<std::pair<std::string, Value>>;

template <class Value>
std::vector<std::string> wordsOf(const Choices<Value>& choices) {
  std::vector<std::string> words;
  for (const auto& [word, value] : choices) words.push_back(word);
  return words;
}

/// What a word means. @param option  for the error @throw std::invalid_argument  it is none of the words
template <class Value>
Value chosen(const std::string& option, const std::string& text, const Choices<Value>& choices) {
  for (const auto& [word, value] : choices)
    if (word == text) return value;
  refuseChoice(option, text, wordsOf(choices));
}

/// The shortest text that reads back as the same doubles, with commas between them.
std::string numbersText(std::span<const double> values);
std::string numbersText(std::initializer_list<double> values);
/// The same for one number, with its exponent as in help and errors: "5e-5".
std::string numberText(double value);

}  // namespace vdbtools
