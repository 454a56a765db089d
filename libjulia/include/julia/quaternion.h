// SPDX-License-Identifier: Apache-2.0
/// @file quaternion.h
/// Quaternions q = [A B C D] = A + B i + C j + D k. Products are not commutative: in a * b, a is the left factor.
#pragma once

namespace julia {

template <class Real>
struct Quaternion {
  Real a{}, b{}, c{}, d{};

  static constexpr Quaternion one() { return {Real(1), Real(0), Real(0), Real(0)}; }

  template <class Other>
  constexpr Quaternion<Other> as() const {
    return {static_cast<Other>(a), static_cast<Other>(b), static_cast<Other>(c), static_cast<Other>(d)};
  }

  friend constexpr bool operator==(const Quaternion&, const Quaternion&) = default;
};

template <class Real>
constexpr Quaternion<Real> operator+(const Quaternion<Real>& p, const Quaternion<Real>& q) {
  return {p.a + q.a, p.b + q.b, p.c + q.c, p.d + q.d};
}

template <class Real>
constexpr Quaternion<Real> operator-(const Quaternion<Real>& p, const Quaternion<Real>& q) {
  return {p.a - q.a, p.b - q.b, p.c - q.c, p.d - q.d};
}

template <class Real>
constexpr Quaternion<Real> operator*(const Quaternion<Real>& q, Real s) {
  return {q.a * s, q.b * s, q.c * s, q.d * s};
}

/// Hamilton's product: i j = k, j k = i, k i = j.
template <class Real>
constexpr Quaternion<Real> operator*(const Quaternion<Real>& p, const Quaternion<Real>& q) {
  return {p.a * q.a - p.b * q.b - p.c * q.c - p.d * q.d,  //
          p.a * q.b + p.b * q.a + p.c * q.d - p.d * q.c,  //
          p.a * q.c - p.b * q.d + p.c * q.a + p.d * q.b,  //
          p.a * q.d + p.b * q.c - p.c * q.b + p.d * q.a};
}

template <class Real>
constexpr Quaternion<Real> conjugate(const Quaternion<Real>& q) {
  return {q.a, -q.b, -q.c, -q.d};
}

template <class Real>
constexpr Real normSquared(const Quaternion<Real>& q) {
  return q.a * q.a + q.b * q.b + q.c * q.c + q.d * q.d;
}

}  // namespace julia
