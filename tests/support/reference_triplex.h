// SPDX-License-Identifier: Apache-2.0
/// @file reference_triplex.h
/// The slow evaluator of reference.h for the maps of R^3 in cross_map.h and mandelbulb.h, with the angles of [ZB25] Eq.
/// 1 and trigonometry, as in the paper. T is as in reference.h and also has asin and atan2.
#pragma once

#include "julia/cross_map.h"
#include "julia/mandelbulb.h"
#include "support/reference.h"

#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <stdexcept>
#include <utility>

namespace julia::reference {

template <class T>
using Vector = std::array<T, 3>;

template <class T>
struct Spherical {
  T r, phi, theta;
};

/// [ZB25] Eq. 1; angles that are not defined are 0.
template <class T>
Spherical<T> spherical(const Vector<T>& p) {
  using std::asin;
  using std::atan2;
  using std::sqrt;
  const auto& [x, y, z] = p;
  const T r = sqrt(T(x * x + y * y + z * z));
  if (r == T(0)) return {r, T(0), T(0)};
  T sine = z / r;
  if (sine > T(1)) sine = T(1);
  if (sine < T(-1)) sine = T(-1);
  return {r, x == T(0) && y == T(0) ? T(0) : T(atan2(y, x)), T(asin(sine))};
}

/// p^n for r > 0 or n > 0. The angle from the pole is 0 for [0 0 1].
template <class T>
Vector<T> triplexPower(const Vector<T>& p, const T& n, TriplexAngle angle) {
  using std::acos;
  using std::cos;
  using std::pow;
  using std::sin;
  const auto [r, phi, theta] = spherical(p);
  if (r == T(0)) return {T(0), T(0), T(0)};
  const T length = pow(r, n);
  if (angle == TriplexAngle::AbovePlane)
    return {T(length * cos(n * phi) * cos(n * theta)), T(length * sin(n * phi) * cos(n * theta)),
            T(length * sin(n * theta))};
  const T fromPole = acos(T(0)) - theta;
  return {T(length * cos(n * phi) * sin(n * fromPole)), T(length * sin(n * phi) * sin(n * fromPole)),
          T(length * cos(n * fromPole))};
}

template <class T>
Vector<T> cross(const Vector<T>& u, const Vector<T>& v) {
  return {T(u[1] * v[2] - u[2] * v[1]), T(u[2] * v[0] - u[0] * v[2]), T(u[0] * v[1] - u[1] * v[0])};
}

/// A function of R^3; it returns nothing where it is not defined.
template <class T>
using VectorFunction = std::function<std::optional<Vector<T>>(const Vector<T>&)>;

template <class T>
struct FunctionPair {
  VectorFunction<T> f, g;
};

/// The pairs of [ZB25]. @throw std::invalid_argument for the pair User
template <class T>
FunctionPair<T> functionPair(CrossPair pair) {
  using std::cos;
  using std::sin;
  const VectorFunction<T> square = [](const Vector<T>& p) {
    const auto [r, phi, theta] = spherical(p);
    return Vector<T>{T(-r * r * sin(2 * phi)), T(r * r * cos(2 * phi)), T(0)};
  };
  const VectorFunction<T> cosines = [](const Vector<T>& p) {
    return Vector<T>{T(cos(p[0])), T(cos(p[1])), T(cos(p[2]))};
  };
  const auto second = [](int sign) -> VectorFunction<T> {
    return [sign](const Vector<T>& p) -> std::optional<Vector<T>> {
      const auto [r, phi, theta] = spherical(p);
      // Here cos 2phi = 0, which no rounded phi gives exactly.
      if ((p[0] == p[1] || p[0] == -p[1]) && p[0] != T(0)) return std::nullopt;
      return Vector<T>{T(sign * sin(2 * theta) / cos(2 * phi)), T(0), T(cos(2 * theta))};
    };
  };
  switch (pair) {
    case CrossPair::A: return {square, second(-1)};
    case CrossPair::APrime: return {square, second(1)};
    case CrossPair::B: return {[](const Vector<T>&) { return Vector<T>{T(1), T(1), T(1)}; }, cosines};
    case CrossPair::C:
      return {[](const Vector<T>& p) { return Vector<T>{T(p[0] * p[0]), T(p[1] * p[1]), T(p[2] * p[2])}; }, cosines};
    case CrossPair::D: return {square, [](const Vector<T>&) { return Vector<T>{T(0), T(0), T(1)}; }};
    case CrossPair::E:
      return {[](const Vector<T>& p) {
                return Vector<T>{T(p[0] * p[0] * p[1]), T(p[1] * p[1]), T(p[2] * p[2])};
              },
              [](const Vector<T>& p) {
                return Vector<T>{T(1), T(cos(p[2])), T(1)};
              }};
    case CrossPair::User: break;
  }
  throw std::invalid_argument("the pair User has no functions of its own");
}

/// One orbit's step: takes p and whether this is the first step, and returns the next iterate.
template <class T>
using VectorStep = std::function<std::optional<Vector<T>>(const Vector<T>& p, bool first)>;

/// Schemes (3), (4) and (5) for the orbit of @a start.
template <class T>
VectorStep<T> crossStep(const FunctionPair<T>& pair, CrossScheme scheme, const Vector<T>& start,
                        const Vector<T>& constant) {
  const auto product = [](const std::optional<Vector<T>>& f, const std::optional<Vector<T>>& g) {
    return f && g ? std::optional(cross(*f, *g)) : std::nullopt;
  };
  return [=](const Vector<T>& p, bool first) -> std::optional<Vector<T>> {
    if (scheme == CrossScheme::FixedFactor) return product(first ? pair.f(start) : std::optional(p), pair.g(start));
    std::optional<Vector<T>> next = product(pair.f(p), pair.g(p));
    const Vector<T>& c = scheme == CrossScheme::Mandelbrot ? start : constant;
    if (next)
      for (std::size_t k = 0; k < 3; ++k) (*next)[k] += c[k];
    return next;
  };
}

template <class T>
VectorStep<T> mandelbulbStep(const MandelbulbOptions& options, const Vector<T>& start) {
  Vector<T> c = start;
  if (options.constant)
    for (std::size_t k = 0; k < 3; ++k) c[k] = T((*options.constant)[k]);
  return [=](const Vector<T>& p, bool) -> std::optional<Vector<T>> {
    Vector<T> next = triplexPower(p, T(options.power), options.angle);
    for (std::size_t k = 0; k < 3; ++k) next[k] += c[k];
    return next;
  };
}

template <class T>
Orbit<T> orbit(const VectorStep<T>& step, const Vector<T>& start, int maxIterations, const T& escapeRadius) {
  bool first = true;
  const MapFunction<T> map = [&](const Quaternion<T>& q) -> std::optional<Quaternion<T>> {
    const std::optional<Vector<T>> next = step({q.a, q.b, q.c}, std::exchange(first, false));
    if (!next) return std::nullopt;
    return Quaternion<T>{(*next)[0], (*next)[1], (*next)[2], T(0)};
  };
  return orbit<T>(map, {start[0], start[1], start[2], T(0)}, maxIterations, escapeRadius);
}

}  // namespace julia::reference
