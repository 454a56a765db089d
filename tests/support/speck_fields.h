// SPDX-License-Identifier: Apache-2.0
/// @file speck_fields.h
/// Random fields that consist of islands of all sizes, and how large an island is.
#pragma once

#include "support/test_fields.h"
#include "vdbtools/base/monitor.h"

#include <algorithm>
#include <vector>

namespace test_fields {

/// Shows nothing and never stops.
inline vdbtools::Monitor monitor;

/// Below 0 with probability @a density, at each node by itself.
inline double speck(const Coord& node, double density, unsigned seed) { return noise(node, seed) + 1 - 2 * density; }

inline NodeEvaluator specks(double density, unsigned seed) {
  return NodeEvaluator([=](const Coord& node) { return speck(node, density, seed); });
}

inline openvdb::CoordBBox boxOf(const std::vector<Coord>& nodes) {
  openvdb::CoordBBox box;
  for (const Coord& node : nodes) box.expand(node);
  return box;
}

/// Of the nodes' box, in nodes.
inline int longestSide(const std::vector<Coord>& nodes) {
  const Coord sides = boxOf(nodes).dim();
  return std::max({sides[0], sides[1], sides[2]});
}

}  // namespace test_fields
