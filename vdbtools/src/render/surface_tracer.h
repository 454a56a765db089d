// SPDX-License-Identifier: Apache-2.0
/// @file surface_tracer.h
/// Rays through the surface of a level set, in index space. The surface is where the sign changes: where the trilinear
/// field between 8 nodes crosses 0.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"

#include <openvdb/math/Ray.h>

#include <optional>

namespace vdbtools {

/// The cells (the unit cubes between 8 nodes, named after their lowest node) whose corners differ in sign: all that a
/// ray can hit. @throw Interrupted
openvdb::MaskTree surfaceCells(const openvdb::FloatTree& tree, const Monitor& monitor);

/// A box and a ball around the surface.
struct SurfaceBounds {
  openvdb::BBoxd box;
  openvdb::Vec3d centre;
  double radius = 0;
};
SurfaceBounds boundsOf(const openvdb::MaskTree& cells);

/// Follows rays through the surface cells and solves for the zero of the trilinear field in each. For one thread.
class SurfaceTracer {
 public:
  SurfaceTracer(const openvdb::FloatTree& field, const openvdb::MaskTree& cells, const openvdb::BBoxd& box)
      : mField(field), mCells(cells), mBox(box) {}

  /// Where the ray first goes inside, as a multiple of its direction.
  std::optional<double> firstHit(const openvdb::Vec3d& origin, const openvdb::Vec3d& direction) {
    mRefine = true;
    return trace(origin, direction) ? std::optional(mHit) : std::nullopt;
  }
  /// Whether it goes inside anywhere.
  bool blocked(const openvdb::Vec3d& origin, const openvdb::Vec3d& direction) {
    mRefine = false;
    return trace(origin, direction);
  }

  /// The outward normal, of any length: differences over two voxels, which vary continuously where those of the
  /// trilinear field jump.
  openvdb::Vec3d normal(const openvdb::Vec3d& position) const;

  // What openvdb::math::LevelSetHDDA asks of its tester.
  using RayT = openvdb::math::Ray<double>;
  const RayT& ray() const { return mRay; }
  void setRange(double t0, double t1) { mRay.setTimes(t0, t1); }
  template <typename NodeT>
  bool hasNode(const openvdb::Coord& ijk) {
    return mCells.probeConstNode<NodeT>(ijk) != nullptr;
  }
  void init(double t0) { mEntry = t0; }
  bool operator()(const openvdb::Coord& cell, double exit) {
    const double entry = mEntry;
    mEntry = exit;
    return mCells.isValueOn(cell) && hitsCell(cell, entry, exit);
  }

 private:
  bool trace(const openvdb::Vec3d& origin, const openvdb::Vec3d& direction);
  bool hitsCell(const openvdb::Coord& cell, double entry, double exit);

  openvdb::FloatGrid::ConstAccessor mField;
  openvdb::tree::ValueAccessor<const openvdb::MaskTree> mCells;
  openvdb::BBoxd mBox;
  RayT mRay;
  double mEntry = 0, mHit = 0;
  bool mRefine = true;  ///< whether mHit is wanted
};

}  // namespace vdbtools
