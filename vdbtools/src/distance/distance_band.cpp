// SPDX-License-Identifier: Apache-2.0
/// A band is filled top-down: from cubes of 64^3 nodes that it may reach through smaller and smaller cubes to blocks of
/// 8^3, which become leaves. For signs, a narrow band is made first and flooded from outside.
#include "distance/distance_band.h"

#include "base/in_parallel.h"
#include "base/openvdb/exterior_trace.h"
#include "distance/outer_surface.h"
#include "search/triangle_point.h"

#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tree/LeafManager.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <memory>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::FloatTree;
using openvdb::Index;
using openvdb::Vec3d;
using openvdb::Vec3I;
using Leaf = FloatTree::LeafNodeType;
using TriangleLeaf = openvdb::Int32Tree::LeafNodeType;

constexpr int kBlock = BlockDistances::kSide;
constexpr int kCube = 64;  ///< what a thread works on
static_assert(Leaf::DIM == kBlock);

/// For the flood, the surface crosses nodes with squared distances up to this: half a voxel's diagonal.
constexpr float kCrossed = 0.75F;

/// The distance up to which signs are determined node by node: all neighbours of crossed nodes.
constexpr float kNarrow = 2.6F;

constexpr float kFar = 1e30F;

/// Because of rounding errors, a dot product of vectors in voxels counts as positive only above this.
constexpr double kOnePlane = 1e-6;

/// Nodes nearer to the surface than this, in voxels, lie on it, and are not inside: rounding alone would put some of
/// them there, where they would be islands of one node.
constexpr float kOnSurface = 1e-9F;

double halfDiagonal(int side) { return 0.5 * (side - 1) * std::sqrt(3.0); }

Vec3d middleOf(const Coord& origin, int side) { return origin.asVec3d() + Vec3d(0.5 * (side - 1)); }

Coord eighthOf(const Coord& origin, int side, int n) {
  const int half = side / 2;
  return origin.offsetBy((n >> 2) * half, (n >> 1 & 1) * half, (n & 1) * half);
}

/// The distances at a block's nodes, and the nearest triangles if they are requested.
struct Made {
  std::unique_ptr<Leaf> leaf;
  std::unique_ptr<TriangleLeaf> triangles;
};

/// Makes the leaves of a band.
class Band {
 public:
  /// Whether a cube of @a side nodes, which lies farther than kNarrow from the surface, belongs to the band.
  using Belongs = std::function<bool(const Coord& origin, int side, float least)>;
  /// Fills a leaf, and returns whether it belongs to the band.
  using Fill = std::function<bool(const BlockDistances& block, Leaf& leaf)>;

  Band(const TriangleTree& tree, float width, Belongs belongs, Fill fill, bool keepsTriangles = false)
      : mTree(tree),
        mWidth(width),
        mBelongs(std::move(belongs)),
        mFill(std::move(fill)),
        mKeepsTriangles(keepsTriangles) {}

  /// The leaves, in an order that depends on the mesh alone.
  std::vector<Made> make(const Phase& phase, Monitor& monitor) {
    const std::vector<Coord> cubes = findCubes();
    std::vector<std::vector<Made>> parts(cubes.size());
    monitor.begin(phase, cubes.size());
    inParallel(cubes.size(), 1, monitor, [&](std::size_t begin, std::size_t end) {
      BlockDistances distances(mTree);
      for (std::size_t i = begin; i < end; ++i) {
        fillCube(cubes[i], kCube, distances, parts[i]);
        monitor.advance(1);
      }
    });
    std::vector<Made> all;
    for (std::vector<Made>& part : parts)
      all.insert(all.end(), std::make_move_iterator(part.begin()), std::make_move_iterator(part.end()));
    return all;
  }

 private:
  bool reaches(const Coord& origin, int side, BlockDistances& distances) const {
    const auto half = static_cast<float>(halfDiagonal(side) * 1.0001 + 1e-3);
    const std::optional<float> distance = distances.distance(middleOf(origin, side), mWidth + half);
    if (!distance) return false;
    const float least = *distance - half;
    return least <= kNarrow || mBelongs(origin, side, least);
  }

