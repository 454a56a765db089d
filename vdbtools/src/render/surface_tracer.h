// SPDX-License-Identifier: Apache-2.0
/// @file surface_tracer.h
/// Intersects rays with the surface of a level set, in index space. The surface is where the sign changes: where the
/// trilinear field between 8 nodes crosses 0.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace vdbtools {

/// Finds the cells whose corners differ in sign, which are all that a ray can hit. A cell is the unit cube between 8
/// nodes, named after its lowest node. @throw Interrupted
openvdb::MaskTree surfaceCells(const openvdb::FloatTree& tree, const Monitor& monitor);

/// A box and a ball around the surface.
struct SurfaceBounds {
  openvdb::BBoxd box;
  openvdb::Vec3d centre;
  double radius = 0;
};
SurfaceBounds boundsOf(const openvdb::MaskTree& cells);
/// The minimum dot product of a direction with the cells' corners; infinity if there are none.
double lowestCorner(const openvdb::Vec3d& direction, const openvdb::MaskTree& cells);

/// The surface cells in bricks of 4 x 4 x 4, and a lattice of cubes that tells how far a ray can go before it can meet
/// a brick. Nodes are relative to origin() here. Any number of threads may use it.
class SurfaceLattice {
 public:
  /// @param field  must outlive this
  SurfaceLattice(const openvdb::FloatTree& field, const openvdb::MaskTree& cells);

  static constexpr int kBrickShift = 2;

  struct Brick {
    std::uint64_t cells = 0;  ///< bit 16 x + 4 y + z
    std::uint32_t leaf = 0;
  };
  /// The values of the field's leaf, 512 nodes, and of its neighbours towards higher z (bit 0), y (bit 1) and x (bit
  /// 2); null if the field has no leaf there.
  using LeafValues = std::array<const float*, 8>;

  const openvdb::FloatTree& field() const { return mField; }
  const openvdb::Coord& origin() const { return mOrigin; }
  /// The number of cubes along each axis.
  const openvdb::Coord& size() const { return mSize; }
  /// The binary logarithm of a cube's side.
  int shift() const { return mShift; }

  /// Valid for cubes of the lattice and their neighbours.
  std::size_t indexOf(const openvdb::Coord& cube) const {
    return static_cast<std::size_t>(((cube[0] + 1) * mStrides[0]) + ((cube[1] + 1) * mStrides[1]) + cube[2] + 1);
  }
  /// For each cube, the number of cubes along each axis, from this one on towards an octant, that are free of bricks; 0
  /// if the cube itself contains one. @param octant  bits 0, 1 and 2 are set for decreasing x, y and z
  const std::vector<std::uint8_t>& freeCubes(int octant) const { return mFree[static_cast<std::size_t>(octant)]; }

  /// @param cube  the index of a cube that contains a brick
  const Brick& brick(std::size_t cube, const openvdb::Coord& node) const {
    const int mask = (1 << mShift) - 1, bits = mShift - kBrickShift;
    const int x = (node[0] & mask) >> kBrickShift, y = (node[1] & mask) >> kBrickShift,
              z = (node[2] & mask) >> kBrickShift;
    return mBricks[mFirstBrick[cube] + static_cast<std::size_t>(((x << bits | y) << bits) | z)];
  }
  const LeafValues& valuesOf(const Brick& brick) const { return mLeaves[brick.leaf]; }

 private:
  void addLeaf(const openvdb::MaskTree::LeafNodeType& leaf);
  void measureFreeCubes(int octant);

  const openvdb::FloatTree& mField;
  openvdb::Coord mOrigin, mSize;
  std::array<std::int64_t, 2> mStrides{};  ///< strides of x and y, with a layer of cubes around the lattice
  int mShift = kBrickShift;
  std::array<std::vector<std::uint8_t>, 8> mFree;
  std::vector<std::uint32_t> mFirstBrick;  ///< index in mBricks for each cube that contains any
  std::vector<Brick> mBricks;
  std::vector<LeafValues> mLeaves;
};

/// Follows rays through the surface cells and solves for the zero of the trilinear field in each. For use by one
/// thread.
class SurfaceTracer {
 public:
  /// @param lattice  must outlive this
  explicit SurfaceTracer(const SurfaceLattice& lattice) : mLattice(lattice), mField(lattice.field()) {}

  /// Where the ray first enters the inside, as a multiple of its direction.
  std::optional<double> firstHit(const openvdb::Vec3d& origin, const openvdb::Vec3d& direction) {
    mRefine = true;
    return trace(origin, direction) ? std::optional(mHit) : std::nullopt;
  }
  /// Whether the ray enters the inside anywhere.
  bool blocked(const openvdb::Vec3d& origin, const openvdb::Vec3d& direction) {
    mRefine = false;
    return trace(origin, direction);
  }

  /// The outward normal, of any length, from differences over two voxels. These are continuous, unlike the
  /// derivatives of the trilinear field, which jump between voxels.
  openvdb::Vec3d normal(const openvdb::Vec3d& position) const;

 private:
  bool trace(const openvdb::Vec3d& origin, const openvdb::Vec3d& direction);
  bool hitsCell(const SurfaceLattice::Brick& brick, const openvdb::Coord& cell, double entry, double exit);

  const SurfaceLattice& mLattice;
  openvdb::FloatGrid::ConstAccessor mField;

  openvdb::Vec3d mOrigin, mDirection;  ///< of the ray, relative to the lattice's origin
  double mHit = 0;
  bool mRefine = true;  ///< whether mHit is needed
};

}  // namespace vdbtools
