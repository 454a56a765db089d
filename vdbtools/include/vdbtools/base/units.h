// SPDX-License-Identifier: Apache-2.0
/// @file units.h
/// The unit of a file's coordinates, and the axis that points up.
#pragma once

#include <openvdb/Types.h>
#include <openvdb/math/BBox.h>

#include <utility>

namespace vdbtools {

// The unit of a shape's coordinates, if it is known.

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

// The axis of the world that points up, and the rotation from one convention to the other. Both are right-handed. From
// Y up to Z up it is the quarter turn about x that takes (x, y, z) to (x, -z, y). It only exchanges and negates
// coordinates, so it is exact and invertible.

enum class UpAxis { Y, Z };

/// "y" or "z".
constexpr const char* nameOf(UpAxis up) { return up == UpAxis::Y ? "y" : "z"; }

inline openvdb::Vec3d directionOf(UpAxis up) {
  return up == UpAxis::Y ? openvdb::Vec3d(0, 1, 0) : openvdb::Vec3d(0, 0, 1);
}

/// The rotation of points and directions from one convention to another; by default the identity.
class UpTurn {
 public:
  UpTurn() = default;
  UpTurn(UpAxis from, UpAxis to) : mTurns(from != to), mTo(to) {}

  /// Whether it differs from the identity.
  bool turns() const { return mTurns; }

  /// Rotates a point or a direction.
  template <class Vector>
  Vector operator()(const Vector& v) const {
    if (!mTurns) return v;
    // Subtract from zero, because unary minus would make a negative zero.
    return mTo == UpAxis::Z ? Vector(v[0], 0 - v[2], v[1]) : Vector(v[0], v[2], 0 - v[1]);
  }

  openvdb::BBoxd operator()(const openvdb::BBoxd& box) const {
    if (!mTurns || box.empty()) return box;
    openvdb::Vec3d low = (*this)(box.min()), high = (*this)(box.max());
    for (int axis = 0; axis < 3; ++axis)
      if (low[axis] > high[axis]) std::swap(low[axis], high[axis]);
    return {low, high};
  }

 private:
  bool mTurns = false;
  UpAxis mTo = UpAxis::Y;
};

}  // namespace vdbtools
