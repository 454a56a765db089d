// SPDX-License-Identifier: Apache-2.0
/// @file vector_versor.h
/// The versor of a vector field or of a field of quaternions, whose components are scalar fields, e.g. grids. The
/// components are interpolated first, and the result is normalised.
#pragma once

#include "julia/embedding.h"
#include "julia/scalar_field.h"
#include "julia/versor_field.h"

#include <any>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace julia {

/// What VectorVersor::describe() returns.
struct VectorVersorDescription {
  std::vector<std::optional<PlacedBricks>> components;  ///< each empty if its field does not describe itself
  DropAxis dropped = DropAxis::K;                       ///< the component of q at which they are not read
};

/// The versor is 1 where all components are 0.
template <class Real>
class VectorVersor final : public VersorField<Real> {
 public:
  /// @param components  three components of a vector in space, which becomes the quaternion whose dropped component is
  ///                    0, or the four components A, B, C and D. They are read at the three components of q that are
  ///                    not dropped
  /// @throw std::invalid_argument  another number of components
  VectorVersor(std::vector<std::shared_ptr<const ScalarField<Real>>> components, DropAxis dropped);

  void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const override;
  /// Computes cones from the ranges of the components, which form a box of quaternions.
  void cones(std::span<const Ball> balls, std::span<Cone> cones) const override;
  std::any describe() const override {
    VectorVersorDescription description{{}, mEmbedding.dropped};
    for (const auto& component : mComponents) description.components.push_back(component->describe());
    return description;
  }

 private:
  std::vector<std::shared_ptr<const ScalarField<Real>>> mComponents;
  std::vector<std::size_t> mPlaces;  ///< the place of each component among A, B, C and D
  Embedding mEmbedding;              ///< only its dropped axis is used
};

extern template class VectorVersor<float>;
extern template class VectorVersor<double>;

}  // namespace julia
