// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/field/fractal_field.h"

#include "base/affine_columns.h"
#include "base/elementary.h"
#include "base/lattice_transform.h"
#include "distance/cell_corners.h"
#include "distance/leaves.h"
#include "field/block_evaluator.h"
#include "field/block_layers.h"
#include "field/crumb_filter.h"
#include "field/evaluated_layers.h"
#include "field/undecided_blocks.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/base/text.h"

#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tree/ValueAccessor.h>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <memory>
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

// Beyond this, a lattice index leaves no room for a neighbour or loses its last bits in world space.
constexpr double kMostIndex = 1 << 29;

/// Coordinates of index space, clipped to the range in which nodes can be numbered.
openvdb::BBoxd numbered(openvdb::BBoxd lattice) {
  for (int axis = 0; axis < 3; ++axis) {
    lattice.min()[axis] = std::clamp(lattice.min()[axis], -kMostIndex, kMostIndex);
    lattice.max()[axis] = std::clamp(lattice.max()[axis], -kMostIndex, kMostIndex);
  }
  return lattice;
}

bool canBeNumbered(const openvdb::BBoxd& lattice) {
  for (int axis = 0; axis < 3; ++axis)
    if (!(std::abs(lattice.min()[axis]) < kMostIndex && std::abs(lattice.max()[axis]) < kMostIndex)) return false;
  return true;
}

/// A box of world space in the lattice's index space.
openvdb::BBoxd inLattice(const openvdb::BBoxd& world, const FractalFieldOptions& options) {
  return {(world.min() - options.origin) / options.voxelSize, (world.max() - options.origin) / options.voxelSize};
}

/// The nodes in a box of the lattice's index space, plus @a margin nodes on every side.
CoordBBox nodesIn(const openvdb::BBoxd& lattice, int margin) {
  return {Coord::ceil(lattice.min()).offsetBy(-margin), Coord::floor(lattice.max()).offsetBy(margin)};
}

/// The lattice nodes in a box of world space, plus @a margin nodes on every side.
CoordBBox latticeNodes(const openvdb::BBoxd& world, const FractalFieldOptions& options, int margin) {
  const openvdb::BBoxd box = inLattice(world, options);
  if (!canBeNumbered(box))
    throw std::invalid_argument("at voxel size " + shortText(options.voxelSize) +
                                " the lattice is too large to be indexed; use larger voxels, or a small box");
  return nodesIn(box, margin);
}

void requireValid(const FractalFieldOptions& options) {
  if (!(options.voxelSize > 0 && std::isfinite(options.voxelSize)))
    throw std::invalid_argument("the voxel size is " + shortText(options.voxelSize) + "; it must be above 0");
  if (options.box && (options.box->empty() || !options.box->min().isFinite() || !options.box->max().isFinite()))
    throw std::invalid_argument("the box is empty or not finite; give x0,y0,z0,x1,y1,z1 with the smaller corner first");
}

/// The nodes around the cells of E.
CoordBBox wholeDomain(const ExponentGrid& exponent, const FractalFieldOptions& options) {
  CoordBBox cells = exponent.grid->evalActiveVoxelBoundingBox();
  if (exponent.denseBox) cells = *exponent.denseBox;
  if (cells.empty())
    throw DataError(
        "the fractal is empty: the exponent is decided everywhere in the target's band; try less detail or a "
        "larger beta",
        Remedy::LargerBeta);
  const openvdb::BBoxd world =
      exponent.grid->transform().indexToWorld(openvdb::BBoxd(cells.min().asVec3d(), cells.max().asVec3d()));
  const int margin = exponent.denseBox ? 0 : 1;
  if (options.origin == Vec3d(0)) return latticeNodes(world, options, margin);
  // A lattice about a small box need not number nodes that lie far from it.
  return nodesIn(numbered(inLattice(world, options)), margin);
}

/// The domain of a run: the whole, clipped by the box.
CoordBBox shellDomain(CoordBBox domain, const FractalFieldOptions& options) {
  if (options.box) {
    const CoordBBox asked = latticeNodes(*options.box, options, 0);
    if (asked.empty())
      throw std::invalid_argument("the box holds no node of the lattice; make it larger, or the voxels smaller");
    domain.intersect(asked);
  }
  if (domain.empty())
    throw DataError("the box does not touch the fractal; choose one that overlaps the target's own box",
                    Remedy::AnotherFieldBox);
  return domain;
}

