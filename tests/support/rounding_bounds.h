// SPDX-License-Identifier: Apache-2.0
/// @file rounding_bounds.h
/// How far rounding in Real may move a rational's value and the field of an orbit: running error bounds, so that tests
/// need no tolerance found by trial. Points and root positions are taken to be exact in Real, powers need not be.
#pragma once

#include "support/float128.h"
#include "support/reference.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace law_tests {

inline constexpr double kUnbounded = std::numeric_limits<double>::infinity();

struct Tolerance {
  double l = 0, versor = 0;
};

/// What rounding may do to a rational at @a q, to first order.
///   A factor's logarithm: the difference eps/2 a component, then logNorm's eps (2 |l| + 4). Its product with the
///   power: eps/2, and eps/2 for the power's own rounding. A sum of n terms: eps/2 of everything for each. That is l.
///   A factor's versor: eps/2 for the difference, 5 eps for its norm and direction, 12 eps (|p| + 1) for the power (see
///   log_polar_test.cpp) and pi |p| eps/2 for the power's own rounding; then 4 eps for the product. The last
///   normalisation costs 5 eps. The direction's error is multiplied by |p|, which the 12 eps contain.
template <class Real>
Tolerance tolerance(const julia::Rational& rational, const Quaternion<double>& q) {
  constexpr double eps = kEpsilon<Real>;
  Tolerance result{0, 5 * eps};
  double terms = std::abs(rational.logScale), count = 1;
  for (const julia::Polynomial* polynomial : {&rational.top, &rational.bottom})
    for (const julia::Root& root : polynomial->roots) {
      const double p = std::abs(root.power * polynomial->powerScale);
      const double l = std::abs(std::log(static_cast<double>(length(q - root.position))));
      if (p == 0 || l == kUnbounded) continue;
      result.l += eps * p * (2 * l + 5 + l);
      result.versor += eps * (12 * (p + 1) + 2 * p + 4);
      terms += p * l;
      count += 1;
    }
  result.l += eps * count * terms;
  return result;
}

/// What one step of a map makes of an error of @a delta in q: the error of l, and that of the next q.
struct StepError {
  double l = 0, q = 0;
};
/// (q, delta, f(q)) -> errors. All in the widest sense: kUnbounded where delta reaches a root.
using StepBound = std::function<StepError(const Quaternion<Wide>&, double, const Quaternion<Wide>&)>;

/// How far a rational's l and versor move when q moves by @a delta: each factor's by |p| delta / (|q - t| - delta). A
/// power that is not whole also has an axis to turn, and a cut along the negative reals.
inline Tolerance sensitivity(const julia::Rational& rational, const Quaternion<Wide>& q, double delta) {
  Tolerance result;
  if (delta == 0) return result;
  for (const julia::Polynomial* polynomial : {&rational.top, &rational.bottom})
    for (const julia::Root& root : polynomial->roots) {
      const double p = std::abs(root.power * polynomial->powerScale);
      if (p == 0) continue;
      Quaternion<Wide> difference = q - root.position.as<Wide>();
      const double distance = static_cast<double>(length(difference));
      difference.a = 0;
      const double imaginary = static_cast<double>(length(difference));
      if (delta >= distance) return {kUnbounded, kUnbounded};
      result.l += p * delta / (distance - delta);
      result.versor += p * delta / (distance - delta);
      if (p != std::floor(p)) result.versor += delta < imaginary ? delta / (imaginary - delta) : kUnbounded;
    }
  return result;
}

/// e^l u as the next iterate: errors of l are relative ones; exp and a product cost 3 eps.
template <class Real>
double nextError(const Quaternion<Wide>& next, double l, double versor) {
  return static_cast<double>(length(next)) * (std::expm1(l) + versor + 3 * kEpsilon<Real>);
}

template <class Real>
StepBound rationalBound(const julia::Rational& rational) {
  return [rational](const Quaternion<Wide>& q, double delta, const Quaternion<Wide>& next) -> StepError {
    const Tolerance rounding = tolerance<Real>(rational, q.as<double>()), moved = sensitivity(rational, q, delta);
    const double l = rounding.l + moved.l;
    return {l, nextError<Real>(next, l, rounding.versor + moved.versor)};
  };
}

/// @param slope     of the exponent E, its Lipschitz constant
/// @param rounding  of E itself in Real, given |q|
template <class Real>
StepBound shapeModulusBound(const julia::Rational& versor, double slope, std::function<double(double)> rounding) {
  return [=](const Quaternion<Wide>& q, double delta, const Quaternion<Wide>& next) -> StepError {
    const Tolerance direction = tolerance<Real>(versor, q.as<double>()), moved = sensitivity(versor, q, delta);
    const double l = slope * delta + rounding(static_cast<double>(length(q)) + delta);
    return {l, nextError<Real>(next, l, direction.versor + moved.versor)};
  };
}

/// A component of q^2 + c costs four products and four sums; then logNorm, versorOf and e^l u.
template <class Real>
StepBound quadraticStepBound(const Quaternion<double>& c) {
  return [c](const Quaternion<Wide>& q, double delta, const Quaternion<Wide>& next) -> StepError {
    constexpr double eps = kEpsilon<Real>;
    const double size = static_cast<double>(length(q)) + delta, to = static_cast<double>(length(next));
    const double value = 2 * size * delta + 8 * eps * (size * size + static_cast<double>(length(c)));
    if (value >= to) return {kUnbounded, kUnbounded};
    const double l = value / (to - value) + eps * (2 * std::abs(std::log(to)) + 4);
    return {l, value + nextError<Real>(next, eps * (2 * std::abs(std::log(to)) + 4), 5 * eps)};
  };
}

struct BoundedOrbit {
  julia::reference::Orbit<Wide> orbit;
  double bound = 0;     ///< of the error of orbit.logModulus in Real; kUnbounded where chaos has eaten all digits
  bool decided = true;  ///< false if rounding may let the orbit end at another step
};

/// The reference's orbit, one step at a time, with the error that Real may have made so far.
template <class Real>
BoundedOrbit boundedOrbit(const julia::reference::MapFunction<Wide>& map, const StepBound& stepBound,
                          Quaternion<Wide> q, int maxIterations, double escapeRadius) {
  BoundedOrbit result;
  double delta = 0;
  const double logEscape = std::log(escapeRadius);
  result.orbit.logModulus = log(length(q));
  result.bound = kEpsilon<Real> * (2 * std::abs(static_cast<double>(result.orbit.logModulus)) + 4);
  for (int& i = result.orbit.iterations;; ++i) {
    const double l = static_cast<double>(result.orbit.logModulus);
    if (!(std::abs(l - logEscape) > result.bound + kEpsilon<Real> * logEscape)) result.decided = false;
    if (!(l < logEscape) || i == maxIterations) return result;
    const Quaternion<Wide> next = *map(q);
    const StepError error = delta < kUnbounded ? stepBound(q, delta, next) : StepError{kUnbounded, kUnbounded};
    result.bound = error.l;
    // Past this a first-order bound says nothing.
    delta = error.l < 0.1 && error.q < 0.1 * static_cast<double>(length(next)) ? error.q : kUnbounded;
    q = next;
    result.orbit.logModulus = log(length(q));
  }
}

}  // namespace law_tests
