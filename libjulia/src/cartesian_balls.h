// SPDX-License-Identifier: Apache-2.0
/// @file cartesian_balls.h
/// Images of balls under the products to which the Cartesian maps add c. The image is a ball about the image of the
/// centre. Its radius is the ball's radius times the largest derivative over the ball, plus the rounding errors of the
/// kernels' arithmetic in Real; see ball_arithmetic.h.
#pragma once

#include "julia/ball.h"
#include "julia/cross_map.h"
#include "julia/mandelbulb.h"

#include <optional>

namespace julia {

/// Each result contains what the kernels compute at all points of @a ball where the map is defined.
/// @{

/// q^2 of quaternions.
template <class Real>
Ball squareOf(const Ball& ball);

/// The triplex power p^n, n from 2 to 64.
template <class Real>
Ball triplexPowerOf(int n, TriplexAngle angle, const Ball& ball);

/// f(p) x g(p); empty for the pair User.
template <class Real>
std::optional<Ball> crossProductOf(CrossPair pair, const Ball& ball);

/// g(p); empty for the pairs A and A', where it is unbounded, and for User.
template <class Real>
std::optional<Ball> crossSecondOf(CrossPair pair, const Ball& ball);

/// p x g + c.
template <class Real>
Ball crossProductOf(const Ball& p, const Ball& g);

template <class Real>
Ball sumOf(const Ball& a, const Ball& b);
/// @}

}  // namespace julia
