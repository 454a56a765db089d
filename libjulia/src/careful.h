// SPDX-License-Identifier: Apache-2.0
/// @file careful.h
/// Evaluation of one quaternion at a time where squares would leave the range of Real, which the kernels leave out, in
/// log-polar form: ln|q| and the versor q/|q|. Like the kernels, it uses no functions that a C library may compute
/// differently on another processor.
#pragma once

#include "julia/quaternion.h"

#include "kernels/elementary.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace julia::careful {

/// Scales d by the power of two that brings the magnitude of its largest component into [1, 2), and returns that
/// power's exponent, negated.
/// @pre d is finite and not 0
template <class Real>
Quaternion<Real> broughtNearOne(const Quaternion<Real>& d, int& exponent) {
  exponent = std::ilogb(std::max({std::abs(d.a), std::abs(d.b), std::abs(d.c), std::abs(d.d)}));
  const auto by = [&](Real x) { return std::scalbn(x, -exponent); };
  return {by(d.a), by(d.b), by(d.c), by(d.d)};
}

template <class Real>
bool isFinite(const Quaternion<Real>& q) {
  return std::isfinite(q.a) && std::isfinite(q.b) && std::isfinite(q.c) && std::isfinite(q.d);
}

/// ln|q|; -inf for q = 0, +inf if a component is not finite.
template <class Real>
Real logNorm(const Quaternion<Real>& q) {
  if (!isFinite(q)) return std::numeric_limits<Real>::infinity();
  if (q == Quaternion<Real>{}) return -std::numeric_limits<Real>::infinity();
  int exponent = 0;
  const Quaternion<Real> near = broughtNearOne(q, exponent);
  constexpr Real kLn2 = Real(0.69314718055994530942);
  return Real(0.5) * kernels::logarithm(normSquared(near)) + static_cast<Real>(exponent) * kLn2;
}

/// q/|q|; 1 for q = 0, and if a component is not finite.
template <class Real>
Quaternion<Real> versorOf(const Quaternion<Real>& q) {
  if (q == Quaternion<Real>{} || !isFinite(q)) return Quaternion<Real>::one();
  int exponent = 0;
  const Quaternion<Real> near = broughtNearOne(q, exponent);
  return near * (1 / std::sqrt(normSquared(near)));
}

/// u^n by repeated squaring; a negative n conjugates.
template <class Real>
Quaternion<Real> versorPower(const Quaternion<Real>& u, std::int64_t n) {
  Quaternion<Real> base = n < 0 ? conjugate(u) : u;
  Quaternion<Real> result = Quaternion<Real>::one();
  for (std::uint64_t rest = n < 0 ? 0 - static_cast<std::uint64_t>(n) : static_cast<std::uint64_t>(n); rest != 0;
       rest >>= 1) {
    if (rest & 1) result = result * base;
    base = base * base;
  }
  return result;
}

}  // namespace julia::careful
