// SPDX-License-Identifier: Apache-2.0
/// @file versor_arithmetic.h
/// What versors that are made of others do at a point, by the text that devices share (kernels/shared/versors.h).
#pragma once

#include "kernels/elementary.h"

#include "julia/quaternion.h"

namespace julia {
namespace kernels {
namespace {
#include "kernels/shared/versors.h"
}  // namespace
}  // namespace kernels

/// The versor of @a q, even if its square is outside the range of Real; 1 if q is 0 or not finite.
template <class Real>
Quaternion<Real> directionOf(const Quaternion<Real>& q) {
  Quaternion<Real> u;
  kernels::makeDirection(q.a, q.b, q.c, q.d, &u.a, &u.b, &u.c, &u.d);
  return u;
}

}  // namespace julia