/// Bit z: whether the values at the corners of cell (x, y, z) reach into the open interval.
unsigned touching(const CellCorners& corners, unsigned x, unsigned y, float lower, float upper) {
  constexpr unsigned kSide = CellCorners::kSide;
  const float *a = corners.row(x, y), *b = corners.row(x + 1, y), *c = corners.row(x, y + 1),
              *d = corners.row(x + 1, y + 1);
  float low[kSide + 1], high[kSide + 1];
  for (unsigned z = 0; z <= kSide; ++z) {
    low[z] = std::min(std::min(a[z], b[z]), std::min(c[z], d[z]));
    high[z] = std::max(std::max(a[z], b[z]), std::max(c[z], d[z]));
  }
  unsigned bits = 0;
  for (unsigned z = 0; z < kSide; ++z) {
    const bool touches = std::max(high[z], high[z + 1]) > lower && std::min(low[z], low[z + 1]) < upper;
    bits |= static_cast<unsigned>(touches) << z;
  }
  return bits;
}

/// Maps between E's index space and the lattice's.
class LatticeView {
 public:
  LatticeView(const openvdb::math::Transform& transform, const FieldPlan& plan)
      : mMap(
            affineColumns([&](const Vec3d& x) { return (transform.indexToWorld(x) - plan.origin) / plan.voxelSize; })) {
  }

  /// The corners of all lattice cells that touch a box in E's index space.
  CoordBBox cornersAround(const Vec3d& middle, const Vec3d& half) const {
    constexpr double kMargin = 1 + 1e-6;   // slack for a corner of a lattice cell that touches
    constexpr double kRounding = 0x1p-48;  // of coordinates about a lattice's own origin, far from E's
    openvdb::BBoxd box;
    for (int axis = 0; axis < 3; ++axis) {
      const double zero = mMap.offset[axis];
      double at = zero, extent = kMargin + kRounding * std::abs(zero);
      for (int k = 0; k < 3; ++k) {
        const double slope = mMap.columns[static_cast<std::size_t>(k)][axis];
        at += slope * middle[k];
        extent += std::abs(slope) * half[k];
      }
      box.min()[axis] = at - extent;
      box.max()[axis] = at + extent;
    }
    return nodesIn(numbered(box), 0);
  }

 private:
  AffineColumns mMap;
};

/// Calls body(local, nodes) for the boxes of nodes, clipped by @a within, that contain a corner of any lattice cell
/// that touches an undecided cell of E. F changes its sign only in such cells, because E is continuous.
/// @tparam Local  thread-local data; the data of all threads are returned
template <class Local, class Body>
std::vector<Local> forEachUndecidedBox(const ExponentGrid& exponent, const CoordBBox& within, const FieldPlan& plan,
                                       const Body& body) {
  // The margin for rounding errors of interpolation.
  constexpr double kRounding = 1e-5;
  const julia::ShellInterval& shell = exponent.shellOfNodes;
  const auto lower = static_cast<float>(shell.lower - kRounding * (1 + std::abs(shell.lower)));
  const auto upper = static_cast<float>(shell.upper + kRounding * (1 + shell.upper));
  const LatticeView lattice(exponent.grid->transform(), plan);
  const std::vector<const Leaf*> leaves = leavesOf(exponent.grid->tree());
  tbb::enumerable_thread_specific<Local> parts;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leaves.size(), 16), [&](const auto& range) {
    const openvdb::tree::ValueAccessor<const FloatTree> values(exponent.grid->tree());
    Local& part = parts.local();
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      CoordBBox all = lattice.cornersAround(leaves[i]->origin().asVec3d() + Vec3d(0.5 * CellCorners::kSide),
                                            Vec3d(0.5 * CellCorners::kSide));
      all.intersect(within);
      if (all.empty()) continue;
      const CellCorners corners(*leaves[i], values);
      for (unsigned row = 0; row < CellCorners::kSide * CellCorners::kSide; ++row) {
        const unsigned x = row / CellCorners::kSide, y = row % CellCorners::kSide;
        unsigned bits = activeInRow(*leaves[i], row) & touching(corners, x, y, lower, upper);
        while (bits != 0) {
          // A run of cells along z.
          const int first = std::countr_zero(bits), length = std::countr_one(bits >> first);
          bits &= ~(((1u << length) - 1) << first);
          const Coord begin = leaves[i]->origin().offsetBy(static_cast<int>(x), static_cast<int>(y), first);
          const Vec3d reach(0.5, 0.5, 0.5 * length);
          CoordBBox nodes = lattice.cornersAround(begin.asVec3d() + reach, reach);
          nodes.intersect(within);
          if (!nodes.empty()) body(part, nodes);
        }
      }
    }
  });
  return {std::make_move_iterator(parts.begin()), std::make_move_iterator(parts.end())};
}

