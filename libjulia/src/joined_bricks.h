// SPDX-License-Identifier: Apache-2.0
/// @file joined_bricks.h
/// Fields on one lattice that are read together: a copy of their bricks in which the values of a node lie side by side.
#pragma once

#include "julia/bricks.h"
#include "julia/scalar_field.h"

#include "kernels/kernels.h"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace julia {

template <class Real>
class JoinedBricks {
 public:
  using Fields = std::array<std::shared_ptr<const ScalarField<Real>>, kernels::kJoinedFields>;

  /// @return null if some field is not read trilinearly from bricks, or two lie on different lattices
  static std::unique_ptr<const JoinedBricks> of(const Fields& fields);

  /// The bits of each field's own sample(). @param out  a row for each field
  void sample(std::span<const Real> x, std::span<const Real> y, std::span<const Real> z, Real* const* out) const;

 private:
  explicit JoinedBricks(const std::array<PlacedBricks, kernels::kJoinedFields>& fields);

  std::vector<std::uint32_t> mBrickAt;
  std::vector<float> mValues;
  kernels::BrickLattice<Real> mLattice;
};

extern template class JoinedBricks<float>;
extern template class JoinedBricks<double>;

}  // namespace julia
