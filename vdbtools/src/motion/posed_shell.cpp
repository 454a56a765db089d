// SPDX-License-Identifier: Apache-2.0
#include "motion/posed_shell.h"

#include "base/affine_columns.h"
#include "base/in_parallel.h"
#include "base/lattice_field.h"
#include "distance/leaves.h"
#include "search/triangle_tree.h"

#include "julia/norm_bound.h"

#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/SignedFloodFill.h>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

using julia::Decision;
using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::Mat3d;
using openvdb::Vec3d;
using openvdb::Vec3s;

/// What is known of a cell of the lattice. A cell over which rho is interpolated has a bound of its slope instead.
constexpr float kOutside = -1, kInside = -2, kJumps = -3;
/// What the plan knows of a cell. Cells that are far from the shell have the sign of the pose's distances.
constexpr float kFar = 0, kUndecided = 1, kDecidedInside = 2, kDecidedOutside = 3;

/// Numbers for a box of lattice cells, and their extremes over blocks of cells.
class CellTable {
 public:
  CellTable(const CoordBBox& cells, float elsewhere) : mCells(cells), mSize(cells.dim()), mElsewhere(elsewhere) {
    mValues.assign(
        static_cast<std::size_t>(mSize[0]) * static_cast<std::size_t>(mSize[1]) * static_cast<std::size_t>(mSize[2]),
        elsewhere);
  }

  const CoordBBox& cells() const { return mCells; }
  float& at(const Coord& cell) { return mValues[index(cell)]; }
  float at(const Coord& cell) const { return mCells.isInside(cell) ? mValues[index(cell)] : mElsewhere; }

  struct Extremes {
    float least = std::numeric_limits<float>::infinity(), most = -std::numeric_limits<float>::infinity();
    void meet(float value) {
      least = std::min(least, value);
      most = std::max(most, value);
    }
    void meet(const Extremes& other) {
      least = std::min(least, other.least);
      most = std::max(most, other.most);
    }
  };

  void finish() {
    const Coord blocks = (mSize + Coord(kBlockSide - 1)) >> kLog2;
    mBlockSize = blocks;
    mBlocks.assign(
        static_cast<std::size_t>(blocks[0]) * static_cast<std::size_t>(blocks[1]) * static_cast<std::size_t>(blocks[2]),
        {});
    for (int x = 0; x < mSize[0]; ++x)
      for (int y = 0; y < mSize[1]; ++y)
        for (int z = 0; z < mSize[2]; ++z)
          mBlocks[blockIndex(Coord(x, y, z) >> kLog2)].meet(mValues[index(mCells.min() + Coord(x, y, z))]);
  }

  /// Bounds of the values in a box of cells.
  Extremes over(CoordBBox box) const {
    Extremes result;
    if (!mCells.isInside(box)) {
      result.meet(mElsewhere);
      box.intersect(mCells);
      if (box.empty()) return result;
    }
    constexpr int kFew = 6;
    const Coord dim = box.dim(), first = box.min() - mCells.min(), last = box.max() - mCells.min();
    if (std::max({dim[0], dim[1], dim[2]}) <= kFew) {
      for (int x = box.min()[0]; x <= box.max()[0]; ++x)
        for (int y = box.min()[1]; y <= box.max()[1]; ++y)
          for (int z = box.min()[2]; z <= box.max()[2]; ++z) result.meet(mValues[index(Coord(x, y, z))]);
      return result;
    }
    for (int x = first[0] >> kLog2; x <= last[0] >> kLog2; ++x)
      for (int y = first[1] >> kLog2; y <= last[1] >> kLog2; ++y)
        for (int z = first[2] >> kLog2; z <= last[2] >> kLog2; ++z) result.meet(mBlocks[blockIndex(Coord(x, y, z))]);
    return result;
  }

 private:
  static constexpr int kLog2 = 2, kBlockSide = 1 << kLog2;

