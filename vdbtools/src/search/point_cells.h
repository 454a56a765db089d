// SPDX-License-Identifier: Apache-2.0
/// @file point_cells.h
/// Points sorted into the cells of a lattice, to find those within a distance.
#pragma once

#include "base/keyed_hash.h"

#include <openvdb/Types.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace vdbtools {

/// Many threads may search it while nothing is added.
class PointCells {
 public:
  /// @param reach   the maximum search distance
  /// @param origin  near the points; cells are counted from there
  PointCells(double reach, const openvdb::Vec3d& origin) : mReach(reach), mOrigin(origin) {}

  std::uint32_t add(const openvdb::Vec3d& p) {
    const auto number = static_cast<std::uint32_t>(mPoints.size());
    const auto [cell, isNew] = mFirst.try_emplace(cellOf(p), kNone);
    mPoints.push_back(p);
    mNext.push_back(cell->second);
    cell->second = number;
    return number;
  }

  std::size_t size() const { return mPoints.size(); }
  const openvdb::Vec3d& operator[](std::uint32_t i) const { return mPoints[i]; }

  /// Calls visit(number, squared distance) for the points nearer than @a within, at most the reach, until it returns
  /// false. @return whether it never did
  template <class Visit>
  bool forEachWithin(const openvdb::Vec3d& p, double within, const Visit& visit) const {
    const double square = within * within;
    const Cell low = cellOf(p - openvdb::Vec3d(within)), high = cellOf(p + openvdb::Vec3d(within));
    for (std::int64_t x = low[0]; x <= high[0]; ++x)
      for (std::int64_t y = low[1]; y <= high[1]; ++y)
        for (std::int64_t z = low[2]; z <= high[2]; ++z) {
          const auto cell = mFirst.find({x, y, z});
          if (cell == mFirst.end()) continue;
          for (std::uint32_t i = cell->second; i != kNone; i = mNext[i]) {
            const double distance = (mPoints[i] - p).lengthSqr();
            if (distance < square && !visit(i, distance)) return false;
          }
        }
    return true;
  }

  bool anyWithin(const openvdb::Vec3d& p, double within) const {
    return !forEachWithin(p, within, [](std::uint32_t, double) { return false; });
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  Cell cellOf(const openvdb::Vec3d& p) const {
    const auto at = [&](int axis) { return static_cast<std::int64_t>(std::floor((p[axis] - mOrigin[axis]) / mReach)); };
    return {at(0), at(1), at(2)};
  }

  double mReach;
  openvdb::Vec3d mOrigin;
  std::vector<openvdb::Vec3d> mPoints;
  std::vector<std::uint32_t> mNext;
  std::unordered_map<Cell, std::uint32_t, KeyedHash<3>> mFirst;
};

}  // namespace vdbtools
