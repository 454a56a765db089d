// SPDX-License-Identifier: Apache-2.0
/// @file crumbs.h
/// Crumbs: the pieces of a set that are too small to be kept by anyone. At any resolution an ordinary fractal has
/// hundreds or thousands of them, which together have less than a thousandth of its volume.
///
/// A crumb is an island (islands.h) whose nodes fit into a box of kCrumb nodes along each axis. Two kinds of small
/// islands are none: those that hold a node which the target decides by itself, such as a small part of the target, and
/// those at the border of what is known of the target, as they may belong to something larger.
///
/// Islands are here those of the whole lattice, also where a box, a window or a layer of blocks shows a part of it
/// only: F is evaluated beyond, as far as a small piece reaches. As a crumb is small, whether a node belongs to one
/// depends on the nodes within kCrumb of it. So crumbs are dropped in layers and tiles as they are in one run.
#pragma once

#include "vdbtools/base/grids.h"

#include <cstdint>
#include <limits>
#include <optional>

namespace vdbtools {

/// How many nodes the largest crumb has along an axis. With that many or fewer, a crumb that reaches into a block of
/// 8^3 nodes lies in that block and those next to it.
inline constexpr int kCrumb = 8;

/// Which crumbs a plan drops.
struct CrumbRule {
  /// E (exponent_grid.h), of a map that has a shell; or null.
  openvdb::FloatGrid::ConstPtr exponent{};
  /// No crumb has a node where E is this or less: the target alone decides that it is inside (julia/shell.h).
  double decided = -std::numeric_limits<double>::infinity();
  int longest = kCrumb;  ///< how many nodes a crumb has along an axis at most, 0 to kCrumb; 0: nothing is a crumb
  /// The nodes whose crumbs are counted; all of the domain unless they are given.
  std::optional<openvdb::CoordBBox> counted{};
};

/// What was dropped. Of tiles that share no node the reports add up to that of the whole.
struct CrumbReport {
  std::uint64_t crumbs = 0;  ///< whose first node, by (x, y, z), of those in the domain is counted
  std::uint64_t nodes = 0;   ///< that are counted, were inside, and no longer are

  CrumbReport& operator+=(const CrumbReport& other) {
    crumbs += other.crumbs;
    nodes += other.nodes;
    return *this;
  }
};

}  // namespace vdbtools
