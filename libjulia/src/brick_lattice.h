// SPDX-License-Identifier: Apache-2.0
/// @file brick_lattice.h
/// The placement of bricks, in the form for kernels.
#pragma once

#include "julia/bricks.h"

#include "kernels/kernels.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace julia {

/// Sets everything but the bricks themselves.
template <class Real>
void placeLattice(const BrickPlacement& placement, const std::array<std::uint32_t, 3>& count,
                  kernels::BrickLattice<Real>& lattice) {
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column)
      lattice.matrix[row][column] = static_cast<Real>(placement.matrix[row][column]);
    lattice.offset[row] = static_cast<Real>(placement.offset[row]);
    lattice.low[row] = static_cast<Real>(placement.low[row]);
    lattice.high[row] = static_cast<Real>(placement.high[row]);
    lattice.bricks[row] = count[row];
  }
  lattice.knee = static_cast<Real>(placement.knee.at);
  lattice.more = static_cast<Real>(placement.knee.more);
}

}  // namespace julia
