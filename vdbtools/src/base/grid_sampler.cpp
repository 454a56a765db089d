// SPDX-License-Identifier: Apache-2.0
#include "base/grid_sampler.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <map>
#include <stdexcept>

namespace vdbtools {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatTree;
using Leaf = FloatTree::LeafNodeType;
using Accessor = openvdb::tree::ValueAccessor<const FloatTree>;

constexpr int kSide = static_cast<int>(julia::kBrickSide);
static_assert(Leaf::DIM == julia::kBrickSide, "bricks are aligned with leaves");

/// The part of a brick's nodes along one axis that lies in one leaf, in nodes of the brick.
struct Stretch {
  int leafOffset;  ///< relative to the brick's own leaf, in leaves
  int begin, end;
};

std::vector<Stretch> stretches(const julia::Bricks& bricks) {
  const int before = static_cast<int>(bricks.before());
  std::vector<Stretch> result;
  if (before > 0) result.push_back({-1, 0, before});
  result.push_back({0, before, before + kSide});
  result.push_back({1, before + kSide, static_cast<int>(bricks.side())});
  return result;
}

/// Reads one brick's values; nodes outside @a nodes repeat the nearest face.
class BrickReader {
 public:
  BrickReader(const openvdb::FloatGrid& grid, const CoordBBox& nodes, const julia::Bricks& bricks)
      : mAccessor(grid.tree()), mNodes(nodes), mBricks(bricks), mStretches(stretches(bricks)) {}

  /// Whether all values of the brick at @a origin equal one tile's value, which is then returned in @a value.
  bool isConstant(const Coord& origin, float& value) {
    bool first = true;
    for (const Stretch& x : mStretches)
      for (const Stretch& y : mStretches)
        for (const Stretch& z : mStretches) {
          const Coord leaf = origin.offsetBy(x.leafOffset * kSide, y.leafOffset * kSide, z.leafOffset * kSide);
          if (mAccessor.probeConstLeaf(leaf)) return false;
          const float tile = mAccessor.getValue(leaf);
          if (!first && tile != value) return false;
          value = tile;
          first = false;
        }
    return true;
  }

  void read(const Coord& origin, float* values) {
    const int side = static_cast<int>(mBricks.side());
    const Coord low = origin.offsetBy(-static_cast<int>(mBricks.before()));
    const bool within = mNodes.isInside(CoordBBox(low, low.offsetBy(side - 1)));
    if (!within) {
      for (int x = 0; x < side; ++x)
        for (int y = 0; y < side; ++y)
          for (int z = 0; z < side; ++z) {
            Coord node = low.offsetBy(x, y, z);
            node.maxComponent(mNodes.min());
            node.minComponent(mNodes.max());
            values[(x * side + y) * side + z] = mAccessor.getValue(node);
          }
      return;
    }
    for (const Stretch& sx : mStretches)
      for (const Stretch& sy : mStretches)
        for (const Stretch& sz : mStretches) {
          const Coord at = origin.offsetBy(sx.leafOffset * kSide, sy.leafOffset * kSide, sz.leafOffset * kSide);
          const Leaf* leaf = mAccessor.probeConstLeaf(at);
          const float tile = leaf ? 0 : mAccessor.getValue(at);
          for (int x = sx.begin; x < sx.end; ++x)
            for (int y = sy.begin; y < sy.end; ++y)
              for (int z = sz.begin; z < sz.end; ++z)
                values[(x * side + y) * side + z] =
                    leaf ? leaf->getValue(Leaf::coordToOffset(low.offsetBy(x, y, z))) : tile;
        }
  }

 private:
  Accessor mAccessor;
  CoordBBox mNodes;
  const julia::Bricks& mBricks;
  std::vector<Stretch> mStretches;
};

}  // namespace

GridBricks makeBricks(const openvdb::FloatGrid& grid, const CoordBBox& nodes, julia::Interpolation interpolation) {
  auto bricks = std::make_shared<julia::Bricks>();
  bricks->interpolation = interpolation;
  const Coord first = nodes.min() & ~(kSide - 1);
  double places = 1;
  for (int axis = 0; axis < 3; ++axis) {
    bricks->count[static_cast<std::size_t>(axis)] =
        static_cast<std::uint32_t>((nodes.max()[axis] - first[axis]) / kSide + 1);
    places *= bricks->count[static_cast<std::size_t>(axis)];
  }
  if (!(places < 0x7fffffff))
    throw std::invalid_argument("a grid of " + std::to_string(places) +
                                " leaves is more than the sampler can count; use larger voxels");
  const auto originOf = [&](std::size_t place) {
    const int z = static_cast<int>(place % bricks->count[2]);
    const int y = static_cast<int>(place / bricks->count[2] % bricks->count[1]);
    const int x = static_cast<int>(place / bricks->count[2] / bricks->count[1]);
    return first.offsetBy(x * kSide, y * kSide, z * kSide);
  };

  // Determines which places share a constant, and which need a brick of their own.
  bricks->brickAt.resize(static_cast<std::size_t>(places));
  std::map<float, std::uint32_t> constants;
  std::vector<std::size_t> own;
  std::uint32_t count = 0;
  BrickReader reader(grid, nodes, *bricks);
  for (std::size_t place = 0; place < bricks->brickAt.size(); ++place) {
    float value = 0;
    if (reader.isConstant(originOf(place), value)) {
      const auto [constant, isNew] = constants.try_emplace(value, count);
      count += isNew ? 1 : 0;
      bricks->brickAt[place] = constant->second;
    } else {
      bricks->brickAt[place] = count++;
      own.push_back(place);
    }
  }

  bricks->values.resize(count * bricks->size());
  for (const auto& [value, brick] : constants)
    std::fill_n(bricks->values.begin() + static_cast<std::ptrdiff_t>(brick * bricks->size()), bricks->size(), value);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, own.size(), 64), [&](const auto& range) {
    BrickReader local(grid, nodes, *bricks);
    for (std::size_t i = range.begin(); i != range.end(); ++i)
      local.read(originOf(own[i]), bricks->values.data() + bricks->brickAt[own[i]] * bricks->size());
  });
  return {std::move(bricks), first, nodes};
}

}  // namespace vdbtools
