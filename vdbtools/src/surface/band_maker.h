// SPDX-License-Identifier: Apache-2.0
/// @file band_maker.h
/// Makes the level set of a mesh while its layers arrive, so that neither the mesh nor the field need be held.
#pragma once

#include "field/leaf_signs.h"
#include "search/triangle_bins.h"
#include "search/triangle_tree.h"

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"

#include <tbb/enumerable_thread_specific.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <vector>

namespace vdbtools {

/// A layer of blocks in x, as SurfaceExtractor passes it on.
struct SurfaceLayer {
  int x = 0;                                               ///< of the blocks' first nodes
  std::span<const openvdb::Coord> blocks;                  ///< their first nodes, by y, then z
  std::span<const InsideBits> inside;                      ///< of each block
  std::span<const std::vector<openvdb::Vec3I>> triangles;  ///< of the cells that begin in each block
  std::uint64_t first = 0;                                 ///< the number of the first of these points in the mesh
  std::span<const openvdb::Vec3d> positions;               ///< of the layer's points, world units
  std::span<const openvdb::Vec3d> positionsBehind;         ///< of the next layer's points, which come after them
};

/// The result is that of levelSet() for the whole mesh, bit for bit: the distance of a node depends on its nearest
/// triangle alone, and that lies in the node's block or in one of the 26 around it.
class BandMaker {
 public:
  BandMaker(double voxelSize, const openvdb::CoordBBox& domain, const Monitor& monitor);

  /// Layers come in the order of x. Those that are left out have no block.
  void add(const SurfaceLayer& layer);

  /// The level set. @pre there was a triangle
  openvdb::FloatGrid::Ptr finish();

 private:
  using Leaf = openvdb::FloatTree::LeafNodeType;

  struct Layer {
    int x = 0;
    std::vector<openvdb::Coord> blocks;
    std::vector<InsideBits> inside;
    std::vector<openvdb::Coord> full;     ///< the blocks in which triangles begin
    std::vector<TriangleBins::Bin> bins;  ///< of each of these
    std::uint32_t triangles = 0, nodes = 0;
  };

  const Layer* layerAt(int x) const;
  void makeBandUpTo(std::int64_t x);
  void makeBand(int x);
  std::unique_ptr<Leaf> makeLeaf(const openvdb::Coord& block, BlockDistances& distances) const;
  InsideBits signsAt(const openvdb::Coord& block) const;

  double mVoxelSize;
  const Monitor& mMonitor;
  TriangleBins mBins;
  std::deque<Layer> mLayers;  ///< those that the next layer of the band may need
  std::int64_t mNext;         ///< x of the next layer of the band
  tbb::enumerable_thread_specific<BlockDistances> mDistances;
  std::vector<std::unique_ptr<Leaf>> mLeaves;
  std::size_t mNextStep = 0;  ///< how many leaves there are when memory is checked again
};

}  // namespace vdbtools