  std::size_t index(const Coord& cell) const {
    const Coord at = cell - mCells.min();
    return (static_cast<std::size_t>(at[0]) * static_cast<std::size_t>(mSize[1]) + static_cast<std::size_t>(at[1])) *
               static_cast<std::size_t>(mSize[2]) +
           static_cast<std::size_t>(at[2]);
  }
  std::size_t blockIndex(const Coord& at) const {
    return (static_cast<std::size_t>(at[0]) * static_cast<std::size_t>(mBlockSize[1]) +
            static_cast<std::size_t>(at[1])) *
               static_cast<std::size_t>(mBlockSize[2]) +
           static_cast<std::size_t>(at[2]);
  }

  CoordBBox mCells;
  Coord mSize, mBlockSize{};
  float mElsewhere;
  std::vector<float> mValues;
  std::vector<Extremes> mBlocks;
};

/// From points of fractal space to the lattice's index space, and to points of fractal space by the overall map.
struct PoseSpace {
  PoseSpace(const FractalSpace& space, const openvdb::math::Transform& lattice, const AffineMap& overall) {
    const AffineColumns index = affineColumns([&](const Vec3d& x) {
      return lattice.worldToIndex(space.toWorld({x[0], x[1], x[2]}));
    });
    toIndex.offset = index.offset;
    for (int axis = 0; axis < 3; ++axis) toIndex.matrix.setCol(axis, index.columns[static_cast<std::size_t>(axis)]);
    overallMap = {overall.matrix, (overall(space.centre) - space.centre) / space.scale};
  }

  AffineMap toIndex, overallMap;
};

Vec3d vectorOf(const julia::Point& x) { return {x[0], x[1], x[2]}; }
julia::Point pointOf(const Vec3d& x) { return {x[0], x[1], x[2]}; }

double normBoundOf(const Mat3d& m) {
  std::array<std::array<double, 3>, 3> columns{};
  for (std::size_t column = 0; column < 3; ++column)
    for (std::size_t row = 0; row < 3; ++row) columns[column][row] = m(static_cast<int>(row), static_cast<int>(column));
  return julia::normBound(columns);
}

class PoseDeformation final : public julia::Deformation {
 public:
  using Field = std::shared_ptr<const julia::ScalarField<double>>;

  PoseDeformation(const PoseSpace& pose, const FractalSpace& space, CellTable cells, std::array<Field, 3> beyond,
                  std::shared_ptr<const SurfaceMotion> motion)
      : mPose(pose),
        mSpace(space),
        mCells(std::move(cells)),
        mBeyond(std::move(beyond)),
        mMotion(std::move(motion)),
        mIndexStretch(normBoundOf(mPose.toIndex.matrix)) {}

