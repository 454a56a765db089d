// SPDX-License-Identifier: Apache-2.0
/// @file monopoles.h
/// A potential as a sum of monopoles on the surface, w_i / |x - m_i| ([Kim15] Eqs. 14 to 17 and Algorithm 1), and the
/// rational whose roots they are ([Kim15] 4.4): the start of the fit of a rational to a shape.
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
  double epsilon = 0.04;                ///< of the relative residual |p - C w| / |p| that is good enough; in (0, 1)
  std::size_t maxCount = 1000;          ///< monopoles at most
  std::size_t candidatesPerStep = 100;  ///< places compared for each monopole
  std::uint64_t seed = 1;               ///< of the candidates
  /// Asked now and then; true ends the work.
  std::function<bool()> cancelled;
};

struct Monopole {
  Point position;     ///< units of the map's space
  double weight = 0;  ///< potential times distance, of either sign

  friend bool operator==(const Monopole&, const Monopole&) = default;
};

struct MonopoleFit {
  std::vector<Monopole> monopoles;  ///< in the order in which they were found
  std::vector<double> residuals;    ///< |p - C w| / |p| after each of them; the last is above epsilon if it was not
                                    ///< reached with maxCount, or with any candidate that made a difference
};

/// Greedy: each step draws candidates from a blue noise of the surface, none twice, and takes the one whose column c
/// (c_i = 1 / |x_i - m|, as it is, not normalised) has the largest |c . r| with the residual r of the least squares so
/// far. One that depends on the columns before it is passed over.
/// @param samples  where the potential is known, best on an offset surface outside @a surface
/// The same input gives the same bytes for any number of threads and on any machine.
/// @throw std::invalid_argument  as blueNoise(); no samples, sizes that differ, a number that is not finite or beyond
///                               1e9, a potential of 0, or an option out of its domain
/// @throw Cancelled              options.cancelled said so
MonopoleFit fitMonopoles(const TriangleSurface& surface, std::span<const Point> samples,
                         std::span<const double> potentials, const MonopoleOptions& options = {});

/// Positive weights become top roots, negative ones bottom roots, with the power |weight| @a powerPerWeight; those of
/// weight 0 none. Roots lie in the slice 0.
/// @param rootsAtOrigin  adds one of power 1 on each side, before the others, as the program released with [Kim15] does
/// @throw std::invalid_argument  powerPerWeight is not above 0, or as requireFinite(const Rational&)
Rational rationalFromMonopoles(std::span<const Monopole> monopoles, double powerPerWeight, bool rootsAtOrigin);

}  // namespace julia
