// SPDX-License-Identifier: Apache-2.0
/// @file node_cubes.h
/// The nodes of a block (evaluator.h), grouped into cubes of kSide nodes a side, which are numbered like nodes.
#pragma once

#include "julia/evaluator.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

namespace julia {

template <class Real, std::size_t kSide>
struct NodeCubes {
  static constexpr std::size_t kAcross = NodeBlock::kSide / kSide, kCount = kAcross * kAcross * kAcross;

  /// Sets least[cube] and most[cube] to the extremes of the values between @a low and @a high, or to +inf and -inf.
  static void findExtremes(const Real* values, Real low, Real high, Real* least, Real* most) {
    constexpr Real kNone = std::numeric_limits<Real>::infinity();
    forEachColumn([&](std::size_t cube, std::size_t first) {
      std::array<Real, NodeBlock::kSide> smallest, largest;
      smallest.fill(kNone);
      largest.fill(-kNone);
      forEachRow(first, [&](std::size_t node) {
        for (std::size_t z = 0; z < NodeBlock::kSide; ++z) {
          const Real value = values[node + z];
          const bool isBetween = (value > low) & (value < high);
          const Real up = isBetween ? value : kNone, down = isBetween ? value : -kNone;
          smallest[z] = up < smallest[z] ? up : smallest[z];
          largest[z] = down > largest[z] ? down : largest[z];
        }
      });
      for (std::size_t c = 0; c < kAcross; ++c) {
        const auto begin = static_cast<std::ptrdiff_t>(c * kSide), end = begin + static_cast<std::ptrdiff_t>(kSide);
        least[cube + c] = *std::min_element(smallest.begin() + begin, smallest.begin() + end);
        most[cube + c] = *std::max_element(largest.begin() + begin, largest.begin() + end);
      }
    });
  }

  /// Replaces values between @a low and @a high by the values of their cubes, unless these are 0.
  static void replace(Real* values, Real low, Real high, const Real* byCube) {
    forEachColumn([&](std::size_t cube, std::size_t first) {
      std::array<Real, NodeBlock::kSide> column;
      for (std::size_t z = 0; z < NodeBlock::kSide; ++z) column[z] = byCube[cube + z / kSide];
      forEachRow(first, [&](std::size_t node) {
        for (std::size_t z = 0; z < NodeBlock::kSide; ++z) {
          const Real value = values[node + z];
          const bool isReplaced = (value > low) & (value < high) & (column[z] != 0);
          values[node + z] = isReplaced ? column[z] : value;
        }
      });
    });
  }

  /// Sets most[cube] to the largest of the values below @a limit, or to -inf.
  static void findMost(const Real* values, Real limit, Real* most) {
    constexpr Real kNone = -std::numeric_limits<Real>::infinity();
    forEachColumn([&](std::size_t cube, std::size_t first) {
      std::array<Real, NodeBlock::kSide> column;
      column.fill(kNone);
      forEachRow(first, [&](std::size_t node) {
        for (std::size_t z = 0; z < NodeBlock::kSide; ++z) {
          const Real value = values[node + z] < limit ? values[node + z] : kNone;
          column[z] = value > column[z] ? value : column[z];
        }
      });
      for (std::size_t c = 0; c < kAcross; ++c) {
        most[cube + c] = column[c * kSide];
        for (std::size_t k = 1; k < kSide; ++k)
          most[cube + c] = column[c * kSide + k] > most[cube + c] ? column[c * kSide + k] : most[cube + c];
      }
    });
  }

  /// Raises values that reach their cube's bound to +inf.
  static void raise(Real* values, const Real* bounds) {
    constexpr Real kRaised = std::numeric_limits<Real>::infinity();
    forEachColumn([&](std::size_t cube, std::size_t first) {
      std::array<Real, NodeBlock::kSide> column;
      for (std::size_t z = 0; z < NodeBlock::kSide; ++z) column[z] = bounds[cube + z / kSide];
      forEachRow(first, [&](std::size_t node) {
        for (std::size_t z = 0; z < NodeBlock::kSide; ++z)
          values[node + z] = values[node + z] >= column[z] ? kRaised : values[node + z];
      });
    });
  }

 private:
  /// Calls body(number of the first cube, first node) for the columns of cubes along z.
  template <class Body>
  static void forEachColumn(const Body& body) {
    for (std::size_t x = 0; x < kAcross; ++x)
      for (std::size_t y = 0; y < kAcross; ++y)
        body((x * kAcross + y) * kAcross, (x * NodeBlock::kSide + y) * kSide * NodeBlock::kSide);
  }
  /// Calls body(first node) for the rows of a column.
  template <class Body>
  static void forEachRow(std::size_t first, const Body& body) {
    for (std::size_t x = 0; x < kSide; ++x)
      for (std::size_t y = 0; y < kSide; ++y) body(first + (x * NodeBlock::kSide + y) * NodeBlock::kSide);
  }
};

}  // namespace julia