/// The blocks of one thread, and the last ones that it marked.
struct MarkedBlocks {
  std::unique_ptr<BlockSet> blocks = std::make_unique<BlockSet>();
  std::unique_ptr<openvdb::tree::ValueAccessor<BlockSet>> access =
      std::make_unique<openvdb::tree::ValueAccessor<BlockSet>>(*blocks);
  CoordBBox last{};
};

/// Checks the memory of a set of this many blocks in advance: they lie together, so most leaves of the set are full.
void requireMemoryForBlocks(double blocks) {
  constexpr double kBytesOfLeaf = 100, kBlocksOfLeaf = 512;
  requireMemory(blocks / kBlocksOfLeaf * kBytesOfLeaf, MemoryUse::Field,
                "a lattice of some " + shortText(blocks * kBlock * kBlock * kBlock) + " undecided nodes");
}

/// A lower bound of the number of nodes of the window in undecided cells of E.
double fewestShellNodes(const ExponentGrid& exponent, const CoordBBox& window, const FieldPlan& plan) {
  // Each cell is clipped separately, so cells that the window cuts count in part. Boxes of nodes reach about a node
  // beyond the cells, and are shrunk to these.
  const double nodesOfCell =
      std::abs(exponent.grid->transform().voxelSize().product()) / elementary::pow(plan.voxelSize, 3);
  constexpr double kLargeCell = 512;  // nodes; the sets of smaller cells are small
  if (nodesOfCell < kLargeCell) return 0;
  const double across = elementary::cbrt(nodesOfCell), share = elementary::pow(across / (across + 2), 3);
  double nodes = 0;
  for (const double part : forEachUndecidedBox<double>(exponent, window, plan,
                                                       [](double&sum, const CoordBBox&box) { sum += volumeOf(box); }))
    nodes += part;
  return share * nodes;
}

/// Adds the blocks with nodes in @a window where F may change its sign.
void addShellBlocks(FieldPlan& plan, const ExponentGrid& exponent, const CoordBBox& window) {
  requireMemoryForBlocks(fewestShellNodes(exponent, window, plan) / (kBlock * kBlock * kBlock));
  const std::vector<MarkedBlocks> parts =
      forEachUndecidedBox<MarkedBlocks>(exponent, window, plan, [](MarkedBlocks& part, const CoordBBox& nodes) {
        const CoordBBox touched(nodes.min() >> kBlockLog2, nodes.max() >> kBlockLog2);
        if (touched == part.last) return;
        part.last = touched;
        if (touched.volume() > 512)
          part.blocks->denseFill(touched, true);
        else
          for (auto block = touched.begin(); block; ++block) part.access->setValueOn(*block);
      });
  for (const MarkedBlocks& part : parts) plan.blocks->topologyUnion(*part.blocks);
}

/// Where the box cuts the domain, as caps show it.
openvdb::BBoxd capFacesOf(const CoordBBox& domain, const FractalFieldOptions& options) {
  // On a face that passes through nodes, the vertices around a node would coincide.
  constexpr double kLeast = 0.01, kBeyondOther = 0.5;
  openvdb::BBoxd faces(domain.min().asVec3d() - Vec3d(kBeyondOther), domain.max().asVec3d() + Vec3d(kBeyondOther));
  const openvdb::BBoxd asked = inLattice(*options.box, options);
  const Vec3d &low = asked.min(), &high = asked.max();
  for (int axis = 0; axis < 3; ++axis) {
    const double first = domain.min()[axis], last = domain.max()[axis];
    if (low[axis] > first - 1) faces.min()[axis] = std::min(low[axis], first - kLeast);
    if (high[axis] < last + 1) faces.max()[axis] = std::max(high[axis], last + kLeast);
  }
  return faces;
}

