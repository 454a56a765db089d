// SPDX-License-Identifier: Apache-2.0
/// @file quaternion_batch.h
/// Many quaternions, with one array for each component, which suits vector units.
#pragma once

#include "julia/quaternion.h"

#include <cstddef>
#include <vector>

namespace julia {

template <class Real>
struct QuaternionBatch {
  std::vector<Real> a, b, c, d;

  std::size_t size() const { return a.size(); }
  void resize(std::size_t n) {
    a.resize(n);
    b.resize(n);
    c.resize(n);
    d.resize(n);
  }
  Quaternion<Real> get(std::size_t i) const { return {a[i], b[i], c[i], d[i]}; }
  void set(std::size_t i, const Quaternion<Real>& q) {
    a[i] = q.a;
    b[i] = q.b;
    c[i] = q.c;
    d[i] = q.d;
  }
};

}  // namespace julia
