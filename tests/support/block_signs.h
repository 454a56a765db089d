// SPDX-License-Identifier: Apache-2.0
/// @file block_signs.h
/// Blocks of nodes beside the same nodes one by one.
#pragma once

#include "julia/evaluator.h"
#include "support/float128.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace law_tests {

/// How many nodes were evaluated, and how many of them were only said to be inside or outside.
struct BlockCount {
  int nodes = 0, inside = 0, outside = 0;

  BlockCount& operator+=(const BlockCount& other) {
    nodes += other.nodes;
    inside += other.inside;
    outside += other.outside;
    return *this;
  }
};

/// A block says F at its nodes or no more than the sign of F, and leaves alone what is not asked for.
/// @param spacing  of the nodes  @param what  for messages
inline BlockCount expectBlockSigns(const julia::FieldEvaluator& evaluator, Random& random, double spacing,
                                   const std::string& what) {
  using julia::NodeBlock;
  constexpr float kUntouched = -77;
  BlockCount count;
  std::vector<float> values(7 * NodeBlock::kSize, kUntouched);
  std::vector<NodeBlock> blocks;
  for (std::size_t i = 0; i < 7; ++i) {
    NodeBlock block{.field =
                        std::span<float, NodeBlock::kSize>(values.data() + i * NodeBlock::kSize, NodeBlock::kSize)};
    for (auto& at : block.at) {
      const double first = random.between(-0.6, 0.6);
      for (std::size_t k = 0; k < NodeBlock::kSide; ++k) at[k] = first + spacing * static_cast<double>(k);
    }
    if (i % 3 == 1) block.wanted = static_cast<std::uint8_t>(random.integer(0, 255));
    blocks.push_back(block);
  }
  evaluator.evaluateBlocks(blocks);
  std::vector<julia::Point> points;
  for (const NodeBlock& block : blocks)
    for (std::size_t k = 0; k < NodeBlock::kSize; ++k)
      points.push_back({block.at[0][k / 64], block.at[1][k / 8 % 8], block.at[2][k % 8]});
  std::vector<double> expected(points.size());
  evaluator.evaluate(points, expected, {});
  const auto limit = static_cast<float>(julia::kFieldLimit);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t k = i % NodeBlock::kSize;
    const bool wanted = blocks[i / NodeBlock::kSize].wanted >> (k / 256 * 4 + k / 32 % 2 * 2 + k / 4 % 2) & 1;
    const std::string where = text(points[i]) + " spacing " + std::to_string(spacing) + " " + what;
    if (!wanted) {
      EXPECT_EQ(values[i], kUntouched) << where;
      continue;
    }
    ++count.nodes;
    if (values[i] == limit) {
      ++count.outside;
      EXPECT_GE(expected[i], 0) << where;
    } else if (values[i] == -limit) {
      ++count.inside;
      EXPECT_LT(expected[i], 0) << where;
    } else {
      EXPECT_EQ(values[i], julia::storedField(expected[i])) << where;
    }
    if (testing::Test::HasFailure()) return count;
  }
  return count;
}

}  // namespace law_tests
