// SPDX-License-Identifier: Apache-2.0
/// @file cartesian_bodies.h
/// The kernels of maps in Cartesian form; see kernel_bodies.h for what must not stand here.
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

template <class Real>
void quadratic(const Addend<Real>& c, ConstBatch<Real> points, Batch<Real> f, std::size_t size) {
  alignas(64) Row<Real> q[4], constant[4], square[4];
  for (std::size_t begin = 0; begin < size; begin += kBlock) {
    const Range range = blockAt(begin, size);
    const std::size_t padded = range.padded;
    for (int k = 0; k < 4; ++k) {
      load(points.component[k], q[k], range);
      loadComponent(c, k, constant[k], range);
    }
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

}  // namespace
}  // namespace julia::kernels
