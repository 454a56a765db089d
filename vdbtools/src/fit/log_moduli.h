// SPDX-License-Identifier: Apache-2.0
/// @file log_moduli.h
/// L = ln|R| of points in the slice 0.
#pragma once

#include "julia/embedding.h"
#include "julia/rational.h"

#include <cstddef>
#include <span>

namespace vdbtools::fit {

/// @pre both spans have the same size
inline void logModuli(const julia::RationalEvaluator<float>& evaluator, std::span<const julia::Point> points,
                      std::span<float> l) {
  static thread_local julia::QuaternionBatch<float> q;
  q.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) q.set(i, julia::Embedding{}.quaternion<float>(points[i]));
  evaluator.logModulus(q, l);
}

}  // namespace vdbtools::fit
