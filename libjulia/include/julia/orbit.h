// SPDX-License-Identifier: Apache-2.0
/// @file orbit.h
/// The orbit of a point and the field that it defines (docs/design.md 2.3):
///
///   q_0 = [x S];  while l < ln(escape) and i < n: q_{i+1} = f(q_i);   F(x) = l_last - level.
///
/// F < 0 inside, F >= 0 outside. An orbit that enters the trapped ball stops there: see shell.h.
#pragma once

#include <limits>

namespace julia {

struct OrbitOptions {
  int maxIterations = 3;     ///< n, at least 1
  double escapeRadius = 20;  ///< in units of the map's space, > 1
  /// An iterate with l <= logTrap, after the first step or later, is inside whatever follows. -inf means that no such
  /// ball is known.
  double logTrap = -std::numeric_limits<double>::infinity();
  /// Whether trapped orbits are nevertheless followed to their end, to check that they stay inside. Where they do, F
  /// keeps the value that the trap gave it, so that a correct trap changes no bit.
  bool confirmTrap = false;

  bool operator==(const OrbitOptions&) const = default;
};

/// Bounds that keep every intermediate number finite in 32 bits, and counters in 16.
inline constexpr int kMaxIterations = 30000;
inline constexpr double kMaxEscapeRadius = 1e9;

/// @throw std::invalid_argument naming the option and its value
void requireValid(const OrbitOptions& options);

/// |F| is clamped to this, so that an evaluator never returns an infinite value.
inline constexpr double kFieldLimit = 1e30;

}  // namespace julia
