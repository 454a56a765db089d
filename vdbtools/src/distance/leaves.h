// SPDX-License-Identifier: Apache-2.0
/// @file leaves.h
/// The leaves of a tree, and parallel loops over them.
#pragma once

#include "base/in_parallel.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"

#include <cstddef>
#include <vector>

namespace vdbtools {

inline std::vector<const openvdb::FloatTree::LeafNodeType*> leavesOf(const openvdb::FloatTree& tree) {
  std::vector<const openvdb::FloatTree::LeafNodeType*> leaves;
  leaves.reserve(tree.leafCount());
  tree.getNodes(leaves);
  return leaves;
}

/// Runs body(i) for every i below count, in threads, and advances the monitor by count.
/// @throw Interrupted
template <class Body>
void forEachLeaf(std::size_t count, Monitor& monitor, const Body& body) {
  inParallel(count, 16, monitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i != end; ++i) body(i);
    monitor.advance(end - begin);
  });
}

}  // namespace vdbtools