  void carry(std::span<const julia::Point> points, std::span<julia::Point> carried,
             std::span<Decision> decisions) const override {
    std::vector<std::size_t> smooth;
    smooth.reserve(points.size());
    std::optional<std::uint32_t> hint;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const float cell = mCells.at(Coord::floor(mPose.toIndex(vectorOf(points[i]))));
      decisions[i] = Decision::Undecided;
      if (cell >= 0) {
        smooth.push_back(i);
      } else if (cell == kJumps) {
        const SurfaceMotion::Image image = mMotion->carry(mSpace.toWorld(points[i]), hint);
        carried[i] = mSpace.toFractal(image.at);
        hint = image.hint;
      } else {
        decisions[i] = cell == kInside ? Decision::Inside : Decision::Outside;
      }
    }
    interpolate(points, smooth, carried);
  }

  void images(std::span<const julia::Point> centres, double radius, std::span<Image> images) const override {
    constexpr double kSlack = 1e-6;
    std::vector<std::size_t> smooth;
    std::vector<julia::Point> carried(centres.size());
    const Vec3d reach(radius * mIndexStretch * (1 + kSlack) + kSlack);
    for (std::size_t i = 0; i < centres.size(); ++i) {
      images[i] = {.radius = std::numeric_limits<double>::infinity()};
      const Vec3d at = mPose.toIndex(vectorOf(centres[i]));
      const CellTable::Extremes over = mCells.over({Coord::floor(at - reach), Coord::floor(at + reach)});
      if (over.least >= 0) {
        smooth.push_back(i);
        images[i].radius = double{over.most} * radius * (1 + kSlack);
      } else if (over.least == over.most && over.least != kJumps) {
        images[i].decision = over.least == kInside ? Decision::Inside : Decision::Outside;
      }
    }
    interpolate(centres, smooth, carried);
    for (const std::size_t i : smooth) {
      images[i].centre = carried[i];
      const Vec3d size = vectorOf(carried[i]);
      images[i].radius += kRounding * (1 + size.length());
    }
  }

 private:
  static constexpr double kRounding = 1e-12;  ///< of positions in fractal space

  /// @param which  numbers of points in cells over which rho is interpolated
  void interpolate(std::span<const julia::Point> points, const std::vector<std::size_t>& which,
                   std::span<julia::Point> carried) const {
    if (which.empty()) return;
    std::array<std::vector<double>, 3> at;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      at[axis].resize(which.size());
      for (std::size_t k = 0; k < which.size(); ++k) at[axis][k] = points[which[k]][axis];
    }
    for (const std::size_t i : which) carried[i] = pointOf(mPose.overallMap(vectorOf(points[i])));
    std::vector<double> beyond(which.size());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      mBeyond[axis]->sample(at[0], at[1], at[2], beyond);
      for (std::size_t k = 0; k < which.size(); ++k) carried[which[k]][axis] += beyond[k];
    }
  }

  PoseSpace mPose;
  FractalSpace mSpace;
  CellTable mCells;
  std::array<Field, 3> mBeyond;  ///< what rho adds to the overall map, fractal space
  std::shared_ptr<const SurfaceMotion> mMotion;
  double mIndexStretch;
};

/// rho at a node, in units of fractal space.
struct NodeImage {
  Vec3s beyond;                 ///< what rho adds to the overall map
  std::array<Vec3s, 3> beside;  ///< what that grows by to the next node along each axis, as the gradient says
};

/// rho at the nodes of a leaf of the pose's distances.
struct LeafImages {
  std::array<NodeImage, 512> nodes;  ///< those that are known; of the others, 24 kB in each leaf, nothing is written
  std::array<bool, 512> known{};
};

/// Leaves out the triangles that lie inside the solid altogether: others cover them.
void hideCovered(SurfaceMotion& motion, const Target& pose) {
  constexpr double kDeep = 1.5;  // voxels
  const double deep = -kDeep * pose.phi->voxelSize()[0];
  const auto accessor = pose.phi->getConstAccessor();
  const std::vector<Vec3d> points = motion.points();
  std::vector<bool> isDeep(points.size());
  for (std::size_t i = 0; i < isDeep.size(); ++i)
    isDeep[i] =
        static_cast<double>(openvdb::tools::BoxSampler::sample(accessor, pose.phi->worldToIndex(points[i]))) < deep;
  std::vector<std::uint32_t> shown;
  for (std::size_t i = 0; i < motion.triangles().size(); ++i) {
    const openvdb::Vec3I& t = motion.triangles()[i];
    if (!(isDeep[t[0]] && isDeep[t[1]] && isDeep[t[2]])) shown.push_back(static_cast<std::uint32_t>(i));
  }
  if (!shown.empty() && shown.size() < motion.triangles().size()) motion.showOnly(shown);
}

/// Sets the cells in blocks of the lattice that have no leaf, and whose distances are negative.
void fillInside(CellTable& cells, const FloatGrid& phi) {
  const auto distances = phi.getConstAccessor();
  const CoordBBox blocks(cells.cells().min() >> 3, cells.cells().max() >> 3);
  for (auto block = blocks.begin(); block; ++block) {
    const Coord origin = *block << 3;
    if (distances.probeConstLeaf(origin) || !(distances.getValue(origin) < 0)) continue;
    for (auto cell = CoordBBox::createCube(origin, 8).begin(); cell; ++cell) cells.at(*cell) = kInside;
  }
}

constexpr int kCorners = 8;

