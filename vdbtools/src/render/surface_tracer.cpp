// SPDX-License-Identifier: Apache-2.0
#include "render/surface_tracer.h"
#include "distance/leaves.h"

#include <openvdb/tools/Interpolation.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace vdbtools {

using openvdb::Coord;
using openvdb::Vec3d;

namespace {

/// Finds the surface cells from signs alone, because the field of a rough fractal changes too fast for a test of its
/// values. That is why tools::LevelSetRayIntersector, which skips values beyond two voxels, leaves holes there.
class SurfaceCells {
 public:
  using Leaf = openvdb::FloatTree::LeafNodeType;

  SurfaceCells(const openvdb::FloatTree& tree, const std::vector<const Leaf*>& leaves, const Monitor& monitor)
      : mTree(tree), mLeaves(leaves), mMonitor(monitor) {}
  SurfaceCells(const SurfaceCells& other, tbb::split) : SurfaceCells(other.mTree, other.mLeaves, other.mMonitor) {}

  void operator()(const tbb::blocked_range<std::size_t>& range) {
    openvdb::FloatGrid::ConstAccessor field(mTree);
    openvdb::tree::ValueAccessor<openvdb::MaskTree> cells(mCells);
    for (std::size_t n = range.begin(); n != range.end(); ++n) {
      mMonitor.throwIfCancelled();
      for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) markAround(*mLeaves[n], i, field, cells);
    }
  }
  void join(SurfaceCells& other) { mCells.merge(other.mCells); }
  const openvdb::MaskTree& cells() const { return mCells; }

 private:
  template <typename Field, typename Cells>
  static void markAround(const Leaf& leaf, openvdb::Index offset, Field& field, Cells& cells) {
    const bool inside = leaf.getValue(offset) < 0;
    const Coord local = Leaf::offsetToLocalCoord(offset);
    const Coord node = local + leaf.origin();
    for (int axis = 0; axis < 3; ++axis) {
      const auto stride = openvdb::Index(1) << (Leaf::LOG2DIM * (2 - axis));
      Coord next = node, previous = node;
      next[axis] += 1;
      previous[axis] -= 1;
      const bool atEnd = local[axis] == int(Leaf::DIM) - 1;
      const float ahead = atEnd ? field.getValue(next) : leaf.getValue(offset + stride);
      if ((ahead < 0) != inside) markEdge(node, axis, cells);
      // The leaf before this one may not exist, and then nothing else examines this edge.
      if (local[axis] == 0 && (field.getValue(previous) < 0) != inside) markEdge(previous, axis, cells);
    }
  }

  /// Marks the four cells around the edge that leaves @a node along @a axis.
  template <typename Cells>
  static void markEdge(const Coord& node, int axis, Cells& cells) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int corner = 0; corner < 4; ++corner) {
      Coord cell = node;
      cell[u] -= corner & 1;
      cell[v] -= corner >> 1;
      cells.setValueOn(cell);
    }
  }

  const openvdb::FloatTree& mTree;
  const std::vector<const Leaf*>& mLeaves;
  const Monitor& mMonitor;
  openvdb::MaskTree mCells;
};

template <typename Value>
double zeroBetween(double t0, double v0, double t1, double v1, const Value& value) {
  constexpr int kSteps = 4;  // steps of the false position method, starting from a third of a cell
  double t = t1;
  for (int i = 0; i < kSteps && v0 != v1; ++i) {
    t = t0 + (t1 - t0) * v0 / (v0 - v1);
    const double v = value(t);
    (v < 0 ? t1 : t0) = t;
    (v < 0 ? v1 : v0) = v;
  }
  return t;
}

/// A ray relative to the lattice's origin, and its current cell.
struct Walk {
  Vec3d origin, direction, inverse;
  Coord step, node;
  double time = 0;  ///< ray parameter at the entry into the cell

