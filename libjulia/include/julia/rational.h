// SPDX-License-Identifier: Apache-2.0
/// @file rational.h
/// Quaternion rationals in factored form, [Kim15] Eq. 2:
///
///   f(q) = e^C prod_i (q - t_i)^(tau T_i)  [prod_i (q - b_i)^(beta B_i)]^-1
///
/// products ordered left to right; tau and beta are Polynomial::powerScale. A polynomial is a rational without bottom
/// roots. As a versor only its direction f/|f| is used ([SK23] Eq. 2), so there C has no effect.
#pragma once

#include "julia/ball.h"
#include "julia/log_polar.h"
#include "julia/quaternion.h"
#include "julia/quaternion_batch.h"

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace julia {

struct Root {
  Quaternion<double> position;  ///< units of the map's space
  double power = 1;

  friend bool operator==(const Root&, const Root&) = default;
};

struct Polynomial {
  std::vector<Root> roots;
  double powerScale = 1;  ///< multiplies every power: tau or beta

  friend bool operator==(const Polynomial&, const Polynomial&) = default;
};

struct Rational {
  double logScale = 0;  ///< C
  Polynomial top, bottom;

  friend bool operator==(const Rational&, const Rational&) = default;
};

/// Sum of powerScale times power.
double summedPowers(const Polynomial& polynomial);

/// Every root moved by @a offset.
Rational translated(Rational rational, const Quaternion<double>& offset);

/// Every root's position times @a factor (about the origin). @throw std::invalid_argument unless it is finite and not 0
Rational scaled(Rational rational, double factor);

/// The ordered product: tops after tops, bottoms after bottoms, the C added. Power scales that differ are multiplied
/// into the powers.
Rational product(const Rational& left, const Rational& right);

/// @throw std::invalid_argument naming the first number that is not finite
void requireFinite(const Rational& rational);

/// Where the versors over a ball may point: within an angle of an axis.
struct Cone {
  Quaternion<double> axis = Quaternion<double>::one();
  double quadrants = 2;  ///< the angle in quarter turns; 1 or more where nothing is known
};

/// A rational ready to be evaluated in @a Real. Where q hits roots exactly, their powers decide: a positive net power
/// gives l = -inf, a negative one +inf, and 0 (coincident top and bottom roots) cancels; the versor of a root that is
/// hit is 1. Evaluation is const and may run in many threads at once.
template <class Real>
class RationalEvaluator {
 public:
  /// @throw as requireFinite()
  explicit RationalEvaluator(const Rational& rational);

  /// Of many points at once, by the vector kernels. A point's result does not depend on the others.
  /// @pre l.size() == q.size(); @a u is resized
  void logModulus(const QuaternionBatch<Real>& q, std::span<Real> l) const;
  void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const;

  /// Of one point, slowly, and with care where squares would underflow.
  Real logModulus(const Quaternion<Real>& q) const;
  Quaternion<Real> versor(const Quaternion<Real>& q) const;
  LogPolar<Real> operator()(const Quaternion<Real>& q) const { return {logModulus(q), versor(q)}; }

  /// Bounds over balls of what logModulus() and versor() compute, rounding included. All spans have one size.
  void logModulusRanges(std::span<const Ball> balls, std::span<LogRange> l) const;
  void cones(std::span<const Ball> balls, std::span<Cone> cones) const;

  std::size_t rootCount() const;

 private:
  struct Factors;
  std::shared_ptr<const Factors> mFactors;
  /// Powers that do not fit floats are done in doubles.
  std::shared_ptr<const RationalEvaluator<double>> mWide;
};

extern template class RationalEvaluator<float>;
extern template class RationalEvaluator<double>;

}  // namespace julia
