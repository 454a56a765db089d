// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/fractal_field.h"

#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tree/ValueAccessor.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::FloatTree;
using openvdb::Vec3d;
using Leaf = FloatTree::LeafNodeType;
using BlockMask = openvdb::MaskTree;

constexpr int kBlock = static_cast<int>(Leaf::DIM);
// Lattice indices beyond this leave no room for a neighbour, or lose their last bits in world space.
constexpr double kMostIndex = 1 << 29;

Coord blockOf(const Coord& node) { return node & ~(kBlock - 1); }

void addBlocks(BlockMask& blocks, const CoordBBox& nodes) {
  if (nodes.empty()) return;
  openvdb::tree::ValueAccessor<BlockMask> accessor(blocks);
  const Coord low = blockOf(nodes.min()), high = blockOf(nodes.max());
  for (int x = low[0]; x <= high[0]; x += kBlock)
    for (int y = low[1]; y <= high[1]; y += kBlock)
      for (int z = low[2]; z <= high[2]; z += kBlock) accessor.touchLeaf({x, y, z});
}

/// The lattice nodes in a box of world space, plus @a margin nodes on every side.
CoordBBox latticeNodes(const openvdb::BBoxd& world, double voxelSize, int margin) {
  const Vec3d low = world.min() / voxelSize, high = world.max() / voxelSize;
  for (int axis = 0; axis < 3; ++axis)
    if (!(std::abs(low[axis]) < kMostIndex && std::abs(high[axis]) < kMostIndex))
      throw std::invalid_argument("at voxel size " + std::to_string(voxelSize) +
                                  " the lattice is too large to be indexed; use larger voxels");
  return {Coord::ceil(low).offsetBy(-margin), Coord::floor(high).offsetBy(margin)};
}

void requireValid(const FractalFieldOptions& options) {
  if (!(options.voxelSize > 0 && std::isfinite(options.voxelSize)))
    throw std::invalid_argument("voxel size is " + std::to_string(options.voxelSize) + "; it must be above 0");
  if (options.box && (options.box->empty() || !options.box->min().isFinite() || !options.box->max().isFinite()))
    throw std::invalid_argument("the box is empty or not finite; give x0,y0,z0,x1,y1,z1 with the smaller corner first");
}

/// The domain of a run: where E's cells are, cut by the box.
CoordBBox shellDomain(const ExponentGrid& exponent, const FractalFieldOptions& options) {
  CoordBBox cells = exponent.grid->evalActiveVoxelBoundingBox();
  if (exponent.denseBox) cells = *exponent.denseBox;
  if (cells.empty())
    throw DataError(
        "the fractal is empty: the exponent is decided everywhere in the target's band; try a larger --beta");
  const openvdb::BBoxd world =
      exponent.grid->transform().indexToWorld(openvdb::BBoxd(cells.min().asVec3d(), cells.max().asVec3d()));
  CoordBBox domain = latticeNodes(world, options.voxelSize, exponent.denseBox ? 0 : 1);
  if (options.box) {
    const CoordBBox asked = latticeNodes(*options.box, options.voxelSize, 0);
    if (asked.empty())
      throw std::invalid_argument("the box holds no node of the lattice; make it larger, or the voxels smaller");
    domain.intersect(asked);
  }
  if (domain.empty())
    throw DataError("the box does not touch the fractal; 'juliavdb info' tells where the target lies");
  return domain;
}

/// Blocks that hold a corner of any lattice cell which touches an undecided cell of E: a change of F's sign lies in
/// such a cell, for E is continuous.
void addShellBlocks(BlockMask& blocks, const ExponentGrid& exponent, const CoordBBox& domain, double voxelSize) {
  const openvdb::math::Transform& transform = exponent.grid->transform();
  const openvdb::tree::ValueAccessor<const FloatTree> values(exponent.grid->tree());
  for (auto leaf = exponent.grid->tree().cbeginLeaf(); leaf; ++leaf)
    for (auto value = leaf->cbeginValueOn(); value; ++value) {
      // A node owns the cell that begins at it.
      const Coord node = value.getCoord();
      float low = *value, high = *value;
      for (int corner = 1; corner < 8; ++corner) {
        const float other = values.getValue(node.offsetBy(corner & 1, corner >> 1 & 1, corner >> 2 & 1));
        low = std::min(low, other);
        high = std::max(high, other);
      }
      if (high <= exponent.shell.lower || low >= exponent.shell.upper) continue;
      const openvdb::BBoxd cell(node.asVec3d(), node.offsetBy(1).asVec3d());
      CoordBBox nodes = latticeNodes(transform.indexToWorld(cell), voxelSize, 1);
      nodes.intersect(domain);
      addBlocks(blocks, nodes);
    }
}

/// Blocks on the domain's border and just outside of it, so that the cut itself is a change of sign between leaves.
void addBorderBlocks(BlockMask& blocks, const CoordBBox& domain) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool far : {false, true}) {
      CoordBBox slab = domain;
      slab.expand(1);
      Coord low = slab.min(), high = slab.max();
      if (far)
        low[axis] = high[axis] - 1;
      else
        high[axis] = low[axis] + 1;
      addBlocks(blocks, {low, high});
    }
  }
}

/// Keeps the sign, whatever rounding to 32 bits does.
float stored(double field) {
  const float value = static_cast<float>(field);
  return value == 0 && field < 0 ? -std::numeric_limits<float>::min() : value;
}

