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
      Real a, b, c2, d;
      squareQuaternion(q[0][i], q[1][i], q[2][i], q[3][i], &a, &b, &c2, &d);
      square[0][i] = a + constant[0][i];
      square[1][i] = b + constant[1][i];
      square[2][i] = c2 + constant[2][i];
      square[3][i] = d + constant[3][i];
    }
    for (int k = 0; k < 4; ++k) store(square[k], f.component[k], range);
  }
}

/// The pairs of [ZB25], each with its product f x g and its g.
template <int kSign>
struct PairA {
  template <class Real>
  JULIA_INLINE void product(Real x, Real y, Real z, Real* px, Real* py, Real* pz) {
    productOfA(kSign, x, y, z, px, py, pz);
  }
  template <class Real>
  JULIA_INLINE void second(Real x, Real y, Real z, Real* gx, Real* gy, Real* gz) {
    secondOfA(kSign, x, y, z, gx, gy, gz);
  }
};
struct PairB {
  template <class Real>
  JULIA_INLINE void product(Real x, Real y, Real z, Real* px, Real* py, Real* pz) {
    productOfB(x, y, z, px, py, pz);
  }
  template <class Real>
  JULIA_INLINE void second(Real x, Real y, Real z, Real* gx, Real* gy, Real* gz) {
    secondOfB(x, y, z, gx, gy, gz);
  }
};
struct PairC : PairB {
  template <class Real>
  JULIA_INLINE void product(Real x, Real y, Real z, Real* px, Real* py, Real* pz) {
    productOfC(x, y, z, px, py, pz);
  }
};
struct PairD {
  template <class Real>
  JULIA_INLINE void product(Real x, Real y, Real z, Real* px, Real* py, Real* pz) {
    productOfD(x, y, z, px, py, pz);
  }
  template <class Real>
  JULIA_INLINE void second(Real, Real, Real, Real* gx, Real* gy, Real* gz) {
    *gx = *gy = Real(0);
    *gz = Real(1);
  }
};
struct PairE {
  template <class Real>
  JULIA_INLINE void product(Real x, Real y, Real z, Real* px, Real* py, Real* pz) {
    productOfE(x, y, z, px, py, pz);
  }
  template <class Real>
  JULIA_INLINE void second(Real, Real, Real z, Real* gx, Real* gy, Real* gz) {
    *gx = *gz = Real(1);
    *gy = cosineOfRadians(z);
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
      Real x, y, z;
      Pair::product(p[0][i], p[1][i], p[2][i], &x, &y, &z);
      value[0][i] = x + constant[0][i];
      value[1][i] = y + constant[1][i];
      value[2][i] = z + constant[2][i];
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
    JULIA_FOR_POINTS Pair::second(p[0][i], p[1][i], p[2][i], &value[0][i], &value[1][i], &value[2][i]);
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
      Real x, y, z;
      crossOf(f[0][i], f[1][i], f[2][i], g[0][i], g[1][i], g[2][i], &x, &y, &z);
      value[0][i] = x + constant[0][i];
      value[1][i] = y + constant[1][i];
      value[2][i] = z + constant[2][i];
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
    JULIA_FOR_POINTS squareComplex(&a[i], &b[i]);
    if (n >> bit & 1) JULIA_FOR_POINTS multiplyComplex(a1[i], b1[i], &a[i], &b[i]);
  }
}

/// (a + b i)^p for real p and |a + b i| = 1, with an angle between -2 and 2 quadrants.
template <class Real>
JULIA_INLINE void unitPower(Real p, Row<Real>& a, Row<Real>& b, std::size_t padded) {
  alignas(64) Row<Real> angle;
  JULIA_FOR_POINTS angle[i] = angleTimes(p, a[i], b[i]);
  JULIA_FOR_POINTS sineCosine(angle[i], &b[i], &a[i]);
}

/// r^p (cos p phi cos p theta, sin p phi cos p theta, sin p theta): a power of e^(i phi) times a power of r e^(i
/// theta).
template <class Real>
void triplex(const TriplexPower<Real>& power, const Addend<Real>& c, ConstBatch<Real> points, Batch<Real> next,
             std::size_t size) {
  alignas(64) Row<Real> p[3], constant[3], value[3], a, b, u, v, length;
  const bool fromPole = power.fromPole, products = power.integer != 0;
  const Real half = power.power * Real(0.5);
  const Real atZero = power.power > 0 ? Real(0) : power.power < 0 ? Real(__builtin_inff()) : Real(1);
  for (std::size_t begin = 0; begin < size; begin += kBlock) {
    const Range range = blockAt(begin, size);
    const std::size_t padded = range.padded;
    loadBoth(points, c, p, constant, range);
    // u + i v = e^(i phi); a + i b = r e^(i theta), without r for powers that are not computed by products.
    JULIA_FOR_POINTS azimuthOf(p[0][i], p[1][i], &u[i], &v[i], &a[i]);
    if (!products) JULIA_FOR_POINTS length[i] = powerOfRadius(half, atZero, a[i], p[2][i]);
    if (!products)
      JULIA_FOR_POINTS unitComplex(a[i], p[2][i], &a[i], &b[i]);
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
