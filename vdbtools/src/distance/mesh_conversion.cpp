// SPDX-License-Identifier: Apache-2.0
#include "distance/mesh_conversion.h"

#include "base/lattice_transform.h"
#include "distance/distance_band.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/base/text.h"

#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tree/LeafManager.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <memory>
#include <stdexcept>

namespace vdbtools {
namespace {

using openvdb::FloatGrid;
using openvdb::Vec3d;

/// Coordinates are 32-bit; half of their range leaves room for the bands, and for differences between two coordinates.
constexpr double kLargestIndex = 1073741824.0;

constexpr double kMostNodes = 2147483648.0;

/// The minimum memory of the conversion, measured for many shapes and widths: to find the sides, bytes per voxel face
/// of area; for the band, bytes per node, i.e. the size of a float.
constexpr double kBytesForArea = 100, kBytesForNode = 4;

/// Voxels beyond the requested bands.
constexpr double kWorkingBand = 2;

/// A finite substitute for 'the whole inside': no point of the inside is farther from the surface than half the
/// shortest side of the box.
double finiteInteriorBand(const openvdb::BBoxd& indexBox, double interiorBandWidth) {
  if (std::isfinite(interiorBandWidth)) return interiorBandWidth;
  const Vec3d sides = indexBox.extents();
  return std::ceil(0.5 * std::min({sides[0], sides[1], sides[2]})) + kWorkingBand + 1;
}

double nodesIn(const Vec3d& sides, double band) {
  return (sides[0] + 2 * band + 1) * (sides[1] + 2 * band + 1) * (sides[2] + 2 * band + 1);
}

/// The nodes of a band, which is as large as the area times its width, but no larger than the bounding box.
/// @param area, box  index space
double nodesOfBand(double area, const openvdb::BBoxd& box, const MeshToSdfOptions& options) {
  const double exterior = options.exteriorBandWidth + kWorkingBand;
  const double interior = finiteInteriorBand(box, options.interiorBandWidth) + kWorkingBand;
  return std::min(area * exterior, nodesIn(box.extents(), exterior)) +
         std::min(area * interior, nodesIn(box.extents(), 0));
}

double bytesOfBand(double area, double nodes) { return kBytesForArea * area + kBytesForNode * nodes; }

/// The share of the memory that is left which the frames of triangles may take.
constexpr double kShareForFrames = 0.125;

/// Triangles for each voxel face of area, above which blocks make the frames of few of those near them.
constexpr double kDense = 24;

/// The frames of triangles are made once if they take no more memory than the distances do at least, or little of what
/// is left. Meshes of several triangles in a voxel need this most: each triangle is near many blocks.
TriangleTree::Frames framesFor(const std::vector<Vec3d>& points, const std::vector<openvdb::Vec3I>& triangles,
                               const MeshToSdfOptions& options) {
  double area = 0;
  openvdb::BBoxd box;
  for (const openvdb::Vec3I& t : triangles) {
    area += (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).length() / 2;
    for (int c = 0; c < 3; ++c) box.expand(points[t[c]]);
  }
  if (static_cast<double>(triangles.size()) > kDense * area) return TriangleTree::Frames::ForEachBlock;
  const auto bytes = static_cast<double>(triangles.size() * TriangleTree::kFrameBytes);
  const bool isLittle =
      bytes <= bytesOfBand(area, nodesOfBand(area, box, options)) || bytes <= kShareForFrames * memoryLeft().bytes;
  return isLittle ? TriangleTree::Frames::Once : TriangleTree::Frames::ForEachBlock;
}

/// Leaf values are scaled in parallel; tiles and the background are few.
void scaleValues(FloatGrid& grid, float factor) {
  openvdb::FloatTree& tree = grid.tree();
  openvdb::tree::LeafManager<openvdb::FloatTree> leaves(tree);
  leaves.foreach ([factor](openvdb::FloatTree::LeafNodeType& leaf, std::size_t) {
    float* values = leaf.buffer().data();
    for (openvdb::Index i = 0; i < openvdb::FloatTree::LeafNodeType::SIZE; ++i) values[i] *= factor;
  });
  openvdb::FloatTree::ValueAllIter tile = tree.beginValueAll();
  tile.setMaxDepth(openvdb::FloatTree::ValueAllIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) tile.setValue(*tile * factor);
  tree.root().setBackground(tree.background() * factor, /*updateChildNodes=*/false);
}

}  // namespace

void checkOptions(const MeshReport& report, const MeshToSdfOptions& options) {
  const double h = options.voxelSize;
  if (!(h > 0) || !std::isnormal(static_cast<float>(h)) || !std::isfinite(static_cast<float>(h))) {
    throw std::invalid_argument("the voxel size " + shortText(h) + " is not a positive number of ordinary size");
  }
  if (!(options.exteriorBandWidth > 1) || !std::isfinite(static_cast<float>(options.exteriorBandWidth * h))) {
    throw std::invalid_argument("the exterior band width " + shortText(options.exteriorBandWidth) +
                                " is not a finite number of voxels above 1");
  }
  if (!(options.interiorBandWidth > 1)) {
    throw std::invalid_argument("the interior band width " + shortText(options.interiorBandWidth) +
                                " is not a number of voxels above 1");
  }
  if (report.triangles == 0 || !(report.area > 0) || !std::isfinite(report.area)) {
    throw DataError("the mesh has " + std::to_string(report.triangles) + " triangles and the area " +
                    shortText(report.area) + ": there is no surface in it; check the file");
  }
  const openvdb::BBoxd box(report.box.min() / h, report.box.max() / h);
  for (int axis = 0; axis < 3; ++axis) {
    const double farthest = std::max(std::abs(box.min()[axis]), std::abs(box.max()[axis])) + options.exteriorBandWidth;
    if (!(farthest < kLargestIndex)) {
      throw std::invalid_argument("at the voxel size " + shortText(h) + " the mesh reaches to node " +
                                  shortText(farthest) +
                                  ", but 2^30 is the last one; use a larger voxel size, or move "
                                  "the mesh nearer to the origin");
    }
  }
  const double area = report.area / (h * h), nodes = nodesOfBand(area, box, options);
  if (!(nodes < kMostNodes)) {
    throw std::invalid_argument("at the voxel size " + shortText(h) + " the narrow band of this mesh has about " +
                                shortText(nodes) + " nodes, more than the " + shortText(kMostNodes) +
                                " that are allowed; use a larger voxel size or a narrower band");
  }
  requireMemory(bytesOfBand(area, nodes), MemoryUse::Distances,
                "at the voxel size " + shortText(h) + " the distances to this mesh");
}

std::vector<Vec3d> toIndexSpace(const std::vector<Vec3d>& points, double voxelSize) {
  std::vector<Vec3d> result(points.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size()), [&](const auto& range) {
    for (std::size_t p = range.begin(); p < range.end(); ++p) result[p] = points[p] / voxelSize;
  });
  return result;
}

