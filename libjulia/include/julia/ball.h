// SPDX-License-Identifier: Apache-2.0
/// @file ball.h
/// Ball arithmetic (Rump 1999, Fast and parallel interval arithmetic; van der Hoeven 2009, Ball arithmetic) proves
/// statements about every point of a ball. Here the logarithm of the modulus is kept as an interval. Ball arithmetic
/// proves the sign of F over a whole block of a lattice, whose nodes then need no evaluation. Blocks near the surface
/// stay undecided, because each step of the orbit enlarges a ball.
#pragma once

#include "julia/quaternion.h"

#include <cstdint>
#include <limits>

namespace julia {

struct Ball {
  Quaternion<double> centre;  ///< units of the map's space
  double radius = 0;
  /// The shape modulus reads E at only three components of q. This is a lower bound of the length of that part of q
  /// over the points that the ball stands for. An image is a cap of a sphere, and the ball around it reaches much
  /// nearer to 0.
  double hollow = 0;
};

/// Bounds of l = ln|f|, including both ends.
struct LogRange {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
};

/// The directions in which the versors over a ball may point: all directions within an angle of an axis.
struct Cone {
  Quaternion<double> axis = Quaternion<double>::one();
  double quadrants = 2;  ///< the angle in quarter turns; 1 or more if nothing is known
};

enum class Decision : std::uint8_t {
  Undecided,
  Inside,   ///< F < 0 at each point
  Outside,  ///< F >= 0 at each point
};

}  // namespace julia
