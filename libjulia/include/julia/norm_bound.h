// SPDX-License-Identifier: Apache-2.0
/// @file norm_bound.h
/// By how much a linear map stretches.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace julia {

/// An upper bound of the norm of a matrix M, which is given by its rows or by its columns. It is exact for
/// similarities: the norm of M M^T is at most its largest sum over a row.
inline double normBound(const std::array<std::array<double, 3>, 3>& rows) {
  double most = 0;
  for (const auto& row : rows) {
    double sum = 0;
    for (const auto& other : rows) {
      double dot = 0;
      for (std::size_t k = 0; k < 3; ++k) dot += row[k] * other[k];
      sum += std::abs(dot);
    }
    most = std::max(most, std::sqrt(sum));
  }
  return most;
}

}  // namespace julia
