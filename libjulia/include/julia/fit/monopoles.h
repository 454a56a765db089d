// SPDX-License-Identifier: Apache-2.0
/// @file monopoles.h
/// A potential as a sum of monopoles w_i / |x - m_i| on the surface ([Kim15] Eqs. 14 to 17 and Algorithm 1), and the
/// rational that has them as its roots ([Kim15] 4.4). The fit of a rational to a shape starts from this rational.
#pragma once

#include "julia/fit/surface.h"
#include "julia/rational.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace julia {

struct MonopoleOptions {
  double epsilon = 0.04;                ///< the relative residual |p - C w| / |p| at which the method stops; in (0, 1)
  std::size_t maxCount = 1000;          ///< the maximum number of monopoles
  std::size_t candidatesPerStep = 100;  ///< positions compared for each monopole
  std::uint64_t seed = 1;               ///< for the candidates
  /// Called from time to time; if it returns true, the work ends.
  std::function<bool()> cancelled;
};

struct Monopole {
  Point position;     ///< units of the map's space
  double weight = 0;  ///< potential times distance, positive or negative

  friend bool operator==(const Monopole&, const Monopole&) = default;
};

struct MonopoleFit {
  std::vector<Monopole> monopoles;  ///< in the order in which they were found
  /// |p - C w| / |p| after each monopole. The last is above epsilon if maxCount was too small, or if no further
  /// candidate improved it.
  std::vector<double> residuals;
};

/// Fits monopoles greedily: each step draws candidates from blue noise on the surface, none twice, and takes the one
/// whose column c (c_i = 1 / |x_i - m|, not normalised) has the largest |c . r| with the current least-squares residual
/// r. A candidate whose column depends linearly on the columns before it is skipped. The same input gives the same
/// bytes for any number of threads and on any machine.
/// @param surface     where monopoles are placed
/// @param samples     where the potential is known, preferably on an offset surface outside @a surface
/// @param potentials  the potential at each sample
/// @param options     see MonopoleOptions
/// @throw std::invalid_argument  as blueNoise(); no samples, different sizes, a number that is not finite or beyond
///                               1e9, a potential that is 0 at all samples, or an option out of its domain
/// @throw Cancelled              options.cancelled returned true
MonopoleFit fitMonopoles(const TriangleSurface& surface, std::span<const Point> samples,
                         std::span<const double> potentials, const MonopoleOptions& options = {});

/// Turns monopoles of positive weight into top roots and those of negative weight into bottom roots, in the slice 0. A
/// weight of 0 gives no root.
/// @param monopoles       positions and weights
/// @param powerPerWeight  a root's power is this times |weight|
/// @param rootsAtOrigin   whether each side begins with a root of power 1 at the origin, as in the program released
///                        with [Kim15]
/// @throw std::invalid_argument  powerPerWeight is not above 0, or as requireFinite(const Rational&)
Rational rationalFromMonopoles(std::span<const Monopole> monopoles, double powerPerWeight, bool rootsAtOrigin);

}  // namespace julia