/// The corners of a cell: bit 2 of the number is x, bit 0 is z.
Coord corner(const Coord& cell, int k) { return cell + Coord(k >> 2 & 1, k >> 1 & 1, k & 1); }

/// The place of a node in nodesAround(). @param local  from the origin of the leaf, 0 to 8
std::size_t aroundIndex(const Coord& local) {
  return static_cast<std::size_t>((local[0] * 9 + local[1]) * 9 + local[2]);
}

/// The nodes of a leaf's cells, 9 along each axis; nullptr where rho is not known.
/// @param numberOf  of the leaf at an origin, or negative
std::vector<const NodeImage*> nodesAround(const Coord& origin,
                                          const openvdb::tree::ValueAccessor<const openvdb::Int32Tree>& numberOf,
                                          const std::vector<std::unique_ptr<LeafImages>>& images) {
  std::vector<const NodeImage*> nodes(9 * 9 * 9, nullptr);
  for (int k = 0; k < kCorners; ++k) {
    const Coord leaf = corner(Coord(0), k);
    const std::int32_t number = numberOf.getValue(origin + Coord(leaf[0] << 3, leaf[1] << 3, leaf[2] << 3));
    if (number < 0) continue;
    const LeafImages& known = *images[static_cast<std::size_t>(number)];
    for (int x = 0; x < (leaf[0] ? 1 : 8); ++x)
      for (int y = 0; y < (leaf[1] ? 1 : 8); ++y)
        for (int z = 0; z < (leaf[2] ? 1 : 8); ++z) {
          const auto at = static_cast<std::size_t>(x << 6 | y << 3 | z);
          if (known.known[at])
            nodes[aroundIndex(Coord(x + 8 * leaf[0], y + 8 * leaf[1], z + 8 * leaf[2]))] = &known.nodes[at];
        }
  }
  return nodes;
}

/// What is known of a cell whose corners all have images.
struct CellImage {
  bool jumps = false;
  double slope = 0;  ///< a bound of that of rho
  Vec3d centre;      ///< the image of its centre, less that by the overall map
};

/// @param step  the side of the cell, fractal space
CellImage cellImage(const std::array<const NodeImage*, kCorners>& corners, const Mat3d& overall, double step) {
  constexpr double kJump = 2;  // edges by which rho may differ from what its gradients say
  constexpr double kUp = 1 + 1e-5;
  CellImage image{.centre = Vec3d(0)};
  // What rho does along each axis from a node to the next one: the mean, and the largest difference from it.
  Mat3d mean = overall;
  double apart = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int bit = 4 >> axis;
    const auto tolerance =
        static_cast<float>(kJump * kJump * std::max(1., overall.col(axis).lengthSqr()) * step * step);
    std::array<Vec3s, 4> steps;
    Vec3s sum(0);
    std::size_t count = 0;
    for (int k = 0; k < kCorners; ++k) {
      if (k & bit) continue;
      const NodeImage &a = *corners[static_cast<std::size_t>(k)], &b = *corners[static_cast<std::size_t>(k | bit)];
      const Vec3s went = b.beyond - a.beyond;
      for (const NodeImage* node : {&a, &b})
        image.jumps |= !((went - node->beside[static_cast<std::size_t>(axis)]).lengthSqr() <= tolerance);
      steps[count++] = went;
      sum += went;
    }
    const Vec3s middle = sum * 0.25f;
    float most = 0;
    for (const Vec3s& one : steps) most = std::max(most, (one - middle).lengthSqr());
    mean.setCol(axis, mean.col(axis) + Vec3d(middle) / step);
    apart += static_cast<double>(most) / (step * step);
  }
  image.slope = (normBoundOf(mean) + std::sqrt(apart)) * kUp;
  for (const NodeImage* node : corners) image.centre += Vec3d(node->beyond) * 0.125;
  return image;
}

