// SPDX-License-Identifier: Apache-2.0
/// @file reference.h
/// The slow evaluator, which follows the papers literally: one point at a time, Cartesian quaternions, in a type of the
/// caller's choice. The type may be double, long double, or a 128-bit type whose log, exp, pow, sqrt, sin, cos and acos
/// are found by argument-dependent look-up (boost::multiprecision::float128). Tests compare all fast code with it;
/// nothing else is implemented twice.
///
/// The guard of [KD20] Eq. 2 is optional: an evaluation whose bottom polynomial leaves too few exponent bits counts as
/// divergent.
#pragma once

#include "julia/quaternion.h"
#include "julia/rational.h"

#include <cmath>
#include <functional>
#include <limits>
#include <optional>

namespace julia::reference {

template <class T>
T norm(const Quaternion<T>& q) {
  using std::sqrt;
  return sqrt(normSquared(q));
}

/// q^p = |q|^p (cos pt + n sin pt) with q = |q| (cos t + n sin t), t in [0, pi]; n = i for a negative real. 0^0 = 1.
template <class T>
Quaternion<T> power(const Quaternion<T>& q, const T& p) {
  using std::acos;
  using std::cos;
  using std::pow;
  using std::sin;
  using std::sqrt;
  const T length = norm(q);
  if (length == T(0)) return {p == T(0) ? T(1) : T(0), T(0), T(0), T(0)};
  const T imaginary = sqrt(T(q.b * q.b + q.c * q.c + q.d * q.d));
  T cosine = q.a / length;
  if (cosine > T(1)) cosine = T(1);
  if (cosine < T(-1)) cosine = T(-1);
  const T angle = p * acos(cosine);
  const T scale = pow(length, p);
  const T sine = scale * sin(angle);
  if (imaginary == T(0)) return {T(scale * cos(angle)), sine, T(0), T(0)};
  const T along = sine / imaginary;
  return {T(scale * cos(angle)), T(q.b * along), T(q.c * along), T(q.d * along)};
}

/// prod_i (q - root_i)^(scale power_i), left to right.
template <class T>
Quaternion<T> evaluate(const Polynomial& polynomial, const Quaternion<T>& q) {
  Quaternion<T> value = Quaternion<T>::one();
  for (const Root& root : polynomial.roots)
    value = value * power<T>(q - root.position.as<T>(), T(root.power) * T(polynomial.powerScale));
  return value;
}

/// [KD20] Eq. 2: whether the bottom polynomial's norm leaves no room for one more evaluation. T has
/// std::numeric_limits<T>::max_exponent10 decimal digits of exponent, 308 for double.
template <class T>
bool guardTrips(const T& bottomNorm, const T& bottomPowers) {
  using std::log10;
  const T digits = T(std::numeric_limits<T>::max_exponent10);
  const T room = digits - T(1.05) * (log10(bottomNorm) + bottomPowers);
  return !(log10(bottomNorm) < room);
}

/// f(q) of [Kim15] Eq. 2; empty if @a guard is true and the guard trips.
template <class T>
std::optional<Quaternion<T>> evaluate(const Rational& rational, const Quaternion<T>& q, bool guard) {
  using std::exp;
  const Quaternion<T> top = evaluate(rational.top, q) * T(exp(T(rational.logScale)));
  if (rational.bottom.roots.empty()) return top;
  const Quaternion<T> bottom = evaluate(rational.bottom, q);
  const T squared = normSquared(bottom);
  using std::sqrt;
  if (guard && guardTrips<T>(sqrt(squared), T(summedPowers(rational.bottom)))) return std::nullopt;
  return top * (conjugate(bottom) * T(T(1) / squared));
}

/// A map of the papers: takes q and returns f(q), or nothing if a guard trips.
template <class T>
using MapFunction = std::function<std::optional<Quaternion<T>>(const Quaternion<T>&)>;

template <class T>
MapFunction<T> rationalMap(Rational rational, bool guard = false) {
  return [rational = std::move(rational), guard](const Quaternion<T>& q) { return evaluate<T>(rational, q, guard); };
}

template <class T>
MapFunction<T> quadraticMap(const Quaternion<double>& c) {
  return [c = c.as<T>()](const Quaternion<T>& q) { return std::optional(q * q + c); };
}

/// [SK23] Eq. 3 with any map p as the versor and E given as a function of q; the versor of 0 is 1.
template <class T>
MapFunction<T> shapeModulus(std::function<T(const Quaternion<T>&)> exponent, MapFunction<T> versor) {
  return [exponent = std::move(exponent),
          versor = std::move(versor)](const Quaternion<T>& q) -> std::optional<Quaternion<T>> {
    using std::exp;
    const std::optional<Quaternion<T>> p = versor(q);
    if (!p) return std::nullopt;
    const T length = norm(*p);
    const T modulus = exp(exponent(q));
    if (length == T(0)) return Quaternion<T>{modulus, T(0), T(0), T(0)};
    return *p * T(modulus / length);
  };
}

template <class T>
MapFunction<T> shapeModulus(std::function<T(const Quaternion<T>&)> exponent, Rational versor, bool guard = false) {
  return shapeModulus<T>(std::move(exponent), rationalMap<T>(std::move(versor), guard));
}

template <class T>
struct Orbit {
  T logModulus = 0;  ///< ln|q_last|; +inf where a guard tripped, -inf where q_last = 0
  int iterations = 0;
  bool guarded = false;  ///< a guard tripped
};

template <class T>
Orbit<T> orbit(const MapFunction<T>& map, Quaternion<T> q, int maxIterations, const T& escapeRadius) {
  using std::log;
  Orbit<T> result;
  T length = norm(q);
  while (length < escapeRadius && result.iterations < maxIterations) {
    const std::optional<Quaternion<T>> next = map(q);
    ++result.iterations;
    if (!next) {
      result.guarded = true;
      result.logModulus = std::numeric_limits<T>::infinity();
      return result;
    }
    q = *next;
    length = norm(q);
  }
  result.logModulus = length == T(0) ? -std::numeric_limits<T>::infinity() : T(log(length));
  return result;
}

}  // namespace julia::reference
