// SPDX-License-Identifier: Apache-2.0
/// @file shadow_proxy.h
/// Casts the shadows in pictures of a map's set: a copy of the set on a few nested lattices, each finer than the one
/// around it. Following every ray to a light through the map would take a hundred times as long. A lattice whose voxels
/// are a few pixels wide is as good for shadows, and rays traverse it fast. Everything is in fractal space.
#pragma once

#include "render/surface_tracer.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"

#include "julia/evaluator.h"

#include <deque>
#include <optional>
#include <vector>

namespace vdbtools {

class ShadowProxy {
 public:
  /// The requirements of a picture: a lattice over a cube around the point that it looks at.
  struct Need {
    openvdb::BBoxd region;  ///< bounds of the set
    openvdb::Vec3d focus;   ///< the look-at point
    double reach = 0;       ///< half the side of the cube; the region is used instead if it is not much larger
    int cells = 0;          ///< voxels along the side of each cube

    bool operator==(const Need&) const = default;
  };

  /// The result is the same for any number of threads. @throw Interrupted
  ShadowProxy(const julia::FieldEvaluator& evaluator, const Need& need, Monitor& monitor);

  const Need& need() const { return mNeed; }
  /// A ball around the set, or around the region if the set is empty.
  const openvdb::Vec3d& middle() const { return mMiddle; }
  double radius() const { return mRadius; }
  /// The minimum dot product of a direction with a point of the set, up to a voxel; infinity if the set is empty.
  double lowestAlong(const openvdb::Vec3d& direction) const;

  /// For use by one thread.
  class Surface {
   public:
    explicit Surface(const ShadowProxy& proxy);

    /// The origin for rays to a light that leave a point of the set.
    /// @param view    the direction of the ray that met it, of length 1
    /// @param normal  of length 1
    openvdb::Vec3d leave(const openvdb::Vec3d& at, const openvdb::Vec3d& view, const openvdb::Vec3d& normal) const;
    bool blocked(const openvdb::Vec3d& origin, const openvdb::Vec3d& direction);

   private:
    const ShadowProxy& mProxy;
    std::vector<std::optional<SurfaceTracer>> mTracers;
  };

 private:
  struct Level {
    Level(const julia::FieldEvaluator& evaluator, const openvdb::BBoxd& box, int cells, Monitor& monitor);

    openvdb::BBoxd box;
    double voxel;
    openvdb::FloatGrid::Ptr field;  ///< -1 inside and 1 outside
    openvdb::MaskTree cells;        ///< cells where the field changes sign
    std::optional<SurfaceLattice> lattice;
  };
  /// The first level whose box contains the point, or the last.
  std::size_t levelAt(const openvdb::Vec3d& at) const;

  Need mNeed;
  std::deque<Level> mLevels;  ///< from fine to coarse; the box of the last is the region
  openvdb::Vec3d mMiddle;
  double mRadius = 0;
};

}  // namespace vdbtools