/// rho at the nodes of the pose's distances that the shell may reach, and what follows for the cells.
class PoseLattice {
 public:
  PoseLattice(const ExponentGrid& exponent, const FloatGrid& phi, const SurfaceMotion& motion, const DetailReach& reach,
              Monitor& monitor)
      : mPhi(phi),
        mFractal(exponent.space),
        mVoxel(phi.voxelSize()[0]),
        mStep(mVoxel / exponent.space.scale),
        mSpace(exponent.space, phi.transform(), motion.overall()),
        mLeaves(leavesOf(phi.tree())),
        mImages(mLeaves.size()) {
    for (const auto* leaf : mLeaves) mNodes.expand(leaf->getNodeBoundingBox());
    constexpr double kMargin = 2;  // voxels
    const double growth = motion.greatestGrowth();
    carryNodes(motion, growth * reach.outside + kMargin * mVoxel, growth * reach.inside + kMargin * mVoxel, monitor);
    constexpr unsigned kLeafLevel = 1;  // of a tile as large as a leaf
    for (std::size_t i = 0; i < mLeaves.size(); ++i)
      if (mImages[i]) mNumbers.addTile(kLeafLevel, mLeaves[i]->origin(), static_cast<std::int32_t>(i), true);
  }

  const CoordBBox& nodes() const { return mNodes; }
  const PoseSpace& space() const { return mSpace; }

