// SPDX-License-Identifier: Apache-2.0
/// @file crumbs.h
/// Crumbs: pieces of a set that are too small to be worth keeping. At any resolution an ordinary fractal has hundreds
/// or thousands of them, which together have less than a thousandth of its volume.
///
/// A crumb is an island (islands.h) whose nodes fit into a box of kCrumb nodes along each axis. Two kinds of small
/// islands are not crumbs: those with a node that the target decides by itself, such as a small part of the target, and
/// those at the border of the known part of the target, because they may belong to something larger.
///
/// Islands are found on the whole lattice, even if a box, a window or a layer of blocks shows only part of it: F is
/// also evaluated outside that part, as far as a small piece reaches. Whether a node belongs to a crumb depends only on
/// the nodes within kCrumb of it. Layers and tiles therefore drop the same crumbs as a single run.
#pragma once

#include "vdbtools/base/grids.h"

#include <cstdint>
#include <limits>
#include <optional>

namespace vdbtools {

/// The number of nodes along an axis of the largest crumb. At this size or below, a crumb that reaches into a block of
/// 8^3 nodes lies within that block and its neighbours.
inline constexpr int kCrumb = 8;

/// Which crumbs a plan drops.
struct CrumbRule {
  /// E (exponent_grid.h) if the map has a shell; otherwise null.
  openvdb::FloatGrid::ConstPtr exponent{};
  /// A crumb has no node where E is this or less: the target alone decides that such a node is inside (julia/shell.h).
  double decided = -std::numeric_limits<double>::infinity();
  int longest = kCrumb;  ///< the maximum number of nodes of a crumb along an axis, 0 to kCrumb; 0: nothing is a crumb
  /// The nodes whose crumbs are counted; by default the whole domain.
  std::optional<openvdb::CoordBBox> counted{};
};

/// The dropped crumbs. The reports of tiles that share no node add up to the report of a single run.
struct CrumbReport {
  std::uint64_t crumbs = 0;  ///< crumbs whose first counted node of the domain, by (x, y, z), lies here
  std::uint64_t nodes = 0;   ///< counted nodes that were inside and no longer are

  CrumbReport& operator+=(const CrumbReport& other) {
    crumbs += other.crumbs;
    nodes += other.nodes;
    return *this;
  }
};

}  // namespace vdbtools
