// SPDX-License-Identifier: Apache-2.0
/// @file gradient.h
/// Maps numbers to colours. The named gradients are perceptually uniform in lightness or, if they diverge, symmetric in
/// it: viridis, magma and inferno of matplotlib, cividis (Nunez, Anderton and Renslow 2018), Moreland's cool and warm
/// (2009), and grey.
#pragma once

#include "vdbtools/picture/image.h"

#include <openvdb/Types.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdbtools {

// Converts an image to screen codes.

/// Returns red, green and blue of each pixel, row by row from the top left, as 8-bit sRGB codes: the contents of a PNG
/// of the image.
std::vector<std::uint8_t> screenCodes(const Image& image);

class Gradient {
 public:
  /// A colour as its sRGB codes, 0 to 1.
  using Stop = std::array<double, 3>;

  /// Viridis: from dark blue through green to yellow.
  Gradient();

  /// Places the stops at equal distances, the first at 0 and the last at 1. @throw std::invalid_argument  there are no
  /// stops
  explicit Gradient(std::vector<Stop> stops);

  /// Parses six hexadecimal digits for red, green and blue, "ff8800". Returns nullopt for any other text.
  static std::optional<Stop> stopOf(std::string_view code);

  /// Parses two or more colours as "000000,ff8800,ffffff": red, green and blue in hexadecimal, each with or without a
  /// leading #. Returns nullopt if the text is not such a list.
  static std::optional<Gradient> ofCodes(const std::string& list);

  /// Returns the gradient with one of gradientNames(); nullopt if there is no such name.
  static std::optional<Gradient> named(const std::string& name);

  /// Returns linear RGB. The codes are interpolated between the stops. Values below 0 get the first colour, those above
  /// 1 the last.
  openvdb::Vec3d at(double value) const;

  const std::vector<Stop>& stops() const { return mStops; }

 private:
  std::vector<Stop> mStops;
};

/// The names of all gradients.
std::vector<std::string> gradientNames();

}  // namespace vdbtools
