// SPDX-License-Identifier: Apache-2.0
/// @file triangle_tree.h
/// Finds the nearest triangle of a mesh, for one position or for a block of nodes at once.
#pragma once

#include "search/kernels/triangle_kernels.h"
#include "search/triangle_bins.h"
#include "vdbtools/base/grids.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace vdbtools {

/// The triangles in the order of a space-filling curve (G. M. Morton, 1966), eight to a pack, under a tree of boxes.
/// The unit is a voxel: bounds are rounded for positions a few voxels from the nodes of a lattice.
class TriangleTree {
 public:
  /// When the frames of triangles are computed (kernels/triangle_lanes.h): for each block in which a triangle may be
  /// the nearest one; or once, which is faster and takes kFrameBytes for each triangle. The results have the same bits.
  enum class Frames { ForEachBlock, Once };
  static constexpr std::size_t kFrameBytes = sizeof(kernels::PackFrames) / kernels::kPack;

  /// Keeps references to points and triangles. Triangles need not be connected, and may be points or lines.
  /// @param about  where doubles should be finest: a node near the mesh, rounded to multiples of kOriginStep; by
  ///               default the middle of the mesh. With the same value, BlockDistances gives a node the same distance,
  ///               to the bit, whatever other triangles there are besides its nearest one.
  /// @pre there is a triangle, all coordinates are finite, and there are fewer than 2^31 triangles
  TriangleTree(const std::vector<openvdb::Vec3d>& points, const std::vector<openvdb::Vec3I>& triangles,
               std::optional<openvdb::Vec3d> about = {}, Frames frames = Frames::ForEachBlock);
  TriangleTree(const TriangleTree&) = delete;
  TriangleTree& operator=(const TriangleTree&) = delete;

  struct Nearest {
    std::uint32_t triangle = 0;
    openvdb::Vec3d point;  ///< on the triangle
    double distance = 0;
  };

  /// The nearest triangle, if one is at most @a within away. If distances differ only by the rounding of floats, it may
  /// be any of these triangles, but the same for every instruction set; the returned distance is exact up to the
  /// rounding of doubles.
  std::optional<Nearest> nearest(const openvdb::Vec3d& position, double within) const;

  /// Calls visit(triangle) for all triangles whose bounding box meets @a box, and possibly for others nearby.
  template <class Visit>
  void meeting(const openvdb::BBoxd& box, const Visit& visit) const;

  /// Calls visit(triangle) for all triangles that a ray meets, within @a slack, and possibly for others nearby.
  /// @param direction  no component is 0
  template <class Visit>
  void along(const openvdb::Vec3d& start, const openvdb::Vec3d& direction, double slack, const Visit& visit) const;

  const openvdb::BBoxd& box() const { return mBox; }
  const std::vector<openvdb::Vec3d>& points() const { return mPoints; }
  /// A node near the mesh. If a mesh and nodes are moved together by a multiple of kOriginStep nodes, the results at
  /// the nodes stay the same.
  const openvdb::Coord& origin() const { return mOrigin; }
  static constexpr int kOriginStep = 4096;
  static openvdb::Coord originNear(const openvdb::Vec3d& position);
  /// The points relative to that node.
  const std::vector<openvdb::Vec3d>& localPoints() const { return mMoved.empty() ? mPoints : mMoved; }
  const std::vector<openvdb::Vec3I>& triangles() const { return mTriangles; }
  Frames frames() const { return mFrames.empty() ? Frames::ForEachBlock : Frames::Once; }

 private:
  friend class BlockDistances;

  /// Visits the triangles for which meets(boxes) has a bit at their own boxes and at all packs and nodes above them.
  template <class Meets, class Visit>
  void walk(const Meets& meets, const Visit& visit) const;
  /// The boxes of a pack's triangles, in the form of the boxes of a node's children.
  kernels::BoxNode boxesOf(const kernels::TrianglePack& pack) const;

  const std::vector<openvdb::Vec3d>& mPoints;
  const std::vector<openvdb::Vec3I>& mTriangles;
  openvdb::Coord mOrigin;
  std::vector<openvdb::Vec3d> mMoved;
  openvdb::BBoxd mBox;
  std::vector<kernels::TrianglePack> mPacks;
  std::vector<kernels::PackNumbers> mNumbers;
  std::vector<kernels::PackFrames> mFrames;
  std::vector<std::vector<kernels::BoxNode>> mLevels;
  kernels::TreeView mView{};
};

template <class Meets, class Visit>
void TriangleTree::walk(const Meets& meets, const Visit& visit) const {
  using kernels::kPack;
  struct Open {
    std::size_t node, level;
  };
  Open stack[kPack * kernels::kMostLevels];
  unsigned size = 0;
  stack[size++] = {0, mLevels.size() - 1};
  while (size > 0) {
    const Open open = stack[--size];
    const std::size_t children = open.level > 0 ? mLevels[open.level - 1].size() : mNumbers.size();
    for (unsigned bits = meets(mLevels[open.level][open.node]); bits != 0; bits &= bits - 1) {
      const std::size_t child = kPack * open.node + static_cast<unsigned>(std::countr_zero(bits));
      if (child >= children) break;  // missing ones are far away, where a ray may arrive
      if (open.level > 0) {
        stack[size++] = {child, open.level - 1};
        continue;
      }
      const auto& numbers = mNumbers[child].triangle;
      for (unsigned lanes = meets(boxesOf(mPacks[child])); lanes != 0; lanes &= lanes - 1) {
        const auto k = static_cast<unsigned>(std::countr_zero(lanes));
        // The last pack is filled with copies of its first triangle.
        if (k == 0 || numbers[k] != numbers[0]) visit(numbers[k]);
      }
    }
  }
}