FloatGrid::Ptr toWorld(FloatGrid::Ptr grid, double voxelSize) {
  scaleValues(*grid, static_cast<float>(voxelSize));
  grid->setTransform(latticeTransform(voxelSize));
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  grid->setName("phi");
  return grid;
}

FloatGrid::Ptr convert(const std::vector<Vec3d>& points, const std::vector<openvdb::Vec3I>& triangles,
                       const MeshToSdfOptions& options, Monitor& monitor, PartCounts* counts) {
  const TriangleTree tree(points, triangles, {}, framesFor(points, triangles, options));
  return toWorld(signedDistances(tree, static_cast<float>(options.exteriorBandWidth),
                                 static_cast<float>(finiteInteriorBand(tree.box(), options.interiorBandWidth)),
                                 PhaseKind::DistanceField, monitor, counts, options.hollows),
                 options.voxelSize);
}

FloatGrid::Ptr narrowed(const FloatGrid::Ptr& band, const MeshToSdfOptions& options) {
  using Leaf = openvdb::FloatTree::LeafNodeType;
  // Scaled in floats, as convert() scales the distances and the tiles of a band.
  const auto scale = static_cast<float>(options.voxelSize);
  const float exterior = static_cast<float>(options.exteriorBandWidth) * scale;
  const float interior = std::isfinite(options.interiorBandWidth)
                             ? static_cast<float>(options.interiorBandWidth) * scale
                             : std::numeric_limits<float>::max();
  const auto nodesOf = [=](const Leaf& leaf) {
    openvdb::util::NodeMask<Leaf::LOG2DIM> nodes;
    const float* const values = leaf.buffer().data();
    for (openvdb::Index i = 0; i < Leaf::SIZE; ++i)
      if (values[i] < exterior && values[i] > -interior) nodes.setOn(i);
    return nodes;
  };
  openvdb::tree::LeafManager<const openvdb::FloatTree> leaves(band->tree());
  const auto holdsMore = [&](const Leaf& leaf) {
    const float* const values = leaf.buffer().data();
    return nodesOf(leaf) != leaf.getValueMask() ||
           std::any_of(values, values + Leaf::SIZE, [=](float v) { return v > exterior || v < -interior; });
  };
  using Range = openvdb::tree::LeafManager<const openvdb::FloatTree>::LeafRange;
  const auto tilesHoldMore = [&] {
    openvdb::FloatTree::ValueAllCIter tile = band->tree().cbeginValueAll();
    tile.setMaxDepth(openvdb::FloatTree::ValueAllCIter::LEAF_DEPTH - 1);
    for (; tile; ++tile)
      if (*tile < -interior) return true;
    return false;
  };
  const bool isNarrow = band->background() == exterior && !tilesHoldMore() &&
                        !tbb::parallel_reduce(
                            leaves.leafRange(), false,
                            [&](const Range& range, bool more) {
                              for (auto leaf = range.begin(); leaf && !more; ++leaf) more = holdsMore(*leaf);
                              return more;
                            },
                            std::logical_or<>());
  if (isNarrow) return band;
  std::vector<std::unique_ptr<Leaf>> narrow(leaves.leafCount());
  leaves.foreach ([&](const Leaf& leaf, std::size_t n) {
    const auto nodes = nodesOf(leaf);
    if (nodes.isOff()) return;
    narrow[n] = std::make_unique<Leaf>(leaf);
    narrow[n]->setValueMask(nodes);
    float* const values = narrow[n]->buffer().data();
    for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) values[i] = std::clamp(values[i], -interior, exterior);
  });
  FloatGrid::Ptr grid = FloatGrid::create(exterior);
  grid->setName(band->getName());
  grid->setGridClass(band->getGridClass());
  grid->setTransform(band->transformPtr());  // the copy of a transform differs by rounding
  openvdb::tree::ValueAccessor<openvdb::FloatTree> accessor(grid->tree());
  for (std::unique_ptr<Leaf>& leaf : narrow)
    if (leaf) accessor.addLeaf(leaf.release());
  openvdb::tools::signedFloodFillWithValues(grid->tree(), exterior, -interior);
  return grid;
}

