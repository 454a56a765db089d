// SPDX-License-Identifier: Apache-2.0
/// @file root_patterns.h
/// Roots in a pattern, for versors with an organised texture. A versor is made in two steps: the points of a pattern,
/// and the factors at these points.
///
/// **Rings.** The direction of (q - t)^P turns P times as q goes around t in a plane through t and the real axis, and
/// does not change as q goes around the real axis. Its texture therefore consists of rings about the real axis, the X
/// axis of space ([SK23] Fig. 9), with P rings in half a turn. For any other unit vector n of space, the real part of
/// (q - t) n* is the component of q - t along n, so that
///
///   ((q - t) n*) ((q - t) n*) ...        P times
///
/// has the same rings about n. The constant n* between the roots is represented as a root at a great distance, see
/// constantFactor().
#pragma once

#include "julia/embedding.h"
#include "julia/rational.h"

#include <vector>

namespace julia {

/// Returns @a count points at equal distances on a segment; the first and the last lie half a spacing from its ends.
/// @param axis  direction of the segment, of any length but 0
/// @throw std::invalid_argument  also for fanOfAxes(): a count below 1 or above a million, an axis of length
///                               0, or a number that is not finite
std::vector<Point> pointsOnLine(const Point& centre, const Point& axis, double length, int count);

/// Returns @a count unit vectors in the plane of two others, each turned by the same angle from the one before it. The
/// first has the direction of @a from, and the second lies towards @a to.
/// @param angle  radians
/// @throw std::invalid_argument  also if both vectors are collinear
std::vector<Point> fanOfAxes(const Point& from, const Point& to, double angle, int count);

/// Returns a factor that equals the constant c/|c| up to an error of |q| / 1e6: a root at the distance of 1e6. Its
/// modulus is 1e6, see unitConstants().
Root constantFactor(const Quaternion<double>& c);

/// Appends ((q - t)^P n*) @a repeats times, for a point t and an axis n. P = 1 gives the rings described at the head of
/// this file. With a higher P the rings run into thorns and tongues, because (q - t)^P has rings of its own about the
/// real axis. Each repetition takes one root if the axis is the real axis, and two otherwise.
/// @param power    P, 1 to 1000 or -1 to -1000
/// @param repeats  1 to 1000
/// @throw std::invalid_argument  a number out of its range
void appendRings(std::vector<Root>& roots, const Point& point, const Point& axis, int power, int repeats,
                 const Embedding& embedding);

/// Returns the C for which the modulus of every constantFactor() among the roots of e^C prod (q - t)^T is 1, for maps
/// that use the modulus.
double unitConstants(const std::vector<Root>& roots);

}  // namespace julia
