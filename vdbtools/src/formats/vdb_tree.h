// SPDX-License-Identifier: Apache-2.0
/// @file vdb_tree.h
/// The tree of a grid of a VDB, as it lies in the file: first the nodes from the root down, without the leaves' values;
/// then these.
#pragma once

#include "formats/vdb_values.h"

#include "vdbtools/base/grids.h"

#include <cstdint>
#include <string_view>
#include <vector>

namespace vdbtools {

/// What a leaf holds.
enum class VdbLeaf {
  Values,  ///< as internal nodes do
  Bits,    ///< of a BoolTree
  Mask,    ///< of a MaskTree
  Points,  ///< of a PointDataTree, whose values are not read
};

/// Walks over a tree as OpenVDB reads it. Trees have the levels that all registered types have: nodes of 32, 16 and 8
/// children or values a side.
class VdbTreeWalk {
 public:
  /// All must outlive the walk.
  VdbTreeWalk(VdbCursor& cursor, const VdbValueType& type, VdbLeaf leaf, const VdbStorage& storage);

  /// @throw DataError  OpenVDB cannot read this as a tree, or the tree breaks its laws: nodes at one place or out of
  ///                   order, at places where there can be none, or values where there are children
  void topology();
  /// The values of the leaves, after topology().
  /// @throw DataError  as VdbValueWalk::node()
  void buffers();

  /// Of the tree that topology() walked over, bytes.
  std::uint64_t memory() const { return mMemory; }

 private:
  openvdb::Coord origin();
  void upperNode(const openvdb::Coord& origin);
  void lowerNode(const openvdb::Coord& origin);
  /// The mask of children; the one of values, and the values, are walked over.
  std::string_view internalNode(int log2Dim);

  VdbCursor& mCursor;
  VdbLeaf mLeaf;
  VdbValueWalk mValues;
  std::size_t mValueSize;
  std::uint64_t mLeaves = 0, mMemory = 0;
  std::vector<openvdb::Coord> mOrigins;  // of the leaves whose buffers repeat them
};

}  // namespace vdbtools