FractalField evaluateBlocks(const BlockMask& blocks, const CoordBBox& domain, bool bounded, const FieldSource& source,
                            const FractalFieldOptions& options, Monitor& monitor) {
  std::vector<Coord> origins;
  origins.reserve(blocks.leafCount());
  for (auto leaf = blocks.cbeginLeaf(); leaf; ++leaf) origins.push_back(leaf->origin());

  constexpr float kOutside = 1;
  FractalField result;
  result.domain = domain;
  result.bounded = bounded;
  std::vector<Leaf*> fieldLeaves(origins.size()), stepLeaves(options.keepIterations ? origins.size() : 0);
  std::atomic<std::uint64_t> evaluated{0};
  monitor.begin("field", origins.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, origins.size(), 4), [&](const auto& range) {
    std::vector<julia::Point> points;
    std::vector<openvdb::Index> offsets;
    std::vector<double> values;
    std::vector<int> steps;
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      if (monitor.cancelled()) return;
      // All active for now: the flood below overwrites what is not.
      fieldLeaves[i] = new Leaf(origins[i], kOutside, true);
      if (options.keepIterations) stepLeaves[i] = new Leaf(origins[i], 0.0f, false);
      points.clear();
      offsets.clear();
      // Each coordinate is that of its index alone, whichever block asks.
      std::array<julia::Point, kBlock> at;
      for (int k = 0; k < kBlock; ++k)
        at[static_cast<std::size_t>(k)] = source.space.toFractal(origins[i].offsetBy(k).asVec3d() * options.voxelSize);
      const bool within = domain.isInside(fieldLeaves[i]->getNodeBoundingBox());
      for (openvdb::Index offset = 0; offset < Leaf::SIZE; ++offset) {
        if (!within && !domain.isInside(fieldLeaves[i]->offsetToGlobalCoord(offset))) continue;
        offsets.push_back(offset);
        points.push_back({at[offset >> 6][0], at[offset >> 3 & 7][1], at[offset & 7][2]});
      }
      values.resize(points.size());
      steps.resize(points.size());
      source.evaluator.evaluate(points, values, steps);
      for (std::size_t k = 0; k < offsets.size(); ++k) {
        fieldLeaves[i]->setValueOn(offsets[k], stored(values[k]));
        if (options.keepIterations) stepLeaves[i]->setValueOn(offsets[k], static_cast<float>(steps[k]));
      }
      evaluated += points.size();
      monitor.advance(1);
    }
  });
  // The trees own the leaves from here, also when the work was cancelled.
  const auto plant = [&](std::vector<Leaf*>& leaves, float background, const char* name) {
    FloatGrid::Ptr grid = FloatGrid::create(background);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(options.voxelSize));
    grid->setName(name);
    for (Leaf* leaf : leaves)
      if (leaf) grid->tree().addLeaf(leaf);
    return grid;
  };
  result.field = plant(fieldLeaves, kOutside, "logmodulus");
  if (options.keepIterations) result.iterations = plant(stepLeaves, 0, "iterations");
  monitor.throwIfCancelled();
  // Where there is no leaf nothing changes sign, so the sign of a block's corner is that of its neighbours.
  openvdb::tools::signedFloodFillWithValues(result.field->tree(), kOutside, -kOutside);
  for (auto leaf = result.field->tree().beginLeaf(); leaf; ++leaf) {
    if (domain.isInside(leaf->getNodeBoundingBox())) continue;
    for (auto value = leaf->beginValueOn(); value; ++value)
      if (!domain.isInside(value.getCoord())) value.setValueOff();
  }
  result.evaluatedNodes = evaluated;
  return result;
}

}  // namespace

FractalField fractalField(const FieldSource& source, const ExponentGrid& exponent, const FractalFieldOptions& options,
                          Monitor& monitor) {
  requireValid(options);
  const CoordBBox domain = shellDomain(exponent, options);
  const bool bounded = options.box.has_value() || exponent.denseBox.has_value();
  BlockMask blocks;
  addShellBlocks(blocks, exponent, domain, options.voxelSize);
  if (bounded) addBorderBlocks(blocks, domain);
  return evaluateBlocks(blocks, domain, bounded, source, options, monitor);
}

FractalField fractalFieldExhaustive(const FieldSource& source, const ExponentGrid& exponent,
                                    const FractalFieldOptions& options, Monitor& monitor) {
  requireValid(options);
  const CoordBBox domain = shellDomain(exponent, options);
  BlockMask blocks;
  addBlocks(blocks, domain);
  addBorderBlocks(blocks, domain);
  return evaluateBlocks(blocks, domain, options.box || exponent.denseBox, source, options, monitor);
}

FractalField fractalFieldEverywhere(const FieldSource& source, const FractalFieldOptions& options, Monitor& monitor) {
  requireValid(options);
  if (!options.box) throw std::invalid_argument("a field without a shell needs a box to be evaluated in");
  const CoordBBox domain = latticeNodes(*options.box, options.voxelSize, 0);
  if (domain.empty())
    throw std::invalid_argument("the box holds no node of the lattice; make it larger, or the voxels smaller");
  BlockMask blocks;
  addBlocks(blocks, domain);
  addBorderBlocks(blocks, domain);
  return evaluateBlocks(blocks, domain, true, source, options, monitor);
}

}  // namespace vdbtools