/// A plan without blocks.
FieldPlan emptyPlan(const CoordBBox& domain, const CoordBBox& whole, bool bounded, const FractalFieldOptions& options) {
  CoordBBox window = options.window.value_or(domain);
  window.intersect(domain);
  FieldPlan plan{domain, bounded, options.voxelSize, options.origin, window, std::make_shared<BlockSet>(), whole};
  if (options.box && !domain.empty()) plan.capFaces = capFacesOf(domain, options);
  return plan;
}
FieldPlan emptyShellPlan(const ExponentGrid& exponent, const FractalFieldOptions& options) {
  requireValid(options);
  const CoordBBox whole = wholeDomain(exponent, options);
  return emptyPlan(shellDomain(whole, options), whole, options.box || exponent.denseBox, options);
}

void addEveryBlock(FieldPlan& plan) {
  requireMemoryForBlocks(volumeOf(plan.window) / (kBlock * kBlock * kBlock));
  addBlocks(*plan.blocks, plan.window);
  addBorderBlocks(*plan.blocks, plan.domain, plan.window);
}

}  // namespace

std::vector<openvdb::Vec3s> FieldSource::versorVectors(std::span<const julia::Point> points) const {
  std::vector<julia::Quaternion<double>> versors(points.size());
  evaluator.versors(points, versors);
  std::vector<openvdb::Vec3s> vectors(points.size());
  const bool spatial = evaluator.dimension() == 3;
  std::transform(versors.begin(), versors.end(), vectors.begin(), [=](const julia::Quaternion<double>& u) {
    return openvdb::Vec3s(spatial ? Vec3d(u.a, u.b, u.c) : Vec3d(u.b, u.c, u.d));
  });
  return vectors;
}

Vec3d latticeOrigin(const FractalFieldOptions& options) {
  requireValid(options);
  const double h = options.voxelSize;
  if (!options.box || canBeNumbered({options.box->min() / h, options.box->max() / h})) return Vec3d(0);
  // Positions on an edge are searched to a thousandth of it.
  constexpr double kLeast = 1e-12;
  double largest = 0;
  for (const Vec3d& corner : {options.box->min(), options.box->max()})
    for (int axis = 0; axis < 3; ++axis) largest = std::max(largest, std::abs(corner[axis]));
  if (h < kLeast * largest)
    throw std::invalid_argument("the voxel size is " + shortText(h) + ", and coordinates in the box reach " +
                                shortText(largest) + ", of which doubles have 16 digits; use voxels of at least " +
                                shortText(kLeast * largest));
  const Vec3d middle = options.box->getCenter() / h;
  return Vec3d(std::round(middle[0]), std::round(middle[1]), std::round(middle[2])) * h;
}

FieldPlan planShell(const ExponentGrid& exponent, const FractalFieldOptions& options) {
  FieldPlan plan = emptyShellPlan(exponent, options);
  // Blocks that the window cuts belong to it as they do to the whole domain.
  CoordBBox blocks = plan.window;
  if (!blocks.empty()) {
    blocks = {(blocks.min() >> kBlockLog2) << kBlockLog2,
              ((blocks.max() >> kBlockLog2) << kBlockLog2).offsetBy(kBlock - 1)};
    blocks.intersect(plan.domain);
  }
  addShellBlocks(plan, exponent, blocks);
  if (plan.bounded) addBorderBlocks(*plan.blocks, plan.domain, plan.window);
  return plan;
}

FieldPlan planExhaustive(const ExponentGrid& exponent, const FractalFieldOptions& options) {
  FieldPlan plan = emptyShellPlan(exponent, options);
  addEveryBlock(plan);
  return plan;
}

FieldPlan planBox(const FractalFieldOptions& options) {
  requireValid(options);
  if (!options.box) throw std::invalid_argument("a field without a shell needs a box to be evaluated in");
  const CoordBBox everywhere(Coord(-static_cast<int>(kMostIndex)), Coord(static_cast<int>(kMostIndex)));
  FieldPlan plan = emptyPlan(latticeNodes(*options.box, options, 0), everywhere, true, options);
  if (plan.domain.empty())
    throw std::invalid_argument("the box holds no node of the lattice; make it larger, or the voxels smaller");
  addEveryBlock(plan);
  return plan;
}