  std::vector<Coord> findCubes() const {
    const Coord low = Coord::floor(mTree.box().min() - Vec3d(mWidth)),
                high = Coord::ceil(mTree.box().max() + Vec3d(mWidth));
    // 64 bits, because the box may be as large as coordinates allow.
    std::int64_t side = kCube;
    const auto cubesAlong = [&](int axis) { return (std::int64_t{high[axis]} - low[axis]) / side + 2; };
    while (std::max({cubesAlong(0), cubesAlong(1), cubesAlong(2)}) > 4) side *= 2;
    std::vector<Coord> cubes;
    BlockDistances distances(mTree);
    const auto first = [&](int axis) { return std::int64_t{low[axis]} & ~(side - 1); };
    for (std::int64_t x = first(0); x <= high[0]; x += side)
      for (std::int64_t y = first(1); y <= high[1]; y += side)
        for (std::int64_t z = first(2); z <= high[2]; z += side)
          findCubes(Coord(static_cast<int>(x), static_cast<int>(y), static_cast<int>(z)), static_cast<int>(side),
                    distances, cubes);
    return cubes;
  }

  void findCubes(const Coord& origin, int side, BlockDistances& distances, std::vector<Coord>& cubes) const {
    if (!reaches(origin, side, distances)) return;
    if (side == kCube) {
      cubes.push_back(origin);
      return;
    }
    for (int n = 0; n < 8; ++n) findCubes(eighthOf(origin, side, n), side / 2, distances, cubes);
  }

  void fillCube(const Coord& origin, int side, BlockDistances& distances, std::vector<Made>& made) const {
    if (!reaches(origin, side, distances)) return;
    if (side == kBlock) {
      distances.evaluate(origin, mWidth);
      auto leaf = std::make_unique<Leaf>(origin);
      if (!mFill(distances, *leaf)) return;
      made.push_back({std::move(leaf), nullptr});
      if (!mKeepsTriangles) return;
      made.back().triangles = std::make_unique<TriangleLeaf>(origin, 0, true);
      std::copy_n(distances.triangles(), Leaf::SIZE, made.back().triangles->buffer().data());
      return;
    }
    for (int n = 0; n < 8; ++n) fillCube(eighthOf(origin, side, n), side / 2, distances, made);
  }

  const TriangleTree& mTree;
  float mWidth;
  Belongs mBelongs;
  Fill mFill;
  bool mKeepsTriangles;
};

FloatGrid::Ptr gridOf(std::vector<Made> all, float background) {
  FloatGrid::Ptr grid = FloatGrid::create(background);
  openvdb::tree::ValueAccessor<FloatTree> accessor(grid->tree());
  for (Made& made : all) accessor.addLeaf(made.leaf.release());
  return grid;
}

/// The sides of the mesh.
struct Sides {
  FloatTree sign;                   ///< below 0 inside, above 0 outside, at every node
  std::vector<HiddenPlace> hidden;  ///< where the surface has no outside next to it
};

class SideFinder {
 public:
  SideFinder(const TriangleTree& tree, Monitor& monitor) : mTree(tree), mMonitor(monitor) {}

  Sides find() {
    makeSquares();
    traceExterior(mSquares);
    mMonitor.throwIfCancelled();
    Sides sides{FloatTree(1.0F), {}};
    resolveCrossed(sides);
    return sides;
  }

 private:
  void makeSquares() {
    Band band(
        mTree, kNarrow, [](const Coord&, int, float) { return false; },
        [](const BlockDistances& block, Leaf& leaf) {
          float* const values = leaf.buffer().data();
          bool any = false;
          for (Index i = 0; i < Leaf::SIZE; ++i) {
            const float d = block.distances()[i];
            any |= d <= kNarrow;
            values[i] = d <= kNarrow ? d * d : kFar;
          }
          leaf.setValuesOn();
          return any;
        },
        /*keepsTriangles=*/true);
    openvdb::tree::ValueAccessor<FloatTree> squares(mSquares);
    openvdb::tree::ValueAccessor<openvdb::Int32Tree> triangles(mTriangles);
    for (Made& made : band.make(PhaseKind::Sides, mMonitor)) {
      squares.addLeaf(made.leaf.release());
      triangles.addLeaf(made.triangles.release());
    }
  }