  Walk(const Vec3d& from, const Vec3d& towards) : origin(from), direction(towards) {
    constexpr double kLeastSlope = 1e-30;  // instead of 0, so that no product is 0 times infinity
    for (int axis = 0; axis < 3; ++axis) {
      if (std::abs(direction[axis]) < kLeastSlope) direction[axis] = kLeastSlope;
      inverse[axis] = 1 / direction[axis];
      step[axis] = direction[axis] > 0 ? 1 : -1;
    }
  }

  /// Moves to where the ray enters the box of the cells from 0 up to @a last. @return false if it never does
  bool enter(const Coord& last) {
    double begin = 0, end = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      const double low = -origin[axis] * inverse[axis], high = (last[axis] + 1.0 - origin[axis]) * inverse[axis];
      begin = std::max(begin, std::min(low, high));
      end = std::min(end, std::max(low, high));
    }
    if (!(begin <= end)) return false;
    time = begin;
    for (int axis = 0; axis < 3; ++axis)
      node[axis] = static_cast<int>(std::clamp<double>(origin[axis] + begin * direction[axis], 0, last[axis]));
    return true;
  }

  /// Leaves a box of cells. @param high  one beyond the last of them
  void leave(const Coord& low, const Coord& high) {
    double exit = std::numeric_limits<double>::infinity();
    int through = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double t = ((step[axis] > 0 ? high[axis] : low[axis]) - origin[axis]) * inverse[axis];
      if (t < exit) {
        exit = t;
        through = axis;
      }
    }
    time = std::max(time, exit);
    // Rounding must not put the ray back into the box, nor into a cell beside the next one.
    for (int axis = 0; axis < 3; ++axis)
      node[axis] = std::clamp(static_cast<int>(origin[axis] + time * direction[axis]), low[axis], high[axis] - 1);
    node[through] = step[through] > 0 ? high[through] : low[through] - 1;
  }
};

}  // namespace

namespace {

/// For each octant and cell of a brick: the brick's cells that a ray in that octant may meet from there.
class CellsAhead {
 public:
  CellsAhead() {
    constexpr int kDim = 1 << SurfaceLattice::kBrickShift, kCells = kDim * kDim * kDim;
    const auto isAhead = [](int octant, int from, int to, int axis) {
      const int shift = SurfaceLattice::kBrickShift * (2 - axis);
      const int a = from >> shift & (kDim - 1), b = to >> shift & (kDim - 1);
      return octant >> axis & 1 ? b <= a : b >= a;
    };
    for (int octant = 0; octant < 8; ++octant)
      for (int from = 0; from < kCells; ++from)
        for (int to = 0; to < kCells; ++to)
          if (isAhead(octant, from, to, 0) && isAhead(octant, from, to, 1) && isAhead(octant, from, to, 2))
            mMasks[static_cast<std::size_t>(octant)][static_cast<std::size_t>(from)] |= std::uint64_t(1) << to;
  }
  const std::array<std::uint64_t, 64>& towards(int octant) const { return mMasks[static_cast<std::size_t>(octant)]; }

 private:
  std::array<std::array<std::uint64_t, 64>, 8> mMasks{};
};

const CellsAhead kCellsAhead;

}  // namespace

openvdb::MaskTree surfaceCells(const openvdb::FloatTree& tree, const Monitor& monitor) {
  const std::vector<const SurfaceCells::Leaf*> leaves = leavesOf(tree);
  SurfaceCells work(tree, leaves, monitor);
  tbb::parallel_reduce(tbb::blocked_range<std::size_t>(0, leaves.size()), work);
  return work.cells();
}

SurfaceBounds boundsOf(const openvdb::MaskTree& cells) {
  openvdb::CoordBBox extent;
  cells.evalActiveVoxelBoundingBox(extent);
  SurfaceBounds bounds;
  bounds.box = openvdb::BBoxd(extent.min().asVec3d(), extent.max().asVec3d() + Vec3d(1));
  bounds.centre = 0.5 * (bounds.box.min() + bounds.box.max());
  for (auto leaf = cells.cbeginLeaf(); leaf; ++leaf) {
    for (auto cell = leaf->cbeginValueOn(); cell; ++cell) {
      const Vec3d middle = cell.getCoord().asVec3d() + Vec3d(0.5);
      bounds.radius = std::max(bounds.radius, (middle - bounds.centre).lengthSqr());
    }
  }
  bounds.radius = std::sqrt(bounds.radius) + 0.5;  // half a cell, because the surface is somewhere in it
  return bounds;
}