std::vector<CoordBBox> undecidedBoxes(const ExponentGrid* exponent, const FieldPlan& plan) {
  if (!exponent) return {plan.window};
  using Boxes = std::vector<CoordBBox>;
  Boxes all;
  for (const Boxes& part : forEachUndecidedBox<Boxes>(
           *exponent, plan.window, plan, [](Boxes&boxes, const CoordBBox&nodes) { boxes.push_back(nodes); }))
    all.insert(all.end(), part.begin(), part.end());
  return all;
}

FractalField emptyField(const FieldPlan& plan, bool keepIterations) {
  const auto makeGrid = [&](float background, const char* name) {
    FloatGrid::Ptr grid = FloatGrid::create(background);
    grid->setTransform(latticeTransform(plan.voxelSize));
    grid->setName(name);
    return grid;
  };
  FractalField result;
  result.domain = plan.domain;
  result.bounded = plan.bounded;
  result.window = plan.window;
  result.capFaces = plan.capFaces;
  result.field = makeGrid(kFieldOutside, "logmodulus");
  if (keepIterations) result.iterations = makeGrid(0, "iterations");
  return result;
}

void fillTiles(FractalField& field) {
  // Where there is no leaf, nothing changes sign, so the sign of a block's corner is that of its neighbours. In the
  // leaves every value is final; the fill, which would overwrite inactive values, runs only above the leaves.
  openvdb::tools::signedFloodFillWithValues(field.field->tree(), kFieldOutside, -kFieldOutside, true, 1, 1);
}

/// @param leaves  number of leaves per block
void requireMemoryForField(std::uint64_t blocks, int leaves, Proofs proofs) {
  // If single blocks may be proved to have one sign, not all of them become leaves.
  constexpr double kLeastShare = 0.3;
  const double count = static_cast<double>(blocks) * leaves * (proofs == Proofs::None ? 1 : kLeastShare);
  requireMemory(count * kBytesOfFloatLeaf, MemoryUse::Field,
                "the field on " + std::to_string(blocks) + " blocks of 8^3 nodes");
}

FractalField evaluateField(const FieldPlan& plan, const FieldSource& source, const EvaluateFieldOptions& options,
                           Monitor& monitor) {
  FractalField result = emptyField(plan, options.keepIterations);
  const BlockSet blocks = options.everyNode ? *plan.blocks : undecidedBlocks(plan, source, monitor);
  BlockLayers layers(blocks);
  const Proofs proofs = options.everyNode ? Proofs::None : worthwhileProofs(blocks, plan, source);
  requireMemoryForField(layers.blockCount(), options.keepIterations ? 2 : 1, proofs);
  BlockEvaluator evaluator(source, {.voxelSize = plan.voxelSize,
                                    .domain = plan.domain,
                                    .window = plan.window,
                                    .keepIterations = options.keepIterations,
                                    .everyValue = options.everyNode,
                                    .proofs = proofs});
  monitor.begin(PhaseKind::Field, layers.blockCount());
  EvaluatedLayers evaluated(layers, evaluator, monitor);
  for (auto some = evaluated.next(); !some.empty(); some = evaluated.next())
    for (EvaluatedLayers::Layer& layer : some)
      for (EvaluatedBlock& block : layer) {
        if (block.field) result.field->tree().addLeaf(block.field.release());
        if (block.iterations) result.iterations->tree().addLeaf(block.iterations.release());
      }
  fillTiles(result);
  dropCrumbs(result, plan, source, monitor);
  result.evaluatedNodes = evaluator.evaluatedNodes();
  return result;
}

FractalField fractalField(const FieldSource& source, const ExponentGrid& exponent, const FractalFieldOptions& options,
                          Monitor& monitor) {
  return evaluateField(planShell(exponent, options), source, {.keepIterations = options.keepIterations}, monitor);
}

FractalField fractalFieldEverywhere(const FieldSource& source, const FractalFieldOptions& options, Monitor& monitor) {
  return evaluateField(planBox(options), source, {.keepIterations = options.keepIterations}, monitor);
}

}  // namespace vdbtools
