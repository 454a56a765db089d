// SPDX-License-Identifier: Apache-2.0
/// @file length_unit.h
/// The unit of a shape's coordinates, if it is known.
#pragma once

namespace vdbtools {

/// The metadata entry that records the unit of a file's own coordinates, as nameOf() writes it. Without it, the unit is
/// unknown.
inline constexpr const char* kLengthUnit = "julia_length_unit";

enum class LengthUnit { Millimetre, Centimetre, Metre, Inch };

inline constexpr LengthUnit kLengthUnits[] = {LengthUnit::Millimetre, LengthUnit::Centimetre, LengthUnit::Metre,
                                              LengthUnit::Inch};

/// "mm", "cm", "m" or "in".
constexpr const char* nameOf(LengthUnit unit) {
  switch (unit) {
    case LengthUnit::Millimetre: return "mm";
    case LengthUnit::Centimetre: return "cm";
    case LengthUnit::Metre: return "m";
    case LengthUnit::Inch: return "in";
  }
  return "";
}

constexpr double metresOf(LengthUnit unit) {
  switch (unit) {
    case LengthUnit::Millimetre: return 1e-3;
    case LengthUnit::Centimetre: return 1e-2;
    case LengthUnit::Metre: return 1;
    case LengthUnit::Inch: return 0.0254;
  }
  return 1;
}

}  // namespace vdbtools