  /// Sets the state of each cell, and what the plan knows of it.
  void decide(const julia::ScalarField<double>& exponent, const julia::ShellInterval& shell, CellTable& cells,
              CellTable& decided, Monitor& monitor) const {
    inParallel(mLeaves.size(), 1, monitor, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) decideLeaf(*mLeaves[i], exponent, shell, cells, decided);
    });
  }

  /// What rho adds to the overall map, in the form in which it is read.
  std::array<PoseDeformation::Field, 3> beyond() const {
    std::array<PoseDeformation::Field, 3> fields;
    for (int axis = 0; axis < 3; ++axis) {
      const FloatGrid::Ptr grid = FloatGrid::create(0.0f);
      grid->setTransform(mPhi.transform().copy());
      for (std::size_t i = 0; i < mLeaves.size(); ++i) {
        if (!mImages[i]) continue;
        auto* const leaf = grid->tree().touchLeaf(mLeaves[i]->origin());
        for (unsigned offset = 0; offset < 512; ++offset)
          if (mImages[i]->known[offset]) leaf->setValueOn(offset, mImages[i]->nodes[offset].beyond[axis]);
      }
      fields[static_cast<std::size_t>(axis)] =
          makeLatticeField<double>(*grid, mNodes, mFractal, julia::Interpolation::Trilinear);
    }
    return fields;
  }

 private:
  using Leaf = openvdb::FloatTree::LeafNodeType;

  Vec3d toFractal(const Vec3d& world) const { return vectorOf(mFractal.toFractal(world)); }

  /// @param outside, inside  how far from the surface, world units
  void carryNodes(const SurfaceMotion& motion, double outside, double inside, Monitor& monitor) {
    constexpr std::size_t kMostFrames = 2'000'000;  // triangles
    std::vector<Vec3d> points = motion.points();
    for (Vec3d& point : points) point = mPhi.worldToIndex(point);
    const TriangleTree tree(
        points, motion.triangles(), {},
        motion.triangles().size() > kMostFrames ? TriangleTree::Frames::ForEachBlock : TriangleTree::Frames::Once);
    tbb::enumerable_thread_specific<BlockDistances> nearest([&] { return BlockDistances(tree); });
    inParallel(mLeaves.size(), 1, monitor, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        mImages[i] = carriedLeaf(*mLeaves[i], motion, outside, inside, nearest.local());
    });
  }

  /// @return nullptr if no node of the leaf is near enough
  std::unique_ptr<LeafImages> carriedLeaf(const Leaf& leaf, const SurfaceMotion& motion, double outside, double inside,
                                          BlockDistances& nearest) const {
    // Distances to a solid that was mended may differ from those to its mesh.
    constexpr float kMended = 8;
    std::array<bool, 512> wanted;
    float far = -1;
    for (unsigned offset = 0; offset < 512; ++offset) {
      const double distance = static_cast<double>(leaf.getValue(offset));
      wanted[offset] = leaf.isValueOn(offset) && distance <= outside && -distance <= inside;
      if (wanted[offset]) far = std::max(far, static_cast<float>(std::abs(distance) / mVoxel));
    }
    if (far < 0) return nullptr;
    nearest.evaluate(leaf.origin(), far + kMended);
    auto images = std::make_unique_for_overwrite<LeafImages>();
    for (unsigned offset = 0; offset < 512; ++offset) {
      if (!wanted[offset]) continue;
      const Vec3d world = mPhi.indexToWorld(leaf.offsetToGlobalCoord(offset));
      const SurfaceMotion::Image image = std::isfinite(nearest.distances()[offset])
                                             ? motion.carryBy(nearest.triangles()[offset], world)
                                             : motion.carry(world);
      images->known[offset] = true;
      NodeImage& node = images->nodes[offset];
      node.beyond = Vec3s(toFractal(image.at) - mSpace.overallMap(toFractal(world)));
      for (int axis = 0; axis < 3; ++axis)
        node.beside[static_cast<std::size_t>(axis)] =
            Vec3s((image.gradient.col(axis) - mSpace.overallMap.matrix.col(axis)) * mStep);
    }
    return images;
  }

  void decideLeaf(const Leaf& leaf, const julia::ScalarField<double>& exponent, const julia::ShellInterval& shell,
                  CellTable& cells, CellTable& decided) const {
    const openvdb::tree::ValueAccessor<const openvdb::Int32Tree> numberOf(mNumbers);
    const auto distances = mPhi.getConstAccessor();
    const std::vector<const NodeImage*> around = nodesAround(leaf.origin(), numberOf, mImages);
    std::vector<std::array<double, 3>> centres;
    std::vector<double> radii;
    std::vector<Coord> smooth;
    for (unsigned offset = 0; offset < 512; ++offset) {
      const Coord cell = leaf.offsetToGlobalCoord(offset);
      std::array<const NodeImage*, kCorners> corners;
      bool isKnown = true, isInside = false;
      for (int k = 0; k < kCorners; ++k) {
        const Coord node = corner(cell, k);
        const NodeImage* const image = around[aroundIndex(node - leaf.origin())];
        corners[static_cast<std::size_t>(k)] = image;
        if (image) continue;
        isKnown = false;
        isInside |= distances.getValue(node) < 0;
      }
      float& state = cells.at(cell);
      if (!isKnown) {
        state = isInside ? kInside : kOutside;
        continue;
      }
      const CellImage image = cellImage(corners, mSpace.overallMap.matrix, mStep);
      if (image.jumps) {
        state = kJumps;
        decided.at(cell) = kUndecided;
        continue;
      }
      state = static_cast<float>(image.slope);
      const Vec3d middle = mPhi.indexToWorld(cell.asVec3d() + Vec3d(0.5));
      centres.push_back(pointOf(image.centre + mSpace.overallMap(toFractal(middle))));
      radii.push_back(image.slope * mStep * std::sqrt(0.75) * (1 + 1e-5));
      smooth.push_back(cell);
    }
    std::vector<julia::ValueRange> ranges(smooth.size());
    exponent.ranges(centres, radii, ranges);
    for (std::size_t k = 0; k < smooth.size(); ++k)
      decided.at(smooth[k]) = ranges[k].high <= shell.lower  ? kDecidedInside
                              : ranges[k].low >= shell.upper ? kDecidedOutside
                                                             : kUndecided;
  }

  const FloatGrid& mPhi;
  FractalSpace mFractal;
  double mVoxel, mStep;  ///< the side of a cell: world units, fractal space
  PoseSpace mSpace;
  std::vector<const Leaf*> mLeaves;
  CoordBBox mNodes;
  std::vector<std::unique_ptr<LeafImages>> mImages;
  openvdb::Int32Tree mNumbers{-1};  ///< of the leaves with images, as tiles
};

/// Values of the nodes of the plan's grid.
constexpr float kPlanned = 2, kPlanEnd = 1;

