// SPDX-License-Identifier: Apache-2.0
#include "base/disjoint_sets.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <cstdint>
#include <random>

namespace {

using vdbtools::DisjointSets;

/// A member of each of @a count classes mod @a count is joined to the next one of its class, in any order and by any
/// thread.
TEST(DisjointSets, AreNamedAfterTheirSmallestMember) {
  constexpr std::uint32_t kSize = 20000;
  for (const std::uint32_t count : {1u, 2u, 7u, kSize}) {
    SCOPED_TRACE(count);
    DisjointSets<std::uint32_t> sets(kSize);
    tbb::parallel_for(std::uint32_t{0}, kSize, [&](std::uint32_t i) {
      const std::uint32_t member = (i * 7919) % kSize;  // a permutation: 7919 is a prime
      if (member + count < kSize) sets.join(member + count, member);
    });
    for (std::uint32_t i = 0; i < kSize; ++i) ASSERT_EQ(sets.find(i), i % count);
  }
}

TEST(DisjointSets, AreAloneAtFirst) {
  DisjointSets<std::size_t> sets(3);
  EXPECT_EQ(sets.size(), 3u);
  sets.join(2, 2);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(sets.find(i), i);
  sets.join(2, 1);
  EXPECT_EQ(sets.find(2), 1u);
  EXPECT_EQ(sets.find(0), 0u);
}

}  // namespace