  using Squares = openvdb::tree::ValueAccessor<const FloatTree>;
  using Triangles = openvdb::tree::ValueAccessor<const openvdb::Int32Tree>;

  /// Whether a crossed node is outside. If the surface passes between two nodes, the sum of their distances is at most
  /// the distance between them, so a node is on the same side as a neighbour if the sum is larger. If this does not
  /// decide, the node is outside if it is on the outer side of the triangle that is nearest to an outer neighbour.
  bool isOutside(const Coord& node, float square, const Squares& squares, const Triangles& triangles) const {
    const float distance = std::sqrt(square);
    bool besideInside = false, seemsOutside = false;
    for (int k = 0; k < 27; ++k) {
      const Coord offset(k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1), next = node + offset;
      const float other = squares.getValue(next);
      if (std::abs(other) <= kCrossed || std::abs(other) >= kFar) continue;
      const auto way =
          std::sqrt(static_cast<float>(offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2]));
      const bool sameSide = distance + std::sqrt(std::abs(other)) > way * 1.00001F;
      if (sameSide && other < 0) return true;
      besideInside |= sameSide;
      if (other > 0 || seemsOutside) continue;
      const Vec3d nearest = nearestPoint(static_cast<std::uint32_t>(triangles.getValue(next)), next);
      seemsOutside =
          ((node - mTree.origin()).asVec3d() - nearest).dot((next - mTree.origin()).asVec3d() - nearest) > kOnePlane;
    }
    return seemsOutside && !besideInside;
  }

  void resolveCrossed(Sides& sides) {
    openvdb::tree::LeafManager<const FloatTree> leaves(mSquares);
    std::vector<std::unique_ptr<Leaf>> signs(leaves.leafCount());
    inParallel(signs.size(), 16, mMonitor, [&](std::size_t begin, std::size_t end) {
      const Squares squares(mSquares);
      const Triangles triangles(mTriangles);
      for (std::size_t i = begin; i < end; ++i) {
        const Leaf& leaf = leaves.leaf(i);
        signs[i] = std::make_unique<Leaf>(leaf.origin(), 1.0F, true);
        for (Index n = 0; n < Leaf::SIZE; ++n) {
          const float square = leaf.getValue(n);
          const bool outside =
              square < 0 || (square <= kCrossed && isOutside(leaf.offsetToGlobalCoord(n), square, squares, triangles));
          signs[i]->setValueOnly(n, outside ? 1.0F : -1.0F);
        }
      }
    });
    openvdb::tree::ValueAccessor<FloatTree> accessor(sides.sign);
    for (std::unique_ptr<Leaf>& sign : signs) accessor.addLeaf(sign.release());
    openvdb::tools::signedFloodFillWithValues(sides.sign, 1.0F, -1.0F);
    findHidden(sides);
  }

  /// The places that are nearest to crossed nodes without an outer neighbour.
  void findHidden(Sides& sides) const {
    openvdb::tree::LeafManager<const FloatTree> leaves(mSquares);
    std::vector<std::vector<HiddenPlace>> hidden(leaves.leafCount());
    inParallel(hidden.size(), 16, mMonitor, [&](std::size_t begin, std::size_t end) {
      const openvdb::tree::ValueAccessor<const FloatTree> sign(sides.sign);
      for (std::size_t i = begin; i < end; ++i) {
        const Leaf& leaf = leaves.leaf(i);
        const TriangleLeaf& triangles = *mTriangles.probeConstLeaf(leaf.origin());
        for (Index n = 0; n < Leaf::SIZE; ++n) {
          if (!(std::abs(leaf.getValue(n)) <= kCrossed)) continue;
          const Coord node = leaf.offsetToGlobalCoord(n);
          bool hasOutside = false;
          for (int k = 0; k < 27 && !hasOutside; ++k)
            hasOutside = sign.getValue(node.offsetBy(k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1)) > 0;
          if (hasOutside) continue;
          const auto triangle = static_cast<std::uint32_t>(triangles.getValue(n));
          hidden[i].push_back({triangle, nearestPoint(triangle, node) + mTree.origin().asVec3d()});
        }
      }
    });
    for (const std::vector<HiddenPlace>& some : hidden)
      sides.hidden.insert(sides.hidden.end(), some.begin(), some.end());
  }

  /// The point of a triangle nearest to a node, relative to the tree's origin.
  Vec3d nearestPoint(std::uint32_t triangle, const Coord& node) const {
    const std::vector<Vec3d>& points = mTree.localPoints();
    const Vec3I& t = mTree.triangles()[triangle];
    Vec3d weights;
    return nearestOnTriangle(points[t[0]], points[t[1]], points[t[2]], (node - mTree.origin()).asVec3d(), weights);
  }

  const TriangleTree& mTree;
  Monitor& mMonitor;
  FloatTree mSquares{kFar};
  openvdb::Int32Tree mTriangles{0};
};