/// The grid of a plan: 0 at the corners of undecided cells, elsewhere of the sign of F.
FloatGrid::Ptr plannedGrid(const FloatGrid& phi, const CellTable& decided) {
  const auto tree = std::make_shared<openvdb::FloatTree>(phi.tree(), kPlanned, openvdb::TopologyCopy());
  std::vector<openvdb::FloatTree::LeafNodeType*> leaves;
  tree->getNodes(leaves);
  const std::vector<const openvdb::FloatTree::LeafNodeType*> distances = leavesOf(phi.tree());
  tbb::parallel_for(std::size_t{0}, leaves.size(), [&](std::size_t i) {
    for (auto value = leaves[i]->beginValueOn(); value; ++value) {
      const Coord node = value.getCoord();
      bool isIn = false, isOut = false, isUndecided = false;
      for (int k = 0; k < kCorners; ++k) {
        const float cell = decided.at(corner(node, k) - Coord(1));
        isUndecided |= cell == kUndecided;
        isIn |= cell == kDecidedInside;
        isOut |= cell == kDecidedOutside;
      }
      const bool isInside = isIn || (!isOut && distances[i]->getValue(value.pos()) < 0);
      value.setValue(isUndecided || (isIn && isOut) ? 0 : isInside ? -kPlanned : kPlanned);
    }
  });
  openvdb::tools::signedFloodFillWithValues(*tree, kPlanned, -kPlanned);
  const FloatGrid::Ptr plan = FloatGrid::create(tree);
  plan->setTransform(phi.transform().copy());
  return plan;
}

/// The part of the undecided cells over which rho jumps.
double jumpsIn(const CellTable& cells, const CellTable& decided) {
  std::uint64_t undecided = 0, jumping = 0;
  for (auto cell = cells.cells().begin(); cell; ++cell) {
    if (decided.at(*cell) != kUndecided) continue;
    ++undecided;
    jumping += cells.at(*cell) == kJumps;
  }
  return undecided > 0 ? static_cast<double>(jumping) / static_cast<double>(undecided) : 0;
}

}  // namespace

DetailReach reachAtRest(const ExponentGrid& exponent, const Target& atRest) {
  // Cells that are undecided may have decided corners, which lie at most a cell's diagonal away.
  const double diagonal = std::sqrt(3.) * exponent.grid->voxelSize()[0];
  const julia::ShellInterval& shell = exponent.shellOfNodes;
  DetailReach reach;
  const auto phi = atRest.phi->getConstAccessor();
  for (auto value = exponent.grid->cbeginValueOn(); value; ++value) {
    if (!(static_cast<double>(*value) > shell.lower && static_cast<double>(*value) < shell.upper)) continue;
    const double distance = static_cast<double>(phi.getValue(value.getCoord()));
    reach.outside = std::max(reach.outside, distance);
    reach.inside = std::max(reach.inside, -distance);
  }
  return {reach.outside + diagonal, reach.inside + diagonal};
}

PosedShell posedShell(const ExponentGrid& exponent, const DetailReach& reach, const Target& pose,
                      std::shared_ptr<SurfaceMotion> motion, Monitor& monitor) {
  hideCovered(*motion, pose);
  const PoseLattice lattice(exponent, *pose.phi, *motion, reach, monitor);
  CellTable cells(lattice.nodes(), kOutside), decided(lattice.nodes(), kFar);
  fillInside(cells, *pose.phi);
  lattice.decide(*makeExponentField<double>(exponent), exponent.shell, cells, decided, monitor);
  cells.finish();
  PosedShell result{.exponent = exponent, .deformation = {}, .jumps = jumpsIn(cells, decided)};
  result.exponent.grid = plannedGrid(*pose.phi, decided);
  result.exponent.shellOfNodes = {-kPlanEnd, kPlanEnd};
  result.exponent.denseBox.reset();
  result.deformation = std::make_shared<const PoseDeformation>(lattice.space(), exponent.space, std::move(cells),
                                                               lattice.beyond(), std::move(motion));
  return result;
}

}  // namespace vdbtools
