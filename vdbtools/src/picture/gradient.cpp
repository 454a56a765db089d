// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/picture/gradient.h"

#include "base/srgb.h"
#include "vdbtools/base/text.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

namespace vdbtools {
namespace {

struct NamedGradient {
  const char* name;
  std::vector<std::uint32_t> stops;  ///< 0xRRGGBB
};

const std::vector<NamedGradient>& namedGradients() {
  static const std::vector<NamedGradient> all = {
      {"viridis", {0x440154, 0x482878, 0x3e4989, 0x31688e, 0x26828e, 0x1f9e89, 0x35b779, 0x6ece58, 0xb5de2b, 0xfde725}},
      {"magma", {0x000004, 0x180f3d, 0x440f76, 0x721f81, 0x9e2f7f, 0xcd4071, 0xf1605d, 0xfd9668, 0xfeca8d, 0xfcfdbf}},
      {"inferno", {0x000004, 0x1b0c41, 0x4a0c6b, 0x781c6d, 0xa52c60, 0xcf4446, 0xed6925, 0xfb9b06, 0xf7d13d, 0xfcffa4}},
      {"cividis", {0x00224e, 0x123570, 0x3b496c, 0x575d6d, 0x707173, 0x8a8678, 0xa59c74, 0xc3b369, 0xe1cc55, 0xfee838}},
      {"coolwarm", {0x3b4cc0, 0x6282ea, 0x8db0fe, 0xb8d0f9, 0xdddddd, 0xf5c4ad, 0xf49a7b, 0xde604d, 0xb40426}},
      {"grey", {0x000000, 0xffffff}},
  };
  return all;
}

Gradient::Stop stopOfNumber(std::uint32_t code) {
  constexpr double kLargestCode = 255;
  return {(code >> 16 & 0xff) / kLargestCode, (code >> 8 & 0xff) / kLargestCode, (code & 0xff) / kLargestCode};
}

std::vector<Gradient::Stop> stopsOf(const NamedGradient& gradient) {
  std::vector<Gradient::Stop> stops;
  for (const std::uint32_t code : gradient.stops) stops.push_back(stopOfNumber(code));
  return stops;
}

}  // namespace

Gradient::Gradient() : Gradient(stopsOf(namedGradients().front())) {}

Gradient::Gradient(std::vector<Stop> stops) : mStops(std::move(stops)) {
  if (mStops.empty()) throw std::invalid_argument("a gradient has no colour; give it one or more");
}

std::optional<Gradient::Stop> Gradient::stopOf(std::string_view code) {
  constexpr std::size_t kDigits = 6;
  constexpr int kHexadecimal = 16;
  std::uint32_t value = 0;
  const auto [rest, error] = std::from_chars(code.data(), code.data() + code.size(), value, kHexadecimal);
  if (code.size() != kDigits || error != std::errc() || rest != code.data() + code.size()) return std::nullopt;
  return stopOfNumber(value);
}

std::optional<Gradient> Gradient::ofCodes(const std::string& list) {
  std::vector<Stop> stops;
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    std::string_view code = std::string_view(list).substr(begin, end - begin);
    if (code.starts_with('#')) code.remove_prefix(1);
    const std::optional<Stop> stop = stopOf(code);
    if (!stop) return std::nullopt;
    stops.push_back(*stop);
    begin = end + 1;
  }
  if (stops.size() < 2) return std::nullopt;
  return Gradient(std::move(stops));
}

std::optional<Gradient> Gradient::named(const std::string& name) {
  for (const NamedGradient& gradient : namedGradients())
    if (name == gradient.name) return Gradient(stopsOf(gradient));
  return std::nullopt;
}

openvdb::Vec3d Gradient::at(double value) const {
  const std::size_t last = mStops.size() - 1;
  // A NaN gets the first colour.
  const double place = value > 0 ? std::min(value, 1.0) * static_cast<double>(last) : 0;
  const std::size_t before = std::min(last, static_cast<std::size_t>(place)), behind = std::min(last, before + 1);
  const double part = place - static_cast<double>(before);
  openvdb::Vec3d colour;
  for (std::size_t c = 0; c < 3; ++c)
    colour[static_cast<int>(c)] = linearFromSrgb((1 - part) * mStops[before][c] + part * mStops[behind][c]);
  return colour;
}

std::vector<std::string> gradientNames() {
  std::vector<std::string> names;
  for (const NamedGradient& gradient : namedGradients()) names.emplace_back(gradient.name);
  return names;
}

}  // namespace vdbtools
