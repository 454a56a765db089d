// SPDX-License-Identifier: Apache-2.0
/// @file norms.h
/// Logarithms of norms, and versors, of whole batches: computed by the kernels, or carefully where squares leave the
/// range.
#pragma once

#include "batch_view.h"
#include "careful.h"

#include <limits>
#include <span>

namespace julia {

template <class Real>
bool isNormal(const Quaternion<Real>& q) {
  const Real squared = normSquared(q);
  return squared >= kernels::Ieee<Real>::kTiny && squared <= std::numeric_limits<Real>::max();
}

/// l = ln|q|; -inf for q = 0, +inf if a component is not finite.
template <class Real>
void logNorms(const QuaternionBatch<Real>& q, std::span<Real> l) {
  if (!kernels::kernels<Real>().logNorm(view(q), l.data(), q.size())) return;
  for (std::size_t i = 0; i < q.size(); ++i)
    if (!isNormal(q.get(i))) l[i] = careful::logNorm(q.get(i));
}

/// u = q/|q|; 1 for q = 0, and if a component is not finite.
template <class Real>
void versorsOf(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) {
  u = q;
  kernels::kernels<Real>().normalise(view(u), u.size());
  for (std::size_t i = 0; i < q.size(); ++i)
    if (!isNormal(q.get(i))) u.set(i, careful::versorOf(q.get(i)));
}

}  // namespace julia
