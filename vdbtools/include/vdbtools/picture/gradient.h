// SPDX-License-Identifier: Apache-2.0
/// @file gradient.h
/// Numbers as colours. The named gradients are even in lightness or, if they diverge, even on both sides: viridis,
/// magma and inferno of matplotlib, cividis (Nunez, Anderton and Renslow 2018), Moreland's cool and warm (2009), and
/// grey.
#pragma once

#include <openvdb/Types.h>

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdbtools {

class Gradient {
 public:
  /// A colour as its codes in sRGB, 0 to 1.
  using Stop = std::array<double, 3>;

  /// Viridis: from dark blue through green to yellow.
  Gradient();

  /// At equal distances, the first for 0 and the last for 1. @throw std::invalid_argument  there is none
  explicit Gradient(std::vector<Stop> stops);

  /// Six digits, "ff8800": red, green and blue in hexadecimal. None if the text is something else.
  static std::optional<Stop> stopOf(std::string_view code);

  /// Of two or more colours as "000000,ff8800,ffffff": red, green and blue in hexadecimal, with or without a # before
  /// each. None if the text is no such list.
  static std::optional<Gradient> ofCodes(const std::string& list);

  /// By one of gradientNames(); none if there is no such name.
  static std::optional<Gradient> named(const std::string& name);

  /// Linear RGB. Between the stops the codes are interpolated. Values below 0 have the first colour, those above 1 the
  /// last.
  openvdb::Vec3d at(double value) const;

  const std::vector<Stop>& stops() const { return mStops; }

 private:
  std::vector<Stop> mStops;
};

/// "viridis, magma, ...".
std::string gradientNames();
/// "; did you mean 'inferno'?", or nothing.
std::string gradientMeant(const std::string& name);

}  // namespace vdbtools
