// SPDX-License-Identifier: Apache-2.0
#include "surface/band_maker.h"

#include "base/in_parallel.h"
#include "distance/mesh_conversion.h"
#include "field/block_layers.h"

#include "vdbtools/base/memory.h"
#include "vdbtools/surface/level_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace vdbtools {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::Index;
using openvdb::Vec3d;

constexpr auto kWidth = static_cast<float>(kHalfWidth);
static_assert(kHalfWidth < kBlock, "the band of a block reaches no farther than its neighbours");

/// The offsets of a block's neighbours, the nearest first, in blocks.
std::array<Coord, 26> neighbourOffsets() {
  std::array<Coord, 26> offsets;
  std::size_t n = 0;
  for (int steps = 1; steps <= 3; ++steps)
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z)
          if (std::abs(x) + std::abs(y) + std::abs(z) == steps) offsets[n++] = Coord(x, y, z);
  return offsets;
}

bool isInsideAt(const InsideBits& bits, const Coord& node) {
  return bits[static_cast<std::size_t>(node[0])] >> (kBlock * node[1] + node[2]) & 1;
}

/// The place of a block among others that are ordered by y, then z; their number if it is not among them.
std::size_t placeOf(const std::vector<Coord>& blocks, const Coord& block) {
  const auto found = std::lower_bound(blocks.begin(), blocks.end(), block);
  return found != blocks.end() && *found == block ? static_cast<std::size_t>(found - blocks.begin()) : blocks.size();
}

}  // namespace

BandMaker::BandMaker(double voxelSize, const CoordBBox& domain, const Monitor& monitor)
    : mVoxelSize(voxelSize),
      mMonitor(monitor),
      mBins(TriangleTree::originNear(domain.getCenter()), domain),
      mNext(std::numeric_limits<std::int64_t>::min()),
      mDistances([this] { return BlockDistances(mBins); }) {}

void BandMaker::add(const SurfaceLayer& layer) {
  Layer added{.x = layer.x,
              .blocks = {layer.blocks.begin(), layer.blocks.end()},
              .inside = {layer.inside.begin(), layer.inside.end()}};
  std::vector<const std::vector<openvdb::Vec3I>*> triangles;
  for (std::size_t i = 0; i < layer.blocks.size(); ++i) {
    if (layer.triangles[i].empty()) continue;
    added.full.push_back(layer.blocks[i]);
    triangles.push_back(&layer.triangles[i]);
  }
  const Vec3d origin = mBins.origin().asVec3d();
  const auto local = [&](std::span<const Vec3d> positions) {
    std::vector<Vec3d> points(positions.size());
    inParallel(points.size(), 4096, mMonitor, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) points[i] = positions[i] / mVoxelSize - origin;
    });
    return points;
  };
  const std::vector<Vec3d> here = local(layer.positions), behind = local(layer.positionsBehind);
  const std::uint32_t triangleCount = mBins.triangleCount(), nodeCount = mBins.nodeCount();
  added.bins = mBins.add(added.full, triangles, {layer.first, here, behind}, mMonitor);
  added.triangles = mBins.triangleCount() - triangleCount;
  added.nodes = mBins.nodeCount() - nodeCount;
  mLayers.push_back(std::move(added));
  makeBandUpTo(std::int64_t{layer.x} - kBlock);
}

FloatGrid::Ptr BandMaker::finish() {
  makeBandUpTo(std::numeric_limits<std::int64_t>::max());
  FloatGrid::Ptr grid = FloatGrid::create(kWidth);
  openvdb::tree::ValueAccessor<openvdb::FloatTree> accessor(grid->tree());
  for (std::unique_ptr<Leaf>& leaf : mLeaves) accessor.addLeaf(leaf.release());
  mLeaves.clear();
  return toWorld(grid, mVoxelSize);
}

const BandMaker::Layer* BandMaker::layerAt(int x) const {
  const auto found = std::find_if(mLayers.begin(), mLayers.end(), [x](const Layer& layer) { return layer.x == x; });
  return found == mLayers.end() ? nullptr : &*found;
}

/// Makes the layers of the band up to @a x. All triangles that they need have been added.
void BandMaker::makeBandUpTo(std::int64_t x) {
  while (!mLayers.empty()) {
    mNext = std::max(mNext, std::int64_t{mLayers.front().x} - kBlock);
    if (mNext > x) return;
    makeBand(static_cast<int>(mNext));
    mNext += kBlock;
    // The next layer of the band needs the surface from the layer before it on.
    if (mLayers.front().x >= mNext - kBlock) continue;
    mBins.removeFirst(mLayers.front().triangles, mLayers.front().nodes);
    const std::uint32_t nodes = mLayers.front().nodes;
    mLayers.pop_front();
    for (Layer& layer : mLayers)
      for (TriangleBins::Bin& bin : layer.bins) bin.first -= nodes;
  }
}