inline kernels::BoxNode TriangleTree::boxesOf(const kernels::TrianglePack& pack) const {
  kernels::BoxNode boxes;
  for (int axis = 0; axis < 3; ++axis) {
    const auto shift = static_cast<float>(pack.origin[axis] - mView.centre[axis]);
    for (unsigned k = 0; k < kernels::kPack; ++k) {
      const float a = pack.corner[0][axis][k], b = pack.corner[1][axis][k], c = pack.corner[2][axis][k];
      boxes.low[axis][k] = std::min(std::min(a, b), c) + shift;
      boxes.high[axis][k] = std::max(std::max(a, b), c) + shift;
    }
  }
  return boxes;
}

template <class Visit>
void TriangleTree::meeting(const openvdb::BBoxd& box, const Visit& visit) const {
  using kernels::kPack;
  float low[3], high[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double centre = mOrigin[axis] + mView.centre[axis];
    low[axis] = static_cast<float>(box.min()[axis] - centre) - 2 * mView.boxSlack;
    high[axis] = static_cast<float>(box.max()[axis] - centre) + 2 * mView.boxSlack;
  }
  walk(
      [&](const kernels::BoxNode& node) {
        // Loops over lanes become vectors.
        float apart[kPack] = {};
        for (int axis = 0; axis < 3; ++axis)
          for (unsigned k = 0; k < kPack; ++k)
            apart[k] = std::max(apart[k], std::max(node.low[axis][k] - high[axis], low[axis] - node.high[axis][k]));
        unsigned bits = 0;
        for (unsigned k = 0; k < kPack; ++k) bits |= (apart[k] <= 0 ? 1U : 0U) << k;
        return bits;
      },
      visit);
}

template <class Visit>
void TriangleTree::along(const openvdb::Vec3d& start, const openvdb::Vec3d& direction, double slack,
                         const Visit& visit) const {
  using kernels::kPack;
  // Floats err by less than the slack of boxes, which grows with the tree.
  const float wider = static_cast<float>(slack) + 4 * mView.boxSlack;
  float low[3], high[3], inverse[3];
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<float>(start[axis] - mOrigin[axis] - mView.centre[axis]);
    low[axis] = at + wider;
    high[axis] = at - wider;
    inverse[axis] = static_cast<float>(1 / direction[axis]);
  }
  walk(
      [&](const kernels::BoxNode& node) {
        float from[kPack], to[kPack];
        for (unsigned k = 0; k < kPack; ++k) {
          from[k] = -2 * wider;
          to[k] = std::numeric_limits<float>::infinity();
        }
        for (int axis = 0; axis < 3; ++axis)
          for (unsigned k = 0; k < kPack; ++k) {
            const float a = (node.low[axis][k] - low[axis]) * inverse[axis],
                        b = (node.high[axis][k] - high[axis]) * inverse[axis];
            from[k] = std::max(from[k], std::min(a, b));
            to[k] = std::min(to[k], std::max(a, b));
          }
        unsigned bits = 0;
        for (unsigned k = 0; k < kPack; ++k) bits |= (from[k] <= to[k] ? 1U : 0U) << k;
        return bits;
      },
      visit);
}

/// Finds the nearest triangles of the nodes of blocks. Each thread needs its own object.
class BlockDistances {
 public:
  static constexpr int kSide = 8;  ///< nodes along a block's side

  explicit BlockDistances(const TriangleTree& tree);
  /// Reads bins, which may change between two blocks.
  explicit BlockDistances(const TriangleBins& bins);

  /// The distance of a position, up to the rounding of floats, if it is at most @a within. Consecutive queries of
  /// nearby positions are cheap, as is evaluate() for a block whose middle was the last position. The last bits may
  /// depend on earlier queries.
  std::optional<float> distance(const openvdb::Vec3d& position, float within);

  /// Computes the nearest triangle and its distance at each node of the block that begins at @a origin, in the node
  /// order of a FloatTree's leaf. Nodes farther than @a far may keep an infinite distance.
  void evaluate(const openvdb::Coord& origin, float far);

  /// The same from some bins alone; the distances have the same bits if the nearest triangles are among them.
  /// @param nodes  of the bins
  /// @return whether any triangle may be within @a far; if not, nothing was computed
  bool evaluate(const openvdb::Coord& origin, float far, std::span<const std::uint32_t> nodes);

  const float* distances() const { return mDistances; }
  const std::uint32_t* triangles() const { return mTriangles; }

 private:
  void reserve(std::uint32_t packs);
  openvdb::Vec3d middleOf(const openvdb::Coord& origin) const;
  void resolve(const openvdb::Vec3d& middle, std::uint32_t packs, float far);

  const kernels::TreeView& mView;
  openvdb::Coord mOrigin;
  kernels::Place mLast{};                                            ///< the nearest triangle that was found last,
  openvdb::Vec3d mLastAt{std::numeric_limits<double>::quiet_NaN()};  ///< and where, relative to mOrigin
  std::vector<std::uint32_t> mPacks;
  std::vector<std::uint32_t> mLists;
  struct Release {
    void operator()(void* memory) const;
  };
  std::unique_ptr<void, Release> mMemory;
  kernels::Scratch mScratch{};
  alignas(64) float mDistances[kernels::kBlockNodes];
  alignas(64) std::uint32_t mTriangles[kernels::kBlockNodes];
};

}  // namespace vdbtools
