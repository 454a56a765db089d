// SPDX-License-Identifier: Apache-2.0
/// @file position_table.h
/// Finds points with the same position.
#pragma once

#include "base/keyed_hash.h"

#include <openvdb/Types.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace vdbtools {

/// Numbers positions in the order of their first occurrence. The number of comparisons is linear in the number of
/// points, whatever file they come from (KeyedHash).
class PositionTable {
 public:
  /// @param places  receives new positions; must outlive this object
  /// @param most    the maximum number of positions
  PositionTable(std::vector<openvdb::Vec3d>& places, std::size_t most)
      : mPlaces(places), mLast(std::bit_ceil(std::max<std::size_t>(most, 1)), kNone) {
    mPlaces.reserve(most);
    mBefore.reserve(most);
  }

  std::uint32_t numberOf(const openvdb::Vec3d& p) {
    // + 0.0 turns -0 into 0.
    const std::array bits = {std::bit_cast<std::uint64_t>(p[0] + 0.0), std::bit_cast<std::uint64_t>(p[1] + 0.0),
                             std::bit_cast<std::uint64_t>(p[2] + 0.0)};
    std::uint32_t& last = mLast[mHash(bits) & (mLast.size() - 1)];
    for (std::uint32_t number = last; number != kNone; number = mBefore[number]) {
      ++mComparisons;
      if (samePosition(mPlaces[number], p)) return number;
    }
    mBefore.push_back(last);
    last = static_cast<std::uint32_t>(mPlaces.size());
    mPlaces.push_back(p);
    return last;
  }

  /// The number of pairs of points compared so far.
  std::uint64_t comparisons() const { return mComparisons; }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  static bool samePosition(const openvdb::Vec3d& a, const openvdb::Vec3d& b) {
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];  // equals Vec3d::operator==, which causes a warning
  }

  std::vector<openvdb::Vec3d>& mPlaces;
  KeyedHash<3> mHash;
  std::vector<std::uint32_t> mLast;    ///< the last position with each hash
  std::vector<std::uint32_t> mBefore;  ///< for each position, the previous one with the same hash
  std::uint64_t mComparisons = 0;
};

}  // namespace vdbtools
