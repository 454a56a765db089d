// SPDX-License-Identifier: Apache-2.0
/// @file blocks.h
/// What the kernels do at a point, in the shared text, and how they traverse their arrays: block by block. See
/// kernel_bodies.h for the restrictions on this code.
#pragma once

#include "elementary.h"
#include "kernels.h"
#include "loop_pragmas.h"

namespace julia::kernels {
namespace {

#include "shared/cartesian.h"
#include "shared/lattice.h"
#include "shared/rational.h"
#include "shared/waves.h"

// Points processed at once: all arrays of a block fit in the first-level cache.
constexpr std::size_t kBlock = 128;
// Blocks are padded to a multiple of the widest vector, so that no loop has a remainder.
constexpr std::size_t kWidest = 16;

template <class Real>
using Row = Real[kBlock];

// The points are independent, and the arrays of a block do not overlap.
#define JULIA_FOR_POINTS JULIA_INDEPENDENT for (std::size_t i = 0; i < padded / kWidest * kWidest; ++i)

struct Range {
  std::size_t begin, size, padded;
};

JULIA_INLINE Range blockAt(std::size_t begin, std::size_t size) {
  const std::size_t count = size - begin < kBlock ? size - begin : kBlock;
  return {begin, count, (count + kWidest - 1) / kWidest * kWidest};
}

/// Copies a block; the padding repeats its first entry.
template <class Real>
JULIA_INLINE void load(const Real* from, Row<Real>& to, const Range& range) {
  for (std::size_t i = 0; i < range.size; ++i) to[i] = from[range.begin + i];
  for (std::size_t i = range.size; i < range.padded; ++i) to[i] = from[range.begin];
}
template <class Real>
JULIA_INLINE void store(const Row<Real>& from, Real* to, const Range& range) {
  for (std::size_t i = 0; i < range.size; ++i) to[range.begin + i] = from[i];
}

}  // namespace
}  // namespace julia::kernels
