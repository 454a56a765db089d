// SPDX-License-Identifier: Apache-2.0
/// @file ball.h
/// Balls of points, for what holds at every point of them: ball arithmetic (Rump 1999, Fast and parallel interval
/// arithmetic; van der Hoeven 2009, Ball arithmetic) with the logarithm of the modulus kept as an interval beside it.
/// It proves the sign of F over a whole block of a lattice, whose nodes then need no evaluation. Blocks near the
/// surface stay undecided: the orbit spreads a ball at each step.
#pragma once

#include "julia/quaternion.h"

#include <cstdint>
#include <limits>

namespace julia {

struct Ball {
  Quaternion<double> centre;  ///< units of the map's space
  double radius = 0;
  /// For a map that reads only a part of q, the shape modulus: in no point of the ball is that part shorter. An image
  /// is a cap of a sphere, and the ball around it reaches much nearer to 0.
  double hollow = 0;
};

/// Bounds of l = ln|f|; both ends may be taken.
struct LogRange {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
};

enum class Decision : std::uint8_t {
  Undecided,
  Inside,   ///< F < 0 at each point
  Outside,  ///< F >= 0 at each point
};

}  // namespace julia
