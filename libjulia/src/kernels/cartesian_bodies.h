// SPDX-License-Identifier: Apache-2.0
/// @file cartesian_bodies.h
/// The kernels of maps in Cartesian form; see kernel_bodies.h for the restrictions on this code.
#pragma once

#include "blocks.h"

namespace julia::kernels {
namespace {

template <class Real>
JULIA_INLINE void loadComponent(const Addend<Real>& from, int k, Row<Real>& to, const Range& range) {
  if (!from.forAll) return load(from.value.component[k], to, range);
  const Real value = *from.value.component[k];
  for (std::size_t i = 0; i < range.padded; ++i) to[i] = value;
}

/// Loads as many components of the points and of the addend as there are rows.
template <class Real, int N>
JULIA_INLINE void loadBoth(ConstBatch<Real> points, const Addend<Real>& c, Row<Real> (&p)[N], Row<Real> (&constant)[N],
                           const Range& range) {
  for (int k = 0; k < N; ++k) {
    load(points.component[k], p[k], range);
    loadComponent(c, k, constant[k], range);
  }
}

template <class Real>
void quadratic(const Addend<Real>& c, ConstBatch<Real> points, Batch<Real> f, std::size_t size) {
  alignas(64) Row<Real> q[4], constant[4], square[4];
  for (std::size_t begin = 0; begin < size; begin += kBlock) {
    const Range range = blockAt(begin, size);
    const std::size_t padded = range.padded;
    loadBoth(points, c, q, constant, range);
    JULIA_FOR_POINTS {
      const Real a = q[0][i], b = q[1][i], c2 = q[2][i], d = q[3][i];
      square[0][i] = a * a - (b * b + c2 * c2 + d * d) + constant[0][i];
      square[1][i] = 2 * (a * b) + constant[1][i];
      square[2][i] = 2 * (a * c2) + constant[2][i];
      square[3][i] = 2 * (a * d) + constant[3][i];
    }
    for (int k = 0; k < 4; ++k) store(square[k], f.component[k], range);
  }
}

template <class Real>
struct Vector {
  Real x, y, z;
};

/// The result of a step where the map is not defined: the orbit has escaped.
template <class Real>
constexpr Real kUndefined = __builtin_inff();

/// f = r^2 (-sin 2phi, cos 2phi, 0), g = (-+ sin 2theta / cos 2phi, 0, cos 2theta), where @a kSign 1 is the upper sign.
/// The product is the triplex square r^2 (cos 2phi cos 2theta, sin 2phi cos 2theta, +- sin 2theta), and for the lower
/// sign its mirror image in z. Not defined where cos 2phi = 0.
template <int kSign>
struct PairA {
  template <class Real>
  JULIA_INLINE Vector<Real> product(Real x, Real y, Real z) {
    const Real flat = magnitude(x) > magnitude(y) ? magnitude(x) : magnitude(y);
    const Real s = scaleToOne(flat), X = x * s, Y = y * s, across = X * X + Y * Y;
    const Real level = x * x + y * y;
    const Real cosine = level - z * z;  // r^2 cos 2theta
    const Real by = cosine / across, cross = X * X - Y * Y;
    const Real defined = across > 0 ? cross * by : cosine;
    return {cross != 0 || !(across > 0) ? defined : kUndefined<Real>, across > 0 ? 2 * (X * Y) * by : Real(0),
            kSign * 2 * (z * squareRoot(level))};
  }
  template <class Real>
  JULIA_INLINE Vector<Real> second(Real x, Real y, Real z) {
    const DoubleAngles<Real> angles = doubleAngles(x, y, z);
    return {angles.cos2phi != 0 ? -kSign * angles.sin2theta / angles.cos2phi : kUndefined<Real>, Real(0),
            angles.cos2theta};
  }
};

/// f = (1, 1, 1), g = (cos x, cos y, cos z).
struct PairB {
  template <class Real>
  JULIA_INLINE Vector<Real> product(Real x, Real y, Real z) {
    const Vector<Real> g = second(x, y, z);
    return {g.z - g.y, g.x - g.z, g.y - g.x};
  }
  template <class Real>
  JULIA_INLINE Vector<Real> second(Real x, Real y, Real z) {
    return {cosineOfRadians(x), cosineOfRadians(y), cosineOfRadians(z)};
  }
};

/// f = (x^2, y^2, z^2), g of B.
struct PairC {
  template <class Real>
  JULIA_INLINE Vector<Real> product(Real x, Real y, Real z) {
    const Vector<Real> g = second(x, y, z);
    const Real f1 = x * x, f2 = y * y, f3 = z * z;
    return {f2 * g.z - f3 * g.y, f3 * g.x - f1 * g.z, f1 * g.y - f2 * g.x};
  }
  template <class Real>
  JULIA_INLINE Vector<Real> second(Real x, Real y, Real z) {
    return PairB::second(x, y, z);
  }
};

/// f of A, g = (0, 0, 1): r^2 (cos 2phi, sin 2phi, 0). For z = 0 it equals the complex square bit for bit.
struct PairD {
  template <class Real>
  JULIA_INLINE Vector<Real> product(Real x, Real y, Real z) {
    const Real flat = magnitude(x) > magnitude(y) ? magnitude(x) : magnitude(y);
    const Real s = scaleToOne(flat), X = x * s, Y = y * s, across = X * X + Y * Y;
    const Real square = (x * x + y * y) + z * z, by = square / across;
    return {across > 0 ? (X * X - Y * Y) * by : square, across > 0 ? 2 * (X * Y) * by : Real(0), Real(0)};
  }
  template <class Real>
  JULIA_INLINE Vector<Real> second(Real, Real, Real) {
    return {Real(0), Real(0), Real(1)};
  }
};

/// f = (x^2 y, y^2, z^2), g = (1, cos z, 1).
struct PairE {
  template <class Real>
  JULIA_INLINE Vector<Real> product(Real x, Real y, Real z) {
    const Real cosine = cosineOfRadians(z), f1 = x * x * y, f2 = y * y, f3 = z * z;
    return {f2 - f3 * cosine, f3 - f1, f1 * cosine - f2};
  }
  template <class Real>
  JULIA_INLINE Vector<Real> second(Real, Real, Real z) {
    return {Real(1), cosineOfRadians(z), Real(1)};
  }
};

template <class Real>
JULIA_INLINE void storeVectors(const Row<Real> (&from)[3], Batch<Real> to, const Range& range) {
  for (int k = 0; k < 3; ++k) store(from[k], to.component[k], range);
  for (std::size_t i = 0; i < range.size; ++i) to.component[3][range.begin + i] = 0;
}

template <class Real, class Pair>
void cross(const Addend<Real>& c, ConstBatch<Real> points, Batch<Real> next, std::size_t size) {
  alignas(64) Row<Real> p[3], constant[3], value[3];
  for (std::size_t begin = 0; begin < size; begin += kBlock) {
    const Range range = blockAt(begin, size);
    const std::size_t padded = range.padded;
    loadBoth(points, c, p, constant, range);
    JULIA_FOR_POINTS {
      const Vector<Real> v = Pair::product(p[0][i], p[1][i], p[2][i]);
      value[0][i] = v.x + constant[0][i];
      value[1][i] = v.y + constant[1][i];
      value[2][i] = v.z + constant[2][i];
    }
    storeVectors(value, next, range);
  }
}

template <class Real, class Pair>
void crossSecond(ConstBatch<Real> points, Batch<Real> g, std::size_t size) {
  alignas(64) Row<Real> p[3], value[3];
  for (std::size_t begin = 0; begin < size; begin += kBlock) {
    const Range range = blockAt(begin, size);
    const std::size_t padded = range.padded;
    for (int k = 0; k < 3; ++k) load(points.component[k], p[k], range);
    JULIA_FOR_POINTS {
      const Vector<Real> v = Pair::second(p[0][i], p[1][i], p[2][i]);
      value[0][i] = v.x;
      value[1][i] = v.y;
      value[2][i] = v.z;
    }
    storeVectors(value, g, range);
  }
}

template <class Real>
void crossProduct(const Addend<Real>& c, ConstBatch<Real> first, ConstBatch<Real> second, Batch<Real> next,
                  std::size_t size) {
  alignas(64) Row<Real> f[3], g[3], constant[3], value[3];
  for (std::size_t begin = 0; begin < size; begin += kBlock) {
    const Range range = blockAt(begin, size);
    const std::size_t padded = range.padded;
    loadBoth(first, c, f, constant, range);
    for (int k = 0; k < 3; ++k) load(second.component[k], g[k], range);
    JULIA_FOR_POINTS {
      value[0][i] = f[1][i] * g[2][i] - f[2][i] * g[1][i] + constant[0][i];
      value[1][i] = f[2][i] * g[0][i] - f[0][i] * g[2][i] + constant[1][i];
      value[2][i] = f[0][i] * g[1][i] - f[1][i] * g[0][i] + constant[2][i];
    }
    storeVectors(value, next, range);
  }
}

/// (a + b i)^n by squaring, in place.
template <class Real>
JULIA_INLINE void complexPower(std::uint32_t n, Row<Real>& a, Row<Real>& b, std::size_t padded) {
  alignas(64) Row<Real> a1, b1;
  JULIA_FOR_POINTS {
    a1[i] = a[i];
    b1[i] = b[i];
  }
  for (int bit = 30 - __builtin_clz(n); bit >= 0; --bit) {
    JULIA_FOR_POINTS {
      const Real real = a[i] * a[i] - b[i] * b[i];
      b[i] = 2 * (a[i] * b[i]);
      a[i] = real;
    }
    if (n >> bit & 1) JULIA_FOR_POINTS {
        const Real real = a[i] * a1[i] - b[i] * b1[i];
        b[i] = a[i] * b1[i] + b[i] * a1[i];
        a[i] = real;
      }
  }
}

/// (a + b i)^p for real p and |a + b i| = 1, with an angle between -2 and 2 quadrants.
template <class Real>
JULIA_INLINE void unitPower(Real p, Row<Real>& a, Row<Real>& b, std::size_t padded) {
  // This close to the axis, the angle is effectively 0 or 2.
  constexpr Real kLeast = Real(1e-30);
  alignas(64) Row<Real> angle;
  JULIA_FOR_POINTS {
    const Real height = magnitude(b[i]);
    Real unused;
    const Real quadrants = angleInQuadrants(a[i], height > kLeast ? height : kLeast, unused);
    angle[i] = p * (b[i] < 0 ? -quadrants : quadrants);
  }
  JULIA_FOR_POINTS sineCosine(angle[i], b[i], a[i]);
}

/// r^p (cos p phi cos p theta, sin p phi cos p theta, sin p theta): a power of e^(i phi) times a power of r e^(i
/// theta).
template <class Real>
void triplex(const TriplexPower<Real>& power, const Addend<Real>& c, ConstBatch<Real> points, Batch<Real> next,
             std::size_t size) {
  using I = Ieee<Real>;
  alignas(64) Row<Real> p[3], constant[3], value[3], a, b, u, v, length;
  const bool fromPole = power.fromPole, products = power.integer != 0;
  const Real half = power.power * Real(0.5);
  const Real atZero = power.power > 0 ? Real(0) : power.power < 0 ? kUndefined<Real> : Real(1);
  for (std::size_t begin = 0; begin < size; begin += kBlock) {
    const Range range = blockAt(begin, size);
    const std::size_t padded = range.padded;
    loadBoth(points, c, p, constant, range);
    // u + i v = e^(i phi); a + i b = r e^(i theta), without r for powers that are not computed by products.
    JULIA_FOR_POINTS {
      const Real x = p[0][i], y = p[1][i];
      const Real flat = magnitude(x) > magnitude(y) ? magnitude(x) : magnitude(y);
      const Real s = scaleToOne(flat), X = x * s, Y = y * s, across = squareRoot(X * X + Y * Y);
      u[i] = across > 0 ? X / across : Real(1);
      v[i] = across > 0 ? Y / across : Real(0);
      a[i] = flat > 0 ? across / s : Real(0);
    }
    if (!products) JULIA_FOR_POINTS {
        const Real level = a[i], z = p[2][i], square = level * level + z * z;
        constexpr Real kLeast = I::kTiny;
        const Real l = half * logarithm(square > kLeast ? square : kLeast);
        const Real finite = exponential(l < I::kMostExponent ? l : I::kMostExponent);
        length[i] = square > 0 ? (l < I::kMostExponent ? finite : kUndefined<Real>) : atZero;
      }
    if (!products) JULIA_FOR_POINTS {
        const Real z = p[2][i], largest = a[i] > magnitude(z) ? a[i] : magnitude(z);
        const Real s = scaleToOne(largest), A = a[i] * s, Z = z * s, size1 = squareRoot(A * A + Z * Z);
        a[i] = size1 > 0 ? A / size1 : Real(1);
        b[i] = size1 > 0 ? Z / size1 : Real(0);
      }
    else
      JULIA_FOR_POINTS b[i] = p[2][i];
    Row<Real>&real = fromPole ? b : a, &imaginary = fromPole ? a : b;
    if (products) {
      complexPower(power.integer, u, v, padded);
      complexPower(power.integer, real, imaginary, padded);
    } else {
      unitPower(power.power, u, v, padded);
      unitPower(power.power, real, imaginary, padded);
      JULIA_FOR_POINTS {
        a[i] *= length[i];
        b[i] *= length[i];
      }
    }
    JULIA_FOR_POINTS {
      value[0][i] = a[i] * u[i] + constant[0][i];
      value[1][i] = a[i] * v[i] + constant[1][i];
      value[2][i] = b[i] + constant[2][i];
    }
    storeVectors(value, next, range);
  }
}

}  // namespace
}  // namespace julia::kernels
