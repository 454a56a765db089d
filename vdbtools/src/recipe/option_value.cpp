// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/recipe/option_value.h"

#include "vdbtools/base/text.h"

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string_view>

namespace vdbtools {

void refuse(const std::string& option, const std::string& text, const std::string& wanted) {
  throw std::invalid_argument("--" + option + " is '" + text + "'; it must be " + wanted);
}

void refuseChoice(const std::string& option, const std::string& text, std::span<const std::string> choices) {
  refuse(option, text, "one of " + joined(choices) + didYouMean(text, choices));
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  if (text.empty() || text.back() == separator) parts.emplace_back();
  return parts;
}

std::vector<double> parseNumbers(const std::string& option, const std::string& text, std::size_t count) {
  const std::string wanted =
      count == 1 ? "a finite number" : std::to_string(count) + " finite numbers with commas between them";
  std::vector<double> values;
  for (const std::string& part : split(text, ',')) {
    const std::optional<double> value = numberFromText(part);
    if (!value || !std::isfinite(*value)) refuse(option, text, wanted);
    values.push_back(*value);
  }
  if (values.size() != count) refuse(option, text, wanted);
  return values;
}

double parseNumber(const std::string& option, const std::string& text) { return parseNumbers(option, text, 1).front(); }

openvdb::Vec3d parseVector(const std::string& option, const std::string& text) {
  const std::vector<double> values = parseNumbers(option, text, 3);
  return {values[0], values[1], values[2]};
}

openvdb::BBoxd parseBox(const std::string& option, const std::string& text) {
  const std::vector<double> b = parseNumbers(option, text, 6);
  const openvdb::BBoxd box(openvdb::Vec3d(b[0], b[1], b[2]), openvdb::Vec3d(b[3], b[4], b[5]));
  for (int axis = 0; axis < 3; ++axis)
    if (!(box.min()[axis] < box.max()[axis])) refuse(option, text, "x0,y0,z0,x1,y1,z1 with the smaller corner first");
  return box;
}

std::string numbersText(std::span<const double> values) {
  std::string text;
  for (const double value : values) {
    char digits[32];
    if (!text.empty()) text += ',';
    text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
  }
  return text;
}

std::string numbersText(std::initializer_list<double> values) {
  return numbersText(std::span(values.begin(), values.size()));
}

std::string numberText(double value) {
  std::string text = numbersText({value});
  for (const char* const filled : {"e+0", "e-0", "e+"})
    if (const std::size_t at = text.find(filled); at != std::string::npos)
      text.replace(at, std::string_view(filled).size(), filled[1] == '-' ? "e-" : "e");
  return text;
}

}  // namespace vdbtools
