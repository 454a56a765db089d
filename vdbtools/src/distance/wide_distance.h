// SPDX-License-Identifier: Apache-2.0
/// @file wide_distance.h
/// Signed distances far from a surface, computed from a band around it: the farther away, the coarser, so the band's
/// own resolution is never needed there. The results of sweeping are accurate to a voxel of their level on both sides
/// of a kink, and better elsewhere.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/distance/target.h"

#include <span>
#include <vector>

namespace vdbtools {

/// Restricts a band to the lattice of every second node, where nodes keep their values, and adds @a gain of the new
/// voxels on each side by fast sweeping.
openvdb::FloatGrid::Ptr coarserBand(const openvdb::FloatGrid& fine, int gain);

/// A target's phi, known in a whole box.
class WideDistance {
 public:
  /// @param box  world units
  /// @throw DataError  a narrow band whose voxels are not cubes; Interrupted
  WideDistance(const Target& target, const openvdb::BBoxd& box, Monitor& monitor);

  /// Sets phi[i] at points[i], world units, trilinear in the finest level that is known there (see knownDistance()); a
  /// dense target is known everywhere (see Target). @pre both spans have the same size; the points lie in the box
  void sample(std::span<const openvdb::Vec3d> points, std::span<double> phi) const;

 private:
  /// The target's grid and increasingly coarse ones, whose voxels double each time; the last is known in the whole box.
  std::vector<openvdb::FloatGrid::ConstPtr> mLevels;
  std::optional<openvdb::CoordBBox> mDenseBox;
};

}  // namespace vdbtools
