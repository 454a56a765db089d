// SPDX-License-Identifier: Apache-2.0
/// @file vdb_tree.h
/// The tree of a grid of a VDB, as it is stored in the file: first the nodes from the root down, without the leaves'
/// values, and then these values.
#pragma once

#include "formats/vdb_values.h"

#include "vdbtools/base/grids.h"

#include <cstdint>
#include <string_view>
#include <vector>

namespace vdbtools {

/// What a leaf holds.
enum class VdbLeaf {
  Values,  ///< like internal nodes
  Bits,    ///< of a BoolTree
  Mask,    ///< of a MaskTree
  Points,  ///< of a PointDataTree, whose values are not read
};

/// Walks over a tree as OpenVDB reads it. Trees have the levels of all registered types: nodes of 32, 16 and 8 children
/// or values a side.
class VdbTreeWalk {
 public:
  /// All arguments must outlive the walk.
  VdbTreeWalk(VdbCursor& cursor, const VdbValueType& type, VdbLeaf leaf, const VdbStorage& storage);

  /// @throw DataError  OpenVDB cannot read this as a tree, or the tree is inconsistent: nodes that coincide, are out of
  ///                   order, or are at impossible places, or values where there are children
  void topology();
  /// Walks over the values of the leaves, after topology().
  /// @throw DataError  as VdbValueWalk::node()
  void buffers();

  /// Memory of the tree that topology() walked over, bytes.
  std::uint64_t memory() const { return mMemory; }

 private:
  openvdb::Coord origin();
  void upperNode(const openvdb::Coord& origin);
  void lowerNode(const openvdb::Coord& origin);
  /// Returns the mask of children, and walks over the mask of values and the values.
  std::string_view internalNode(int log2Dim);

  VdbCursor& mCursor;
  VdbLeaf mLeaf;
  VdbValueWalk mValues;
  std::size_t mValueSize;
  std::uint64_t mLeaves = 0, mMemory = 0;
  std::vector<openvdb::Coord> mOrigins;  // of the leaves whose buffers repeat them
};

}  // namespace vdbtools
