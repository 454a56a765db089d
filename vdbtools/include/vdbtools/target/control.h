// SPDX-License-Identifier: Apache-2.0
/// @file control.h
/// A setting that may vary over space, as alpha and beta do ([SK23] 3.2, Fig. 7): a number, a ramp along an axis, or a
/// FloatGrid.
#pragma once

#include "vdbtools/base/grids.h"

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <variant>

namespace vdbtools {

/// From one value to another along an axis of the target's box; constant before and after.
struct Ramp {
  int axis = 0;                   ///< 0 X, 1 Y, 2 Z
  double from = 0, to = 0;        ///< the values
  double startAt = 0, endAt = 1;  ///< where they are reached, as fractions of the target's box; startAt < endAt
  bool smooth = false;            ///< cubic 3t^2 - 2t^3 instead of linear: no crease at either end
};

class Control {
 public:
  Control(double value = 0) : mSource(value) {}
  /// @throw std::invalid_argument  values not finite, or startAt >= endAt
  Control(const Ramp& ramp, const openvdb::BBoxd& targetBox);
  /// Read trilinearly, in the grid's own world space. @throw DataError if a value is not finite
  explicit Control(openvdb::FloatGrid::ConstPtr grid);

  /// A function of the world position. Each thread takes its own: it may carry a cache.
  std::function<double(const openvdb::Vec3d&)> reader() const;

  /// The value, if it is the same everywhere.
  std::optional<double> constant() const;

  /// Bounds of the values anywhere.
  std::pair<double, double> range() const;

 private:
  struct PlacedRamp {
    Ramp ramp;
    double start, end;  ///< world coordinates
  };
  std::variant<double, PlacedRamp, openvdb::FloatGrid::ConstPtr> mSource;
};

/// Parses the text form: a number ("40"), or a ramp "AXIS:FROM[@POS]:TO[@POS][:smooth]" such as "x:10:300:smooth" or
/// "y:10@0.2:300@0.8". Anything else is not for this function (a file name, say): nothing.
/// @throw std::invalid_argument  a ramp or number that is broken or not finite, naming where
std::variant<std::monostate, double, Ramp> parseControl(const std::string& text);

}  // namespace vdbtools