/// Whether some node near the position is outside.
bool hasOutside(const openvdb::tree::ValueAccessor<const FloatTree>& sign, const Vec3d& position) {
  // The lattice does not resolve narrow grooves; their walls are kept up to this distance.
  constexpr int kReach = 3;
  const Coord base = Coord::floor(position).offsetBy(1 - kReach);
  for (int x = 0; x < 2 * kReach; ++x)
    for (int y = 0; y < 2 * kReach; ++y)
      for (int z = 0; z < 2 * kReach; ++z)
        if (sign.getValue(base.offsetBy(x, y, z)) > 0) return true;
  return false;
}

/// Whether some part of a triangle has an outside next to it, tested at points a voxel apart.
bool boundsSomething(const openvdb::tree::ValueAccessor<const FloatTree>& sign, const Vec3d& a, const Vec3d& b,
                     const Vec3d& c) {
  constexpr double kMostSteps = 4096;
  const double longest = std::max({(b - a).length(), (c - a).length(), (c - b).length()});
  const int steps = static_cast<int>(std::clamp(std::ceil(longest), 1.0, kMostSteps));
  for (int i = 0; i <= steps; ++i)
    for (int j = 0; i + j <= steps; ++j)
      if (hasOutside(sign, a + (b - a) * (double(i) / steps) + (c - a) * (double(j) / steps))) return true;
  return false;
}

/// The triangles that have an outside next to them.
std::vector<Vec3I> boundingTriangles(const TriangleTree& tree, const Sides& sides, const Monitor& monitor) {
  std::vector<char> bounds(tree.triangles().size(), 0);
  inParallel(bounds.size(), 256, monitor, [&](std::size_t begin, std::size_t end) {
    const openvdb::tree::ValueAccessor<const FloatTree> sign(sides.sign);
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3I& t = tree.triangles()[i];
      bounds[i] = boundsSomething(sign, tree.points()[t[0]], tree.points()[t[1]], tree.points()[t[2]]);
    }
  });
  std::vector<Vec3I> kept;
  kept.reserve(static_cast<std::size_t>(std::count(bounds.begin(), bounds.end(), 1)));
  for (std::size_t i = 0; i < bounds.size(); ++i)
    if (bounds[i]) kept.push_back(tree.triangles()[i]);
  return kept;
}

/// Fills a leaf with the distances up to the band's widths, negative inside.
/// @param isOutside  takes the number of a node of the leaf
/// @return whether any node belongs to the band
template <class IsOutside>
bool fillLeaf(const BlockDistances& block, float exterior, float interior, const IsOutside& isOutside, Leaf& leaf) {
  float* const values = leaf.buffer().data();
  openvdb::util::NodeMask<Leaf::LOG2DIM> active;
  for (Index i = 0; i < Leaf::SIZE; ++i) {
    const float d = block.distances()[i];
    const bool outside = isOutside(i);
    values[i] = outside ? std::min(d, exterior) : -std::min(d < kOnSurface ? 0.0F : d, interior);
    if (d < (outside ? exterior : interior)) active.setOn(i);
  }
  leaf.setValueMask(active);
  return !active.isOff();
}

