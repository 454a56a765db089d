// SPDX-License-Identifier: Apache-2.0
/// @file cell_sample.h
/// Some cells of a fit that stand for all of them in a weighted sum.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace julia {

/// sum f(i) d_i over all cells is about sum f(cells[k]) weights[k].
struct CellSample {
  std::vector<std::size_t> cells;  ///< ascending
  std::vector<double> weights;     ///< positive
};

/// Systematic sampling with probabilities in proportion to d: the cells of the largest d stand for themselves, with
/// their d as the weight, and among the others those that are taken share one weight. Where d is spread unevenly, this
/// is far nearer to the sum over all cells than as many cells taken at random. Cells of d = 0 are never taken. The
/// cells must be in random order.
/// @param d     >= 0
/// @param most  the largest number of cells; where no more than these have a d above 0, the sum is exact
CellSample sampleCells(std::span<const double> d, std::size_t most);

}  // namespace julia
