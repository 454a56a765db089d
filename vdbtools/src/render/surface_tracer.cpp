// SPDX-License-Identifier: Apache-2.0
#include "render/surface_tracer.h"

#include <openvdb/math/DDA.h>
#include <openvdb/tools/Interpolation.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace vdbtools {

using openvdb::Coord;
using openvdb::Vec3d;

namespace {

/// The surface cells, found from signs alone: the field of a rough fractal changes too fast for a test of its values.
/// That is why tools::LevelSetRayIntersector, which skips values beyond two voxels, leaves holes there.
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
  openvdb::MaskTree& cells() { return mCells; }

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
      // The leaf before this one may not exist, and then nothing else looks at this edge.
      if (local[axis] == 0 && (field.getValue(previous) < 0) != inside) markEdge(previous, axis, cells);
    }
  }

  /// The four cells around the edge that leaves @a node along @a axis.
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
  constexpr int kSteps = 4;  // of the false position rule, from a third of a cell
  double t = t1;
  for (int i = 0; i < kSteps && v0 != v1; ++i) {
    t = t0 + (t1 - t0) * v0 / (v0 - v1);
    const double v = value(t);
    (v < 0 ? t1 : t0) = t;
    (v < 0 ? v1 : v0) = v;
  }
  return t;
}

}  // namespace

openvdb::MaskTree surfaceCells(const openvdb::FloatTree& tree, const Monitor& monitor) {
  std::vector<const SurfaceCells::Leaf*> leaves;
  tree.getNodes(leaves);
  SurfaceCells work(tree, leaves, monitor);
  tbb::parallel_reduce(tbb::blocked_range<std::size_t>(0, leaves.size()), work);
  return std::move(work.cells());
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
  bounds.radius = std::sqrt(bounds.radius) + 0.5;  // half a cell: the surface is somewhere in it
  return bounds;
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
  constexpr int kUpperNodes = openvdb::MaskTree::RootNodeType::ChildNodeType::LEVEL;
  mRay = RayT(origin, direction);
  return mRay.clip(mBox) && openvdb::math::LevelSetHDDA<openvdb::MaskTree, kUpperNodes>::test(*this);
}

bool SurfaceTracer::hitsCell(const Coord& cell, double entry, double exit) {
  double corners[8];
  for (int i = 0; i < 8; ++i) corners[i] = mField.getValue(cell.offsetBy(i >> 2, (i >> 1) & 1, i & 1));
  const auto value = [&](double t) {
    const Vec3d p = mRay(t) - cell.asVec3d();
    const auto mix = [](double a, double b, double w) { return a + w * (b - a); };
    const double low = mix(mix(corners[0], corners[1], p[2]), mix(corners[2], corners[3], p[2]), p[1]);
    const double high = mix(mix(corners[4], corners[5], p[2]), mix(corners[6], corners[7], p[2]), p[1]);
    return mix(low, high, p[0]);
  };

  // Along a ray the field is a cubic; a dip between thirds is a graze that no picture shows.
  constexpr int kParts = 3;
  double before = entry, vBefore = value(entry);
  mHit = entry;
  if (vBefore < 0) return true;
  for (int part = 1; part <= kParts; ++part) {
    const double t = entry + (exit - entry) * part / kParts;
    const double v = value(t);
    if (v < 0) {
      if (mRefine) mHit = zeroBetween(before, vBefore, t, v, value);
      return true;
    }
    before = t, vBefore = v;
  }
  return false;
}

}  // namespace vdbtools
