// SPDX-License-Identifier: Apache-2.0
/// @file mixed_versor.h
/// Two versors, mixed by a scalar field m: the versor of (1 - m) u + m v. The mixture takes the short way from u to v,
/// so it is continuous except at the isolated points where it vanishes; there the versor is 1.
#pragma once

#include "julia/embedding.h"
#include "julia/scalar_field.h"
#include "julia/versor_field.h"

#include <any>
#include <memory>
#include <optional>
#include <span>

namespace julia {

/// What MixedVersor::describe() returns.
struct MixedVersorDescription {
  std::any under, over;             ///< as VersorField::describe() of u and v
  std::optional<PlacedBricks> mix;  ///< m; empty if its field does not describe itself
  DropAxis dropped = DropAxis::K;   ///< the component of q at which m is not read
};

/// Equals u bit for bit where m <= 0, and v where m >= 1.
template <class Real>
class MixedVersor final : public VersorField<Real> {
 public:
  /// @param mix  m, read at the three components of q that are not dropped
  MixedVersor(std::shared_ptr<const VersorField<Real>> under, std::shared_ptr<const VersorField<Real>> over,
              std::shared_ptr<const ScalarField<Real>> mix, DropAxis dropped);

  void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const override;
  /// Computes cones from the cones of both versors. If one of them is unknown, it uses the other, as long as m leaves
  /// little of the first.
  void cones(std::span<const Ball> balls, std::span<Cone> cones) const override;
  std::any describe() const override {
    return MixedVersorDescription{mUnder->describe(), mOver->describe(), mMix->describe(), mEmbedding.dropped};
  }

 private:
  std::shared_ptr<const VersorField<Real>> mUnder, mOver;
  std::shared_ptr<const ScalarField<Real>> mMix;
  Embedding mEmbedding;  ///< only its dropped axis is used
};

extern template class MixedVersor<float>;
extern template class MixedVersor<double>;

}  // namespace julia
