// SPDX-License-Identifier: Apache-2.0
/// @file monopoles.h
/// A potential as a sum of monopoles w_i / |x - m_i| on the surface ([Kim15] Eqs. 14 to 17 and Algorithm 1), and the
/// rational that has them as its roots ([Kim15] 4.4). It is where the fit of a rational to a shape starts.
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
  double epsilon = 0.04;                ///< the relative residual |p - C w| / |p| that is good enough; in (0, 1)
  std::size_t maxCount = 1000;          ///< the most monopoles
  std::size_t candidatesPerStep = 100;  ///< places compared for each monopole
  std::uint64_t seed = 1;               ///< for the candidates
  /// Called now and then; if it returns true, the work ends.
  std::function<bool()> cancelled;
};

struct Monopole {
  Point position;     ///< units of the map's space
  double weight = 0;  ///< potential times distance, positive or negative

  friend bool operator==(const Monopole&, const Monopole&) = default;
};

struct MonopoleFit {
  std::vector<Monopole> monopoles;  ///< in the order in which they were found
  /// |p - C w| / |p| after each of them. The last is above epsilon if maxCount was too small, or if no further
  /// candidate made a difference.
  std::vector<double> residuals;
};

/// A greedy method: each step draws candidates from blue noise on the surface, none twice, and takes the one whose
/// column c (c_i = 1 / |x_i - m|, not normalised) has the largest |c . r| with the residual r of the least squares so
/// far. A candidate whose column depends on the columns before it is passed over. The same input gives the same bytes
/// for any number of threads and on any machine.
/// @param surface     where monopoles are put
/// @param samples     where the potential is known, best on an offset surface outside @a surface
/// @param potentials  the potential at each sample
/// @param options     see MonopoleOptions
/// @throw std::invalid_argument  as blueNoise(); no samples, different sizes, a number that is not finite or beyond
/// 1e9,
///                               a potential that is 0 at all samples, or an option out of its domain
/// @throw Cancelled              options.cancelled returned true
MonopoleFit fitMonopoles(const TriangleSurface& surface, std::span<const Point> samples,
                         std::span<const double> potentials, const MonopoleOptions& options = {});

/// Turns monopoles of positive weight into top roots and those of negative weight into bottom roots; a weight of 0
/// gives no root. Roots lie in the slice 0.
/// @param monopoles       positions and weights
/// @param powerPerWeight  a root's power is this times |weight|
/// @param rootsAtOrigin   whether to put a root of power 1 at the origin first on each side, as the program released
/// with
///                        [Kim15] does
/// @throw std::invalid_argument  powerPerWeight is not above 0, or as requireFinite(const Rational&)
Rational rationalFromMonopoles(std::span<const Monopole> monopoles, double powerPerWeight, bool rootsAtOrigin);

}  // namespace julia
