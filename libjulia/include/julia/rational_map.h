// SPDX-License-Identifier: Apache-2.0
/// @file rational_map.h
/// The rational map of [Kim15] Eq. 2; see rational.h.
#pragma once

#include "julia/map.h"
#include "julia/rational.h"

namespace julia {

/// describe() returns the Rational.
template <class Real>
class RationalMap final : public Map<Real> {
 public:
  explicit RationalMap(const Rational& rational) : mRational(rational) {}

  void logModulus(const QuaternionBatch<Real>& q, std::span<Real> l) const override;
  void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const override;
  Real surfaceLevel(Real) const override { return 0; }
  MapDescription describe() const override { return mRational.rational(); }
  void logModulusRanges(std::span<const Ball> balls, std::span<LogRange> l) const override;
  void images(std::span<const Ball> balls, std::span<const LogRange> l,
              std::span<std::optional<Ball>> images) const override;

 private:
  RationalEvaluator<Real> mRational;
};

extern template class RationalMap<float>;
extern template class RationalMap<double>;

}  // namespace julia
