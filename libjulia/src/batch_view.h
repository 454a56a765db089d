// SPDX-License-Identifier: Apache-2.0
/// @file batch_view.h
/// Views of quaternion batches for the kernels.
#pragma once

#include "julia/quaternion_batch.h"

#include "kernels/kernels.h"

#include <cstddef>

namespace julia {

/// The view begins at quaternion number @a first.
template <class Real>
kernels::ConstBatch<Real> view(const QuaternionBatch<Real>& q, std::size_t first = 0) {
  return {{q.a.data() + first, q.b.data() + first, q.c.data() + first, q.d.data() + first}};
}

template <class Real>
kernels::Batch<Real> view(QuaternionBatch<Real>& q, std::size_t first = 0) {
  return {{q.a.data() + first, q.b.data() + first, q.c.data() + first, q.d.data() + first}};
}

/// One addend for all points, or one for each.
template <class Real>
kernels::Addend<Real> addend(const Quaternion<Real>& c) {
  return {{{&c.a, &c.b, &c.c, &c.d}}, true};
}
template <class Real>
kernels::Addend<Real> addend(const QuaternionBatch<Real>& c) {
  return {view(c), false};
}

}  // namespace julia
