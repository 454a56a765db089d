// SPDX-License-Identifier: Apache-2.0
/// @file batch_view.h
/// Quaternion batches as the kernels take them.
#pragma once

#include "julia/quaternion_batch.h"

#include "kernels/kernels.h"

namespace julia {

template <class Real>
kernels::ConstBatch<Real> view(const QuaternionBatch<Real>& q) {
  return {{q.a.data(), q.b.data(), q.c.data(), q.d.data()}};
}

template <class Real>
kernels::Batch<Real> view(QuaternionBatch<Real>& q) {
  return {{q.a.data(), q.b.data(), q.c.data(), q.d.data()}};
}

}  // namespace julia