void BandMaker::makeBand(int x) {
  std::vector<Coord> blocks;
  for (const Layer& layer : mLayers) {
    if (std::abs(std::int64_t{layer.x} - x) > kBlock) continue;
    for (const Coord& full : layer.full)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z) blocks.emplace_back(x, full[1] + y * kBlock, full[2] + z * kBlock);
  }
  std::sort(blocks.begin(), blocks.end());
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
  constexpr std::size_t kLeavesOfStep = 4096;
  if (mLeaves.size() + blocks.size() >= mNextStep) {
    mNextStep = mLeaves.size() + blocks.size() + kLeavesOfStep;
    // Not all of these blocks become leaves.
    requireMemoryForStep(0.5 * kBytesOfFloatLeaf * static_cast<double>(blocks.size()), MemoryUse::Field,
                         "a level set of more than " + std::to_string(mLeaves.size()) + " blocks of 8^3 nodes");
  }
  std::vector<std::unique_ptr<Leaf>> leaves(blocks.size());
  inParallel(blocks.size(), 4, mMonitor, [&](std::size_t begin, std::size_t end) {
    BlockDistances& distances = mDistances.local();
    for (std::size_t i = begin; i < end; ++i) leaves[i] = makeLeaf(blocks[i], distances);
  });
  for (std::unique_ptr<Leaf>& leaf : leaves)
    if (leaf) mLeaves.push_back(std::move(leaf));
}

/// The distances of a block's nodes in voxels, with their signs; null if none lies in the band.
std::unique_ptr<BandMaker::Leaf> BandMaker::makeLeaf(const Coord& block, BlockDistances& distances) const {
  std::vector<std::uint32_t> nodes;
  for (int x = -1; x <= 1; ++x) {
    const Layer* const layer = layerAt(block[0] + x * kBlock);
    if (!layer) continue;
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        const std::size_t place = placeOf(layer->full, Coord(layer->x, block[1] + y * kBlock, block[2] + z * kBlock));
        if (place == layer->full.size()) continue;
        const TriangleBins::Bin& bin = layer->bins[place];
        for (std::uint32_t n = 0; n < bin.count; ++n) nodes.push_back(bin.first + n);
      }
  }
  if (nodes.empty() || !distances.evaluate(block, kWidth, nodes)) return nullptr;
  auto leaf = std::make_unique<Leaf>(block);
  float* const values = leaf->buffer().data();
  openvdb::util::NodeMask<Leaf::LOG2DIM> active;
  const InsideBits inside = signsAt(block);
  for (Index i = 0; i < Leaf::SIZE; ++i) {
    const float distance = distances.distances()[i];
    const bool isNear = distance < kWidth;
    if (isNear) active.setOn(i);
    const bool isNegative = isNear && (inside[i / (kBlock * kBlock)] >> i % (kBlock * kBlock) & 1);
    values[i] = isNegative ? -distance : std::min(distance, kWidth);
  }
  if (active.isOff()) return nullptr;
  leaf->setValueMask(active);
  return leaf;
}

/// Where a block was not evaluated, F changes its sign neither in it nor between it and its neighbours.
InsideBits BandMaker::signsAt(const Coord& block) const {
  static const std::array<Coord, 26> kOffsets = neighbourOffsets();
  const auto bitsOf = [this](const Coord& at) -> const InsideBits* {
    const Layer* const layer = layerAt(at[0]);
    if (!layer) return nullptr;
    const std::size_t place = placeOf(layer->blocks, at);
    return place == layer->blocks.size() ? nullptr : &layer->inside[place];
  };
  if (const InsideBits* const own = bitsOf(block)) return *own;
  bool inside = false;
  for (const Coord& offset : kOffsets) {
    const InsideBits* const bits = bitsOf(block + Coord(offset[0] * kBlock, offset[1] * kBlock, offset[2] * kBlock));
    if (!bits) continue;
    // The neighbour's node that is next to the block.
    Coord node;
    for (int axis = 0; axis < 3; ++axis) node[axis] = offset[axis] < 0 ? kBlock - 1 : 0;
    inside = isInsideAt(*bits, node);
    break;
  }
  InsideBits all;
  all.fill(inside ? ~std::uint64_t{0} : 0);
  return all;
}

}  // namespace vdbtools
