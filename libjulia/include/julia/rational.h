// SPDX-License-Identifier: Apache-2.0
/// @file rational.h
/// Quaternion rationals in factored form, [Kim15] Eq. 2:
///
///   f(q) = e^C prod_i (q - t_i)^(tau T_i)  [prod_i (q - b_i)^(beta B_i)]^-1
///
/// with products ordered left to right; tau and beta are Polynomial::powerScale. A polynomial is a rational without
/// bottom roots. Where a rational serves as a versor, only its direction f/|f| is used ([SK23] Eq. 2), and C has no
/// effect.
#pragma once

#include "julia/ball.h"
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

/// The sum of the powers, each times powerScale.
double summedPowers(const Polynomial& polynomial);

/// The rational with every root moved by @a offset.
Rational translated(Rational rational, const Quaternion<double>& offset);

/// The rational with the position of every root multiplied by @a factor.
/// @throw std::invalid_argument unless the factor is finite and not 0
Rational scaled(Rational rational, double factor);

/// The ordered product. Its top roots are those of @a left, then those of @a right; likewise its bottom roots. Its C is
/// the sum of both C. If power scales differ, they are multiplied into the powers.
Rational product(const Rational& left, const Rational& right);

/// @throw std::invalid_argument naming the first number that is not finite
void requireFinite(const Rational& rational);

/// A rational ready to be evaluated in the type Real. Where q equals roots exactly, the sum of their powers decides: a
/// positive sum gives l = -inf, a negative one +inf, and with a sum of 0 (coincident top and bottom roots) they cancel.
/// Roots equal to q contribute the versor 1. Evaluation is const and may run in many threads at once.
template <class Real>
class RationalEvaluator {
 public:
  /// @throw std::invalid_argument  as requireFinite()
  explicit RationalEvaluator(const Rational& rational);

  /// Evaluate many points at once, with the vector kernels. A point's result does not depend on the others.
  /// @pre l.size() == q.size(); u is resized
  void logModulus(const QuaternionBatch<Real>& q, std::span<Real> l) const;
  void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const;

  /// Evaluate one point, slowly, and carefully where squares would underflow.
  Real logModulus(const Quaternion<Real>& q) const;
  Quaternion<Real> versor(const Quaternion<Real>& q) const;

  /// Bounds over balls for what logModulus() and versor() compute, rounding included. All spans have the same size.
  void logModulusRanges(std::span<const Ball> balls, std::span<LogRange> l) const;
  void cones(std::span<const Ball> balls, std::span<Cone> cones) const;
  /// Sets l[i] to a lower bound of ln|v| over the ball of that radius about centre i, where v is what versor() computes
  /// without the component number @a dropped; -inf where nothing is known. It runs entirely in vector lanes and is
  /// therefore about ten times faster than a cone.
  void logLeastParts(const QuaternionBatch<Real>& centres, Real radius, unsigned dropped, std::span<Real> l) const;
  /// The sum of the magnitudes of all powers: over a small ball, versors turn by its radius times this sum divided by
  /// the distances to the roots.
  double powers() const;

  /// Roots of top and bottom whose power is not 0.
  std::size_t rootCount() const;
  /// The rational from which this was made.
  const Rational& rational() const;

 private:
  struct Factors;
  std::shared_ptr<const Factors> mFactors;
  /// Serves powers that are too large for floats.
  std::shared_ptr<const RationalEvaluator<double>> mWide;
};

extern template class RationalEvaluator<float>;
extern template class RationalEvaluator<double>;

}  // namespace julia
