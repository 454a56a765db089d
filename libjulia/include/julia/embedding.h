// SPDX-License-Identifier: Apache-2.0
/// @file embedding.h
/// How R^3 lies in the quaternions: the point (X, Y, Z) enters as [X Y Z S], where S is the slice. The component that
/// holds S is the dropped axis, k by default: a field over R^3 is extruded along it ([SK23] 3.1).
#pragma once

#include "julia/quaternion.h"

#include <array>

namespace julia {

using Point = std::array<double, 3>;

/// Checks a map's constant. @throw std::invalid_argument unless its components lie between -1e9 and 1e9
void requireConstant(const Point& constant);

enum class DropAxis { I, J, K };

struct Embedding {
  double slice = 0;  ///< S, in units of the map's space
  DropAxis dropped = DropAxis::K;

  template <class Real>
  Quaternion<Real> quaternion(const Point& x) const {
    const Real X = static_cast<Real>(x[0]), Y = static_cast<Real>(x[1]), Z = static_cast<Real>(x[2]);
    const Real S = static_cast<Real>(slice);
    switch (dropped) {
      case DropAxis::I: return {X, S, Y, Z};
      case DropAxis::J: return {X, Y, S, Z};
      case DropAxis::K: break;
    }
    return {X, Y, Z, S};
  }

  /// The components of q that are not dropped, in order: the inverse of quaternion().
  template <class T>
  constexpr std::array<T, 3> point(const Quaternion<T>& q) const {
    switch (dropped) {
      case DropAxis::I: return {q.a, q.c, q.d};
      case DropAxis::J: return {q.a, q.b, q.d};
      case DropAxis::K: break;
    }
    return {q.a, q.b, q.c};
  }

  /// @a q with its components that are not dropped set to @a x.
  template <class T>
  constexpr Quaternion<T> put(const Quaternion<T>& q, const std::array<T, 3>& x) const {
    switch (dropped) {
      case DropAxis::I: return {x[0], q.b, x[1], x[2]};
      case DropAxis::J: return {x[0], x[1], q.c, x[2]};
      case DropAxis::K: break;
    }
    return {x[0], x[1], x[2], q.d};
  }

  /// The component of q that is dropped.
  template <class T>
  constexpr T slicePart(const Quaternion<T>& q) const {
    switch (dropped) {
      case DropAxis::I: return q.b;
      case DropAxis::J: return q.c;
      case DropAxis::K: break;
    }
    return q.d;
  }
};

}  // namespace julia
