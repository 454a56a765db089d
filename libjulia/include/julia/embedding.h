// SPDX-License-Identifier: Apache-2.0
/// @file embedding.h
/// How R^3 lies in the quaternions: x = (X, Y, Z) enters as [X Y Z S], S the slice; the component that holds S is the
/// dropped axis, k unless told otherwise. [SK23] 3.1: a field over R^3 is extruded along that axis.
#pragma once

#include "julia/quaternion.h"

#include <array>

namespace julia {

using Point = std::array<double, 3>;

/// For a map's constant. @throw std::invalid_argument unless its components lie between -1e9 and 1e9
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
};

}  // namespace julia
