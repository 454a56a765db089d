// SPDX-License-Identifier: Apache-2.0
/// @file rational_versor.h
/// The versor of a rational, p(q)/|p(q)| ([SK23] Eq. 2).
#pragma once

#include "julia/rational.h"
#include "julia/versor_field.h"

#include <any>
#include <span>

namespace julia {

/// The versor of a rational; the rational's C has no effect.
template <class Real>
class RationalVersor final : public VersorField<Real> {
 public:
  /// @throw std::invalid_argument  as requireFinite()
  explicit RationalVersor(const Rational& rational) : mRational(rational) {}

  void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const override { mRational.versor(q, u); }
  void cones(std::span<const Ball> balls, std::span<Cone> cones) const override { mRational.cones(balls, cones); }
  void logLeastParts(const QuaternionBatch<Real>& centres, Real radius, unsigned dropped,
                     std::span<Real> l) const override {
    mRational.logLeastParts(centres, radius, dropped, l);
  }
  /// Assumes that roots are about one unit away.
  double turning() const override { return mRational.powers(); }
  std::any describe() const override { return mRational.rational(); }

 private:
  RationalEvaluator<Real> mRational;
};

}  // namespace julia
