// SPDX-License-Identifier: Apache-2.0
/// @file mixed_versor.h
/// Two versors, mixed by a scalar field: the versor of (1 - m) u + m v. Where u and v differ the mix goes the short way
/// from the one to the other, so that it has no seam but at the isolated points where it vanishes, and its versor is 1.
#pragma once

#include "julia/embedding.h"
#include "julia/scalar_field.h"
#include "julia/versor_field.h"

#include <memory>
#include <span>

namespace julia {

/// Where m is 0 or less, it is u to the bit, and v where m is 1 or more.
template <class Real>
class MixedVersor final : public VersorField<Real> {
 public:
  /// @param mix  m, read at the three components of q that are not dropped
  MixedVersor(std::shared_ptr<const VersorField<Real>> under, std::shared_ptr<const VersorField<Real>> over,
              std::shared_ptr<const ScalarField<Real>> mix, DropAxis dropped);

  void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const override;
  /// From the cones of both; where one of them is not known, from the other, as long as m leaves little of the first.
  void cones(std::span<const Ball> balls, std::span<Cone> cones) const override;

 private:
  std::shared_ptr<const VersorField<Real>> mUnder, mOver;
  std::shared_ptr<const ScalarField<Real>> mMix;
  Embedding mEmbedding;  ///< for its dropped axis
};

extern template class MixedVersor<float>;
extern template class MixedVersor<double>;

}  // namespace julia
