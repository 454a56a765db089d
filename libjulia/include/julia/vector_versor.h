// SPDX-License-Identifier: Apache-2.0
/// @file vector_versor.h
/// The versor of a vector field or of a field of quaternions, whose components are scalar fields: grids, say. They are
/// interpolated first, and what comes out is brought to length 1.
#pragma once

#include "julia/embedding.h"
#include "julia/scalar_field.h"
#include "julia/versor_field.h"

#include <memory>
#include <span>
#include <vector>

namespace julia {

/// Where all components are 0 the versor is 1.
template <class Real>
class VectorVersor final : public VersorField<Real> {
 public:
  /// @param components  three: those of a vector in space, which becomes the quaternion whose dropped component is 0;
  ///                    or four: A, B, C and D. They are read at the three components of q that are not dropped
  /// @throw std::invalid_argument  another number of components
  VectorVersor(std::vector<std::shared_ptr<const ScalarField<Real>>> components, DropAxis dropped);

  void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const override;
  /// From the ranges of the components, which are a box of quaternions.
  void cones(std::span<const Ball> balls, std::span<Cone> cones) const override;

 private:
  std::vector<std::shared_ptr<const ScalarField<Real>>> mComponents;
  std::vector<std::size_t> mPlaces;  ///< of each, among A, B, C and D
  Embedding mEmbedding;              ///< for its dropped axis
};

extern template class VectorVersor<float>;
extern template class VectorVersor<double>;

}  // namespace julia