double lowestCorner(const Vec3d& direction, const openvdb::MaskTree& cells) {
  double least = std::numeric_limits<double>::infinity();
  for (auto cell = cells.cbeginValueOn(); cell; ++cell) {
    const openvdb::CoordBBox box = cell.getBoundingBox();
    Vec3d corner;
    for (int axis = 0; axis < 3; ++axis) corner[axis] = direction[axis] > 0 ? box.min()[axis] : box.max()[axis] + 1;
    least = std::min(least, corner.dot(direction));
  }
  return least;
}

SurfaceLattice::SurfaceLattice(const openvdb::FloatTree& field, const openvdb::MaskTree& cells) : mField(field) {
  constexpr std::int64_t kMostCubes = std::int64_t(1) << 22;  // of eight bytes
  openvdb::CoordBBox box;
  cells.evalLeafBoundingBox(box);
  mOrigin = box.min();
  const auto countAt = [&](int shift) {
    std::array<std::int64_t, 3> sides;
    for (int axis = 0; axis < 3; ++axis) {
      mSize[axis] = static_cast<int>(((std::int64_t(box.max()[axis]) - mOrigin[axis]) >> shift) + 1);
      sides[static_cast<std::size_t>(axis)] = mSize[axis] + 2;
    }
    mStrides = {sides[1] * sides[2], sides[2]};
    return sides[0] * mStrides[0];
  };
  while (countAt(mShift) > kMostCubes) ++mShift;

  const auto count = static_cast<std::size_t>(countAt(mShift));
  mFirstBrick.assign(count, 0);
  mFree[0].assign(count, std::numeric_limits<std::uint8_t>::max());
  for (auto leaf = cells.cbeginLeaf(); leaf; ++leaf) addLeaf(*leaf);
  for (std::size_t octant = 1; octant < mFree.size(); ++octant) mFree[octant] = mFree[0];
  tbb::parallel_for(0, static_cast<int>(mFree.size()), [&](int octant) { measureFreeCubes(octant); });
}

void SurfaceLattice::addLeaf(const openvdb::MaskTree::LeafNodeType& leaf) {
  constexpr int kDim = openvdb::MaskTree::LeafNodeType::DIM, kBrickDim = 1 << kBrickShift;
  const std::size_t bricksInCube = std::size_t(1) << 3 * (mShift - kBrickShift);
  const auto number = static_cast<std::uint32_t>(mLeaves.size());
  LeafValues& values = mLeaves.emplace_back();
  for (int i = 0; i < 8; ++i) {
    const Coord origin = leaf.origin().offsetBy(i & 4 ? kDim : 0, i & 2 ? kDim : 0, i & 1 ? kDim : 0);
    const auto* of = mField.probeConstLeaf(origin);
    values[static_cast<std::size_t>(i)] = of ? of->buffer().data() : nullptr;
  }
  std::array<std::uint64_t, 8> bricks{};
  for (auto cell = leaf.cbeginValueOn(); cell; ++cell) {
    const Coord at = openvdb::MaskTree::LeafNodeType::offsetToLocalCoord(cell.pos());
    const int brick = at[0] / kBrickDim << 2 | at[1] / kBrickDim << 1 | at[2] / kBrickDim;
    const int bit = (at[0] % kBrickDim << 2 | at[1] % kBrickDim) << 2 | at[2] % kBrickDim;
    bricks[static_cast<std::size_t>(brick)] |= std::uint64_t(1) << bit;
  }
  for (int i = 0; i < 8; ++i) {
    const std::uint64_t mask = bricks[static_cast<std::size_t>(i)];
    if (!mask) continue;
    const Coord node =
        leaf.origin().offsetBy(i & 4 ? kBrickDim : 0, i & 2 ? kBrickDim : 0, i & 1 ? kBrickDim : 0) - mOrigin;
    const std::size_t cube = indexOf(Coord(node[0] >> mShift, node[1] >> mShift, node[2] >> mShift));
    if (mFree[0][cube] != 0) {
      mFree[0][cube] = 0;
      mFirstBrick[cube] = static_cast<std::uint32_t>(mBricks.size());
      mBricks.resize(mBricks.size() + bricksInCube);
    }
    const_cast<Brick&>(brick(cube, node)) = {mask, number};
  }
}

