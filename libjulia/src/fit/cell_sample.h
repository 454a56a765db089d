// SPDX-License-Identifier: Apache-2.0
/// @file cell_sample.h
/// A sample of the cells of a fit that represents all of them in a weighted sum.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace julia {

/// sum f(i) d_i over all cells is approximated by sum f(cells[k]) weights[k].
struct CellSample {
  std::vector<std::size_t> cells;  ///< ascending
  std::vector<double> weights;     ///< positive
};

/// Systematic sampling with probabilities proportional to d: the cells with the largest d represent themselves, with
/// their d as the weight, and all other sampled cells share one weight. If d is distributed unevenly, this is far
/// closer to the sum over all cells than the same number of cells drawn uniformly. Cells with d = 0 are never sampled.
/// The cells must be in random order.
/// @param d     >= 0
/// @param most  the largest number of cells; if at most this many have d > 0, the sum is exact
CellSample sampleCells(std::span<const double> d, std::size_t most);

}  // namespace julia
