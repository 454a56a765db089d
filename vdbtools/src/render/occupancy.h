// SPDX-License-Identifier: Apache-2.0
/// @file occupancy.h
/// The cubes of a region that are proved to be outside the set, so that rays can skip them.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"

#include "julia/evaluator.h"

#include <cstdint>
#include <vector>

namespace vdbtools {

/// All in fractal space.
class Occupancy {
 public:
  /// @param cells  cubes along the longest side of the box
  Occupancy(const julia::FieldEvaluator& evaluator, const openvdb::BBoxd& box, int cells, Monitor& monitor);

  openvdb::Coord count() const { return mCount; }  ///< cubes along the axes of the box, rounded up
  double cell() const { return mCell; }            ///< the side of a cube
  /// Whether the set may be in a cube.
  bool holds(const openvdb::Coord& cube) const { return mCells.isValueOn(cube); }

  /// For devices, as julia::RayMarch::occupied.
  std::vector<std::uint32_t> bits() const;
  const openvdb::Vec3d& origin() const { return mOrigin; }

  /// For use by one thread.
  class Walker {
   public:
    explicit Walker(const Occupancy& occupancy)
        : mOrigin(occupancy.mOrigin), mCell(occupancy.mCell), mPerCell(1 / occupancy.mCell), mCells(occupancy.mCells) {}

    /// The interval of a ray from @a t onwards over which it is constant whether the set may be there.
    struct Span {
      bool occupied;
      double end;  ///< > t
    };
    Span at(const openvdb::Vec3d& eye, const openvdb::Vec3d& direction, double t);

   private:
    openvdb::Vec3d mOrigin;
    double mCell, mPerCell;
    openvdb::tree::ValueAccessor<const openvdb::MaskTree> mCells;
  };

 private:
  openvdb::Vec3d mOrigin;  ///< the corner of cube (0, 0, 0)
  double mCell = 0;        ///< side of a cube
  openvdb::Coord mCount;
  openvdb::MaskTree mCells;
};

}  // namespace vdbtools
