// SPDX-License-Identifier: Apache-2.0
/// @file root_patterns.h
/// Roots in a pattern, for versors whose texture is organised: a versor is made in two steps, the points of a pattern
/// and the factors that stand at them. Nothing here is random but pointsOnSurface() and jittered(), and these give the
/// same points for the same seed everywhere.
///
/// **Rings.** The direction of (q - t)^P turns P times as q goes around t in a plane through t and the real axis, and
/// does not change as q goes around the real axis. Its texture therefore consists of rings about the real axis, the X
/// axis of space ([SK23] Fig. 9), P of them to half a turn. For any other unit vector n of space, the real part of
/// (q - t) n* is the component of q - t along n, so that
///
///   ((q - t) n*) ((q - t) n*) ...        P times
///
/// has the same rings about n. The constant n* between the roots is a factor like any other: a root at a great
/// distance, see constantFactor().
#pragma once

#include "julia/embedding.h"
#include "julia/rational.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace julia {

/// @a count points at equal distances on a segment; the first and the last lie half a spacing from its ends.
/// @param axis  its direction, of any length but 0
/// @throw std::invalid_argument  as the other patterns: a count below 1 or above a million, an axis of length 0, a
/// number that is not finite
std::vector<Point> pointsOnLine(const Point& centre, const Point& axis, double length, int count);

/// @a count points at equal angles on a circle about an axis; n of them have n-fold symmetry.
std::vector<Point> pointsOnCircle(const Point& centre, const Point& axis, double radius, int count);

/// Points on a helix about an axis, at equal angles and equal distances along it. @param turns  over the whole length
std::vector<Point> pointsOnHelix(const Point& centre, const Point& axis, double radius, double length, double turns,
                                 int count);

/// The nodes of a cubic lattice in a box, with the middle of the box as the lattice's: a node where the number of nodes
/// along an axis is odd, and the middle between two where it is even. Ordered by x, then y, then z. An axis that is
/// shorter than the spacing has one node.
/// @throw std::invalid_argument  also for an empty box, or a spacing that gives more than a million nodes
std::vector<Point> pointsOfLattice(const Point& boxMin, const Point& boxMax, double spacing);

/// @a count points spread over a surface: each is the one of many random points of it that lies farthest from those
/// before it.
/// @param distance  the signed distance to the surface, right at least where it is below @a reach
/// @param boxMin    the box in which the surface is looked for
/// @param reach     units of the map's space; a hundredth of the surface's size serves
/// @throw std::invalid_argument  also where no surface is found
std::vector<Point> pointsOnSurface(const std::function<double(const Point&)>& distance, const Point& boxMin,
                                   const Point& boxMax, double reach, int count, std::uint64_t seed);

/// The points, each moved by a random vector with this standard deviation along each axis.
std::vector<Point> jittered(std::vector<Point> points, double deviation, std::uint64_t seed);

/// @a count unit vectors in the plane of two others, each turned by the same angle against the one before it. The first
/// is that of @a from, and the second lies towards @a to.
/// @param angle  radians
/// @throw std::invalid_argument  also where both point along one line
std::vector<Point> fanOfAxes(const Point& from, const Point& to, double angle, int count);

/// A factor that is the constant c/|c| but for an error of |q| / 1e6: a root at the distance of 1e6. Its modulus is
/// 1e6, see unitConstants().
Root constantFactor(const Quaternion<double>& c);

/// Appends ((q - t)^P n*) @a repeats times, for a point t and an axis n. With P = 1 these are the rings of the file's
/// head. A higher P lets the rings run into thorns and tongues, for (q - t)^P has rings of its own about the real axis.
/// An axis along the real axis takes one root, any other takes two roots for each repetition.
/// @param power    P, 1 to 1000 or -1 to -1000
/// @param repeats  1 to 1000
/// @throw std::invalid_argument
void appendRings(std::vector<Root>& roots, const Point& point, const Point& axis, int power, int repeats,
                 const Embedding& embedding);

/// The number C that makes the modulus of every constantFactor() among the roots of e^C prod (q - t)^T equal to 1, for
/// maps that use the modulus.
double unitConstants(const std::vector<Root>& roots);

}  // namespace julia