/// A cube of n + 1 cubes along each side is free if its corner is, and the seven of n that reach it from there.
void SurfaceLattice::measureFreeCubes(int octant) {
  std::vector<std::uint8_t>& free = mFree[static_cast<std::size_t>(octant)];
  Coord step, last;
  for (int axis = 0; axis < 3; ++axis) {
    step[axis] = octant >> axis & 1 ? -1 : 1;
    last[axis] = step[axis] > 0 ? mSize[axis] - 1 : 0;
  }
  std::array<std::ptrdiff_t, 8> neighbours;
  for (int i = 0; i < 8; ++i)
    neighbours[static_cast<std::size_t>(i)] =
        (i & 4 ? step[0] * mStrides[0] : 0) + (i & 2 ? step[1] * mStrides[1] : 0) + (i & 1 ? step[2] : 0);
  // From the far end, so that the neighbours are known; the layer around the lattice is free up to the maximum number.
  for (int i = 0; i < mSize[0]; ++i) {
    for (int j = 0; j < mSize[1]; ++j) {
      for (int k = 0; k < mSize[2]; ++k) {
        std::uint8_t* const cube =
            &free[indexOf(Coord(last[0] - i * step[0], last[1] - j * step[1], last[2] - k * step[2]))];
        if (*cube == 0) continue;
        std::uint8_t least = std::numeric_limits<std::uint8_t>::max() - 1;
        for (std::size_t n = 1; n < neighbours.size(); ++n) least = std::min(least, cube[neighbours[n]]);
        *cube = static_cast<std::uint8_t>(least + 1);
      }
    }
  }
}

Vec3d SurfaceTracer::normal(const Vec3d& position) const {
  Vec3d gradient;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3d step(0);
    step[axis] = 1;
    gradient[axis] = openvdb::tools::BoxSampler::sample(mField, position + step) -
                     openvdb::tools::BoxSampler::sample(mField, position - step);
  }
  return gradient;
}