std::vector<SurfaceSample> sampleSurface(const std::vector<Vec3d>& points, const std::vector<openvdb::Vec3I>& triangles,
                                         std::size_t count) {
  const auto areaOf = [&points](const openvdb::Vec3I& t) {
    return (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).length() / 2;
  };
  double area = 0;
  for (const openvdb::Vec3I& t : triangles) area += areaOf(t);
  const double step = area / static_cast<double>(count);
  std::vector<SurfaceSample> samples;
  if (!(step > 0)) return samples;
  samples.reserve(count + 1);
  // The additive recurrence of the plastic number fills a triangle evenly (M. Roberts, 2018).
  constexpr double kFirst = 0.7548776662466927;
  constexpr double kSecond = 0.5698402909980532;
  double passed = 0;
  for (std::size_t n = 0; n < triangles.size(); ++n) {
    passed += areaOf(triangles[n]);
    while ((static_cast<double>(samples.size()) + 0.5) * step < passed) {
      const auto index = static_cast<double>(samples.size() + 1);
      double u = std::fmod(index * kFirst, 1.0);
      double v = std::fmod(index * kSecond, 1.0);
      if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
      }
      const openvdb::Vec3I& t = triangles[n];
      samples.push_back(
          {points[t[0]] * (1 - u - v) + points[t[1]] * u + points[t[2]] * v, static_cast<std::uint32_t>(n)});
    }
  }
  return samples;
}

double lostShare(const FloatGrid& grid, const std::vector<SurfaceSample>& samples, float isovalue) {
  if (samples.empty()) return 1;
  using Range = tbb::blocked_range<std::size_t>;
  const auto countLost = [&](const Range& range, std::size_t lost) {
    const FloatGrid::ConstAccessor phi = grid.getConstAccessor();
    for (std::size_t s = range.begin(); s < range.end(); ++s) {
      const openvdb::Coord base = openvdb::Coord::floor(samples[s].position).offsetBy(-1);
      bool inside = false;
      for (int n = 0; n < 64 && !inside; ++n) {
        inside = phi.getValue(base.offsetBy(n & 3, (n >> 2) & 3, n >> 4)) < isovalue;
      }
      if (!inside) ++lost;
    }
    return lost;
  };
  const std::size_t lost =
      tbb::parallel_reduce(Range(0, samples.size(), 256), std::size_t{0}, countLost, std::plus<std::size_t>());
  return static_cast<double>(lost) / static_cast<double>(samples.size());
}

double insideNodes(const FloatGrid& grid) {
  openvdb::tree::LeafManager<const openvdb::FloatTree> leaves(grid.tree());
  const auto inLeaves = tbb::parallel_reduce(
      leaves.leafRange(), std::uint64_t{0},
      [](const auto& range, std::uint64_t sum) {
        for (auto leaf = range.begin(); leaf; ++leaf) {
          const float* values = leaf->buffer().data();
          sum += static_cast<std::uint64_t>(
              std::count_if(values, values + openvdb::FloatTree::LeafNodeType::SIZE, [](float v) { return v < 0; }));
        }
        return sum;
      },
      std::plus<std::uint64_t>());
  auto nodes = static_cast<double>(inLeaves);
  openvdb::FloatTree::ValueAllCIter tile = grid.tree().cbeginValueAll();
  tile.setMaxDepth(openvdb::FloatTree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    if (*tile < 0) nodes += static_cast<double>(tile.getVoxelCount());
  }
  return nodes;
}

}  // namespace vdbtools
