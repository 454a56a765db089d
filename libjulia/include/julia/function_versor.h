// SPDX-License-Identifier: Apache-2.0
/// @file function_versor.h
/// The versor of an arbitrary function of position: a formula, or a function of the calling program. No bounds over
/// balls can be proved for it.
#pragma once

#include "julia/quaternion.h"
#include "julia/versor_field.h"

#include <functional>
#include <span>

namespace julia {

/// Sets directions[i] to a quaternion of any length for points[i]; where it is 0 or not finite there is no direction,
/// and the versor is 1. Both spans have the same size. Many threads may call the function at once, with batches of any
/// size; the same point must always get the same direction. Exceptions reach whoever asked for the versors.
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
