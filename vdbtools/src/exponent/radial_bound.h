// SPDX-License-Identifier: Apache-2.0
/// @file radial_bound.h
/// Bounds of an exponent over balls about a point (julia/shell.h), from its values at nodes.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"

#include "julia/scalar_field.h"
#include "julia/shell.h"

#include <cstddef>
#include <utility>
#include <vector>

namespace vdbtools {

/// What is read between the nodes of a tree. Over a cell it is a polynomial, and so a mean of Bezier ordinates: with
/// trilinear reads those are the values at the cell's eight corners, and with quadratic B-splines 27 means of nodes.
/// The cell of a node begins at it, or has it in its middle, respectively.
///
/// Let u be the direction of the cell's middle, seen from the point, and s >= 0 any slope. A linear function has its
/// own values as ordinates, so E(y) - s u.y is at most the greatest ordinate T of E less that function. As u.y <= |y|,
///
///   E(y) <= T + s |y|
///
/// holds in the whole cell. With the slope of E along u it is tight where E grows away from the point, as it does where
/// the maximum over a ball lies. The bound therefore hardly depends on the number of cells across a part. Near the
/// point, where directions differ within a cell, cells are halved.
class RadialBound {
 public:
  /// @param tree    E at its active nodes; inactive ones have its sign. Must outlive this.
  /// @param origin  the point, world units
  /// @param scale   the length of a unit of fractal space, world units
  /// @param inside  an upper bound of E at inactive nodes inside; E at those outside is known to be too high to matter
  /// @param spread  an upper bound of the difference between the values of any two nodes that one read takes
  RadialBound(const openvdb::FloatTree& tree, const openvdb::math::Transform& transform, const openvdb::Vec3d& origin,
              double scale, julia::Interpolation interpolation, double inside, double spread, Monitor& monitor);

  /// The bounds in balls of up to 1, units of fractal space. @param atOrigin  the least bound of any ball
  julia::RadialMaximum maximum(double atOrigin, Monitor& monitor) const;

 private:
  struct Reach {
    const openvdb::FloatTree::LeafNodeType* leaf = nullptr;
    double nearest = 0;  ///< a lower bound of the distance to what its nodes are read for, units of fractal space
    float greatest = 0;  ///< the largest value of its nodes and its neighbours' nodes
  };
  template <int kDegree>
  void addLeaf(const Reach& reach, class PrefixMaximum& table) const;

  const openvdb::FloatTree& mTree;
  openvdb::Vec3d mZero, mAxis[3];  ///< node (0, 0, 0) from the point, and steps along the axes, units of fractal space
  julia::Interpolation mInterpolation;
  double mInside, mSpread;
  double mDiagonal;  ///< of a cell, units of fractal space
  double mStep;
  std::vector<Reach> mLeaves;  ///< the nearest first
};

}  // namespace vdbtools
