// SPDX-License-Identifier: Apache-2.0
/// @file triangle_bins.h
/// The triangles of a mesh whose cells arrive in layers, in bins: one for each block of nodes.
#pragma once

#include "search/kernels/triangle_kernels.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"

#include <cstdint>
#include <span>
#include <vector>

namespace vdbtools {

/// Bins need no search for what is near a block: it lies in the bins of the block and of its 26 neighbours.
/// All coordinates are in index space. BlockDistances reads the bins.
class TriangleBins {
 public:
  /// The boxes about a bin's triangles: nodes of level 0 of the view.
  struct Bin {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };

  /// Points of a layer and of the one behind it, by their numbers in the mesh.
  struct Points {
    std::uint64_t first = 0;
    std::span<const openvdb::Vec3d> here, behind;

    const openvdb::Vec3d& operator[](std::uint64_t i) const {
      const std::uint64_t at = i - first;
      return at < here.size() ? here[at] : behind[at - here.size()];
    }
  };

  /// @param origin  what points are relative to, a node
  /// @param nodes   all blocks lie near them
  TriangleBins(const openvdb::Coord& origin, const openvdb::CoordBBox& nodes);
  TriangleBins(const TriangleBins&) = delete;
  TriangleBins& operator=(const TriangleBins&) = delete;

  /// Adds the bins of a layer; each of them has a triangle.
  /// @param blocks     the first nodes of their blocks
  /// @param triangles  the triangles of each block, in the order of the mesh
  std::vector<Bin> add(std::span<const openvdb::Coord> blocks,
                       std::span<const std::vector<openvdb::Vec3I>* const> triangles, const Points& points,
                       const Monitor& monitor);

  /// Removes the first bins.
  /// @param triangles, nodes  how many they have; the nodes of all other bins are counted anew
  void removeFirst(std::uint32_t triangles, std::uint32_t nodes);

  const openvdb::Coord& origin() const { return mOrigin; }
  const kernels::TreeView& view() const { return mView; }
  std::uint32_t triangleCount() const { return static_cast<std::uint32_t>(mCorners.size() / 3); }
  std::uint32_t nodeCount() const { return static_cast<std::uint32_t>(mBoxes.size()); }

 private:
  void fill(const openvdb::Coord& block, const std::vector<openvdb::Vec3I>& triangles, const Points& points,
            std::uint32_t firstTriangle, const Bin& bin);
  void setView();

  openvdb::Coord mOrigin;
  std::vector<openvdb::Vec3d> mCorners;  ///< three for each triangle, relative to the origin
  std::vector<std::uint32_t> mOwn;       ///< 0, 1, 2, ...: no two triangles share a corner
  std::vector<kernels::PackNumbers> mNumbers;
  std::vector<kernels::PackFrames> mFrames;
  std::vector<kernels::BoxNode> mBoxes;
  kernels::TreeView mView{};
};

}  // namespace vdbtools
