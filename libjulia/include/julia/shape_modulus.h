// SPDX-License-Identifier: Apache-2.0
/// @file shape_modulus.h
/// The shape modulus of [SK23] Eqs. 2 and 3:
///
///   f(q) = e^E(q) p(q)/|p(q)|,   E = alpha (phi - beta)
///
/// E < 0 inside the target's shell and E > 0 outside. beta > 0 moves the shell outward, as in the paper's text and its
/// released program; its Eq. 2 prints the other sign. E is read at the three components of q that are not dropped.
#pragma once

#include "julia/embedding.h"
#include "julia/map.h"
#include "julia/rational.h"
#include "julia/scalar_field.h"
#include "julia/versor_field.h"

#include <any>
#include <memory>
#include <optional>

namespace julia {

/// What ShapeModulus::describe() returns.
struct ShapeModulusDescription {
  std::optional<PlacedBricks> exponent;  ///< E; empty if the exponent's field does not describe itself
  std::any versor;                       ///< as VersorField::describe(): a Rational p, whose logScale has no effect
  DropAxis dropped = DropAxis::K;        ///< the component of q at which E is not read
};

template <class Real>
class ShapeModulus final : public Map<Real> {
 public:
  ShapeModulus(std::shared_ptr<const ScalarField<Real>> exponent, std::shared_ptr<const VersorField<Real>> versor,
               DropAxis dropped);
  /// Takes the versor of a rational.
  ShapeModulus(std::shared_ptr<const ScalarField<Real>> exponent, const Rational& versor, DropAxis dropped);

  void logModulus(const QuaternionBatch<Real>& q, std::span<Real> l) const override;
  void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const override;
  Real surfaceLevel(Real) const override { return 0; }
  MapDescription describe() const override {
    return ShapeModulusDescription{mExponent->describe(), mVersor->describe(), mEmbedding.dropped};
  }
  void logModulusRanges(std::span<const Ball> balls, std::span<LogRange> l) const override;
  void images(std::span<const Ball> balls, std::span<const LogRange> l,
              std::span<std::optional<Ball>> images) const override;
  /// The proof rests on two facts: beyond some distance from the origin E is nowhere below @a wanted, and an image
  /// without its dropped component is e^l times as long as the versor without that component.
  double usefulRadius() const override { return mVersor->usefulRadius(); }
  typename Map<Real>::EscapeProof escapeProof(double wanted) const override;
  void escapeBounds(const QuaternionBatch<Real>& centres, Real radius, const typename Map<Real>::EscapeProof& proof,
                    std::span<Real> bounds) const override;

 private:
  std::shared_ptr<const ScalarField<Real>> mExponent;
  std::shared_ptr<const VersorField<Real>> mVersor;
  Embedding mEmbedding;  ///< only its dropped axis is used
};

extern template class ShapeModulus<float>;
extern template class ShapeModulus<double>;

}  // namespace julia
