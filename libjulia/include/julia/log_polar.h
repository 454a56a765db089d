// SPDX-License-Identifier: Apache-2.0
/// @file log_polar.h
/// Quaternions in log-polar form: q = e^l u with l = ln|q| and the versor u = q/|q|.
/// The norm is multiplicative: a product adds the l and multiplies the u, a real power p multiplies l by p and turns u
/// by p times its angle, and an inverse negates l and conjugates u. Nothing overflows, whatever the number of factors
/// and their powers (docs/design.md 2.1), whereas [Kim15] needed 80 bits and [KD20] a guard. Zero is l = -inf with the
/// versor 1; infinity is l = +inf.
#pragma once

#include "julia/quaternion.h"

#include <cmath>
#include <cstdint>
#include <limits>

namespace julia {

template <class Real>
struct LogPolar {
  Real l = 0;
  Quaternion<Real> u = Quaternion<Real>::one();
};

/// ln|q|, even where |q|^2 leaves the range of Real; -inf for q = 0.
template <class Real>
Real logNorm(const Quaternion<Real>& q) {
  using std::log;
  const Real squared = normSquared(q);
  if (squared >= std::numeric_limits<Real>::min() && squared <= std::numeric_limits<Real>::max())
    return Real(0.5) * log(squared);
  using std::abs;
  using std::max;
  const Real largest = max(max(abs(q.a), abs(q.b)), max(abs(q.c), abs(q.d)));
  if (!(largest > Real(0))) return -std::numeric_limits<Real>::infinity();
  if (!(largest <= std::numeric_limits<Real>::max())) return std::numeric_limits<Real>::infinity();
  const Quaternion<Real> scaled{q.a / largest, q.b / largest, q.c / largest, q.d / largest};
  return log(largest) + Real(0.5) * log(normSquared(scaled));
}

/// q/|q|; 1 for q = 0.
template <class Real>
Quaternion<Real> versorOf(const Quaternion<Real>& q) {
  using std::sqrt;
  const Real squared = normSquared(q);
  if (squared >= std::numeric_limits<Real>::min() && squared <= std::numeric_limits<Real>::max())
    return q * (Real(1) / sqrt(squared));
  using std::abs;
  using std::max;
  const Real largest = max(max(abs(q.a), abs(q.b)), max(abs(q.c), abs(q.d)));
  if (!(largest > Real(0)) || !(largest <= std::numeric_limits<Real>::max())) return Quaternion<Real>::one();
  const Quaternion<Real> scaled{q.a / largest, q.b / largest, q.c / largest, q.d / largest};
  return scaled * (Real(1) / sqrt(normSquared(scaled)));
}

template <class Real>
LogPolar<Real> toLogPolar(const Quaternion<Real>& q) {
  return {logNorm(q), versorOf(q)};
}

/// e^l u; 0 for l = -inf.
template <class Real>
Quaternion<Real> toCartesian(const LogPolar<Real>& q) {
  using std::exp;
  return q.u * exp(q.l);
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

/// u^p for a real p: u = cos t + n sin t becomes cos pt + n sin pt, with t in [0, pi]. For a negative real, whose n is
/// arbitrary, n = i.
template <class Real>
Quaternion<Real> versorPower(const Quaternion<Real>& u, Real p) {
  using std::atan2;
  using std::cos;
  using std::sin;
  using std::sqrt;
  const Real squared = u.b * u.b + u.c * u.c + u.d * u.d;
  if (squared < std::numeric_limits<Real>::min()) {
    // The versor is so close to a real that squares underflow; the remaining components still determine the axis.
    const Quaternion<Real> rest{Real(0), u.b, u.c, u.d};
    const bool isReal = rest == Quaternion<Real>{};
    const Quaternion<Real> axis = isReal ? Quaternion<Real>{Real(0), Real(1), Real(0), Real(0)} : versorOf(rest);
    const Real angle = p * atan2(isReal ? Real(0) : axis.b * u.b + axis.c * u.c + axis.d * u.d, u.a);
    const Real sine = sin(angle);
    return {cos(angle), axis.b * sine, axis.c * sine, axis.d * sine};
  }
  const Real imaginary = sqrt(squared);
  const Real angle = p * atan2(imaginary, u.a);
  const Real scale = sin(angle) / imaginary;
  return {cos(angle), u.b * scale, u.c * scale, u.d * scale};
}

template <class Real>
LogPolar<Real> operator*(const LogPolar<Real>& p, const LogPolar<Real>& q) {
  return {p.l + q.l, p.u * q.u};
}

template <class Real>
LogPolar<Real> inverse(const LogPolar<Real>& q) {
  return {-q.l, conjugate(q.u)};
}

}  // namespace julia
