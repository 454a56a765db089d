// SPDX-License-Identifier: Apache-2.0
/// @file disjoint_sets.h
/// Union-find for concurrent use by several threads.
#pragma once

#include <atomic>
#include <cstddef>
#include <utility>
#include <vector>

namespace vdbtools {

/// Disjoint sets of the numbers from 0 to size - 1, initially singletons. The smallest member names a set, so the name
/// does not depend on the order of the joins.
template <class Index>
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t size) : mParents(size) {
    for (std::size_t i = 0; i < size; ++i) mParents[i].store(static_cast<Index>(i), std::memory_order_relaxed);
  }

  std::size_t size() const { return mParents.size(); }

  /// The name of the set that @a member belongs to.
  Index find(Index member) {
    for (;;) {
      Index parent = mParents[member].load(std::memory_order_relaxed);
      const Index grandparent = mParents[parent].load(std::memory_order_relaxed);
      if (parent == grandparent) return parent;
      // Any ancestor is a valid parent; if another thread has stored a different one meanwhile, it stays.
      mParents[member].compare_exchange_weak(parent, grandparent, std::memory_order_relaxed);
      member = grandparent;
    }
  }

  void join(Index a, Index b) {
    for (;;) {
      a = find(a);
      b = find(b);
      if (a == b) return;
      if (a < b) std::swap(a, b);
      Index expected = a;  // if it is still a root
      if (mParents[a].compare_exchange_strong(expected, b, std::memory_order_relaxed)) return;
    }
  }

 private:
  std::vector<std::atomic<Index>> mParents;
};

}  // namespace vdbtools
