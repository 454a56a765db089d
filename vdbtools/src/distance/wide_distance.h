// SPDX-License-Identifier: Apache-2.0
/// @file wide_distance.h
/// Signed distances far from a surface, from a band around it: the further away, the coarser, so that the band's own
/// voxels are never needed there. What sweeping finds is good to a voxel of its level on both sides of a kink, and
/// better elsewhere.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/distance/target.h"

#include <span>
#include <vector>

namespace vdbtools {

/// A band on the lattice of every second node: these nodes keep their values, and @a gain more of the new voxels are
/// added on each side by fast sweeping.
openvdb::FloatGrid::Ptr coarserBand(const openvdb::FloatGrid& fine, int gain);

/// A target's phi all over a box.
class WideDistance {
 public:
  /// @param box  world units
  /// @throw DataError  a narrow band whose voxels are not cubes; Interrupted
  WideDistance(const Target& target, const openvdb::BBoxd& box, Monitor& monitor);

  /// phi[i] at points[i], world units, trilinear in the finest level that knows it (see knownDistance()); a dense
  /// target knows it everywhere (see Target). @pre both spans have one size; the points lie in the box
  void sample(std::span<const openvdb::Vec3d> points, std::span<double> phi) const;

 private:
  /// The target's grid and ever coarser ones, voxels doubled each time; the last knows the whole box.
  std::vector<openvdb::FloatGrid::ConstPtr> mLevels;
  std::optional<openvdb::CoordBBox> mDenseBox;
};

}  // namespace vdbtools