bool SurfaceTracer::trace(const Vec3d& origin, const Vec3d& direction) {
  constexpr int kShift = SurfaceLattice::kBrickShift, kDim = 1 << kShift;
  Walk walk(origin - mLattice.origin().asVec3d(), direction);
  mOrigin = walk.origin;
  mDirection = walk.direction;
  const Coord size = mLattice.size();
  const int shift = mLattice.shift();
  if (!walk.enter(Coord((size[0] << shift) - 1, (size[1] << shift) - 1, (size[2] << shift) - 1))) return false;
  int octant = 0;
  for (int axis = 0; axis < 3; ++axis) octant |= (walk.step[axis] < 0) << axis;
  const std::uint8_t* const freeCubes = mLattice.freeCubes(octant).data();
  const std::array<std::uint64_t, 64>& ahead = kCellsAhead.towards(octant);

  for (;;) {
    const Coord cube(walk.node[0] >> shift, walk.node[1] >> shift, walk.node[2] >> shift);
    for (int axis = 0; axis < 3; ++axis)
      if (static_cast<unsigned>(cube[axis]) >= static_cast<unsigned>(size[axis])) return false;
    const std::size_t index = mLattice.indexOf(cube);
    if (const int side = freeCubes[index]) {
      Coord low, high;
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = (walk.step[axis] > 0 ? cube[axis] : cube[axis] + 1 - side) * (1 << shift);
        high[axis] = (walk.step[axis] > 0 ? cube[axis] + side : cube[axis] + 1) * (1 << shift);
      }
      walk.leave(low, high);
      continue;
    }
    const SurfaceLattice::Brick& brick = mLattice.brick(index, walk.node);
    const Coord local(walk.node[0] & (kDim - 1), walk.node[1] & (kDim - 1), walk.node[2] & (kDim - 1));
    int bit = (local[0] << kShift | local[1]) << kShift | local[2];
    const std::uint64_t cells = brick.cells & ahead[static_cast<std::size_t>(bit)];
    if (!cells) {
      const Coord low = walk.node - local;
      walk.leave(low, low.offsetBy(kDim));
      continue;
    }
    // Visits the cells of the brick along the ray.
    double next[3], stride[3];
    int bitStep[3], stepsLeft[3];
    for (int axis = 0; axis < 3; ++axis) {
      next[axis] = (walk.node[axis] + (walk.step[axis] > 0) - walk.origin[axis]) * walk.inverse[axis];
      stride[axis] = std::abs(walk.inverse[axis]);
      bitStep[axis] = walk.step[axis] * (1 << kShift * (2 - axis));
      stepsLeft[axis] = walk.step[axis] > 0 ? kDim - 1 - local[axis] : local[axis];
    }
    for (;;) {
      const int axis = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
      const double exit = std::max(walk.time, next[axis]);
      if ((cells >> bit & 1) != 0 && hitsCell(brick, walk.node, walk.time, exit)) return true;
      walk.time = exit;
      walk.node[axis] += walk.step[axis];
      if (stepsLeft[axis]-- == 0) break;
      bit += bitStep[axis];
      next[axis] += stride[axis];
    }
  }
}

bool SurfaceTracer::hitsCell(const SurfaceLattice::Brick& brick, const Coord& node, double entry, double exit) {
  using Leaf = openvdb::FloatTree::LeafNodeType;
  constexpr int kBits = Leaf::LOG2DIM, kMask = Leaf::DIM - 1;
  const SurfaceLattice::LeafValues& leaves = mLattice.valuesOf(brick);
  const Coord local(node[0] & kMask, node[1] & kMask, node[2] & kMask);
  double corners[8];
  for (int i = 0; i < 8; ++i) {
    const int x = local[0] + (i >> 2), y = local[1] + (i >> 1 & 1), z = local[2] + (i & 1);
    const float* const values = leaves[static_cast<std::size_t>(x >> kBits << 2 | y >> kBits << 1 | z >> kBits)];
    corners[i] = values ? values[((x & kMask) << kBits | (y & kMask)) << kBits | (z & kMask)]
                        : mField.getValue((mLattice.origin() + node).offsetBy(i >> 2, i >> 1 & 1, i & 1));
  }
  const Vec3d from = mOrigin - node.asVec3d();
  const auto value = [&](double t) {
    const Vec3d p = from + t * mDirection;
    const auto mix = [](double a, double b, double w) { return a + w * (b - a); };
    const double low = mix(mix(corners[0], corners[1], p[2]), mix(corners[2], corners[3], p[2]), p[1]);
    const double high = mix(mix(corners[4], corners[5], p[2]), mix(corners[6], corners[7], p[2]), p[1]);
    return mix(low, high, p[0]);
  };

  // Along a ray the field is a cubic; a dip within a third of a cell is a graze that no picture shows.
  constexpr int kParts = 3;
  double times[kParts + 1], values[kParts + 1];
  for (int part = 0; part <= kParts; ++part) times[part] = entry + (exit - entry) * part / kParts;
  for (int part = 0; part <= kParts; ++part) values[part] = value(times[part]);
  for (int part = 0; part <= kParts; ++part) {
    if (!(values[part] < 0)) continue;
    if (mRefine)
      mHit = part == 0 ? entry : zeroBetween(times[part - 1], values[part - 1], times[part], values[part], value);
    return true;
  }
  return false;
}

}  // namespace vdbtools