FloatGrid::Ptr signedBand(const TriangleTree& tree, const FloatTree& sign, float exterior, float interior,
                          const Phase& phase, Monitor& monitor) {
  const auto isOutside = [&](const Coord& node) { return sign.getValue(node) > 0; };
  Band band(
      tree, std::max(exterior, interior),
      [&](const Coord& origin, int side, float least) {
        // This far from the surface, all nodes lie on one side.
        return least < (isOutside(origin + Coord(side / 2)) ? exterior : interior);
      },
      [&](const BlockDistances& block, Leaf& leaf) {
        const Leaf* const signs = sign.probeConstLeaf(leaf.origin());
        const bool allOutside = !signs && isOutside(leaf.origin());
        return fillLeaf(
            block, exterior, interior, [&](Index i) { return signs ? signs->getValue(i) > 0 : allOutside; }, leaf);
      });
  FloatGrid::Ptr grid = gridOf(band.make(phase, monitor), exterior);
  openvdb::tools::signedFloodFillWithValues(grid->tree(), exterior, -interior);
  return grid;
}

/// Calls use(bounds, sign) with the triangles that bound the inside, and the side of each node.
/// @param counts  as in signedDistances()
void withBounds(const TriangleTree& tree, PartCounts* counts, Monitor& monitor,
                const std::function<void(const TriangleTree&, const FloatTree&)>& use) {
  const Sides sides = SideFinder(tree, monitor).find();
  if (counts) {
    *counts = {};
    if (const auto outer = outerSurface(tree, sides.hidden, monitor)) {
      *counts = outer->parts;
      return withBounds(TriangleTree(outer->points, outer->triangles, {}, tree.frames()), nullptr, monitor, use);
    }
  }
  if (!sides.hidden.empty()) {
    const std::vector<Vec3I> kept = boundingTriangles(tree, sides, monitor);
    if (!kept.empty() && kept.size() < tree.triangles().size())
      return use(TriangleTree(tree.points(), kept, {}, tree.frames()), sides.sign);
  }
  return use(tree, sides.sign);
}

/// The bounds of solids with hollows, from the bounds of all layers.
struct LayeredBounds {
  LayeredBounds(const TriangleTree& tree, const NestedSurfaces& nested, Monitor& monitor) {
    for (std::size_t layer = 0; layer < nested.layers.size(); ++layer) {
      if (nested.layers[layer].empty()) continue;
      PartCounts ignored;
      withBounds(TriangleTree(tree.points(), nested.layers[layer], {}, tree.frames()), &ignored, monitor,
                 [&](const TriangleTree& bounds, const FloatTree& side) { add(bounds, side, layer % 2 == 1); });
    }
  }

  std::vector<Vec3d> points;
  std::vector<Vec3I> triangles;
  FloatTree sign{1.0F};

 private:
  void add(const TriangleTree& bounds, const FloatTree& side, bool isHollow) {
    const Vec3I first(static_cast<Vec3I::ValueType>(points.size()));
    points.insert(points.end(), bounds.points().begin(), bounds.points().end());
    for (const Vec3I& t : bounds.triangles()) triangles.push_back(t + first);
    FloatTree other(side);
    sign.combine(other, [isHollow](float own, float added, float& result) {
      result = isHollow ? std::max(own, -added) : std::min(own, added);
    });
  }
};

}  // namespace

FloatGrid::Ptr unsignedDistances(const TriangleTree& tree, float width, const Phase& phase, Monitor& monitor) {
  Band band(
      tree, width, [&](const Coord&, int, float least) { return least < width; },
      [&](const BlockDistances& block, Leaf& leaf) {
        return fillLeaf(
            block, width, width, [](Index) { return true; }, leaf);
      });
  return gridOf(band.make(phase, monitor), width);
}

FloatGrid::Ptr signedDistances(const TriangleTree& tree, float exterior, float interior, const Phase& phase,
                               Monitor& monitor, PartCounts* counts, Hollows hollows) {
  if (counts && hollows == Hollows::Keep)
    if (const auto nested = nestedSurfaces(tree, monitor)) {
      *counts = nested->parts;
      const LayeredBounds bounds(tree, *nested, monitor);
      return signedBand(TriangleTree(bounds.points, bounds.triangles, {}, tree.frames()), bounds.sign, exterior,
                        interior, phase, monitor);
    }
  FloatGrid::Ptr grid;
  withBounds(tree, counts, monitor, [&](const TriangleTree& bounds, const FloatTree& sign) {
    grid = signedBand(bounds, sign, exterior, interior, phase, monitor);
  });
  return grid;
}

}  // namespace vdbtools
