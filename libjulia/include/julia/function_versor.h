// SPDX-License-Identifier: Apache-2.0
/// @file function_versor.h
/// The versor of any function of the place: a formula, or a program's own. Nothing can be proved of it over balls.
#pragma once

#include "julia/quaternion.h"
#include "julia/versor_field.h"

#include <functional>
#include <span>

namespace julia {

/// directions[i] = a quaternion of any length at points[i]; where it is 0 or not finite there is no direction, and the
/// versor is 1. Both spans have one size. Called in many threads at once, with batches of any size; the same point must
/// always have the same direction. What it throws reaches whoever asked for the versors.
using DirectionFunction =
    std::function<void(std::span<const Quaternion<double>> points, std::span<Quaternion<double>> directions)>;

template <class Real>
class FunctionVersor final : public VersorField<Real> {
 public:
  explicit FunctionVersor(DirectionFunction function);

  void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const override;

 private:
  DirectionFunction mFunction;
};

extern template class FunctionVersor<float>;
extern template class FunctionVersor<double>;

}  // namespace julia
