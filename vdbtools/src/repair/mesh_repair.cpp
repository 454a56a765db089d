// SPDX-License-Identifier: Apache-2.0
/// A ball of the gap's width rolls over the outside of the mesh, and what it cannot reach is closed (the morphological
/// closing of the mesh). Where its envelope bridges a hole, the envelope becomes part of the mesh, a lid. The
/// conversion of meshToSdf() then makes the field, which is therefore the mesh's true distance field wherever the mesh
/// was intact. The ball also bridges grooves that are too narrow for it. Such an envelope touches no open edge, so it
/// is not a lid, and it is left out unless the mesh leaks without it.
#include "vdbtools/repair/mesh_repair.h"
#include "base/disjoint_sets.h"
#include "distance/distance_band.h"
#include "distance/hole_caps.h"
#include "distance/level_surface.h"
#include "distance/mesh_conversion.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"

#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tree/LeafManager.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

namespace vdbtools {
namespace {

using openvdb::BoolTree;
using openvdb::FloatGrid;
using openvdb::FloatTree;
using openvdb::Vec3d;
using openvdb::Vec3I;

/// A wide gap is closed on a coarser lattice with this many nodes across it; on the grid's own lattice the bands would
/// take too much time and memory. If the resulting lids do not fit their rims closely enough, the lattice is refined.
constexpr double kNodesAcrossGap = 4;
constexpr double kMostLatticeNodes = 2e8;

/// The factor by which the gap grows if nothing was enclosed.
constexpr double kGapGrowth = 1.5;

/// In lattice units: an envelope nearer to the mesh than this is the mesh itself, up to the lattice's error.
constexpr double kTouching = 0.75;

/// In lattice units, kept on the far side of every offset: a cell's diagonal, plus what distinguishes a wall from an
/// inner one.
constexpr double kMargin = 2.5;

/// In lattice units: an open sheet is its own closing, and the lattice's error around it must not pass for an inside.
constexpr double kNoInside = 0.5;

constexpr std::size_t kSamples = 20000;

/// The fraction of the surface that may bound nothing. Up to the first value the result is accepted. Up to the second,
/// the next wider gap is also tried: a ball that barely fits a hole dents it deeply, and may touch the other side. More
/// is a leak.
constexpr double kLostWell = 0.01;
constexpr double kLostAtMost = 0.05;

/// On the lattice, which may be coarser than the grid, only a clear result counts.
constexpr double kLostClearly = 0.5;

constexpr float kTiny = 1e-3F;  ///< lattice units; minimum depth of an enclosed node

/// The lattice: node (i, j, k) lies at middle + spacing (i, j, k). It is centred on the mesh, because OpenVDB's mesher
/// returns points in single precision.
struct Lattice {
  Vec3d middle;
  double spacing = 0;

  Vec3d toLattice(const Vec3d& world) const { return (world - middle) / spacing; }
  Vec3d toWorld(const Vec3d& p) const { return middle + p * spacing; }
};

/// Computes the region of the ball's centres from the distance to the mesh; the result is negative where the ball
/// cannot be.
/// @param distance  unsigned; is modified
void floodFromOutside(FloatGrid& distance, double radius) {
  const openvdb::BoolGrid::Ptr enclosed = openvdb::tools::extractEnclosedRegion(distance, static_cast<float>(radius));
  const BoolTree& mask = enclosed->constTree();
  openvdb::tree::LeafManager<FloatTree> leaves(distance.tree());
  leaves.foreach ([&mask, radius](FloatTree::LeafNodeType& leaf, std::size_t) {
    const openvdb::tree::ValueAccessor<const BoolTree> inside(mask);
    for (auto it = leaf.beginValueAll(); it; ++it) {
      const float offset = *it - static_cast<float>(radius);
      // A pocket that the flood did not reach is inside, however far from the mesh it is.
      const bool closed = inside.getValue(it.getCoord()) || offset <= 0;
      it.setValue(closed ? -std::max(std::abs(offset), kTiny) : offset);
    }
  });
  distance.tree().root().setBackground(distance.background() - static_cast<float>(radius), true);
  openvdb::tools::signedFloodFill(distance.tree());
  distance.setGridClass(openvdb::GRID_LEVEL_SET);
}

/// @return for each triangle, whether one of its edges is open
std::vector<bool> findOpenTriangles(const Mesh& mesh) {
  std::vector<bool> open(mesh.triangles.size(), false);
  for (const OpenEdge& edge : openEdges(mesh)) open[edge.triangle] = true;
  return open;
}

/// The envelope where it deviates from the mesh, plus one ring of triangles placed onto the mesh, so that no crack
/// remains between the two.
struct Lids {
  LevelSurface surface;      ///< lattice coordinates
  std::vector<bool> atEdge;  ///< for each triangle: whether its piece touches an open edge of the mesh
};

Lids findLids(LevelSurface envelope, const TriangleTree& mesh, const std::vector<bool>& open) {
  std::vector<char> parts(envelope.points.size(), 0);  // whether a point deviates from the mesh
  std::vector<char> atEdge(envelope.points.size(), 0);
  for (std::size_t p = 0; p < envelope.points.size(); ++p) {
    const auto nearest = mesh.nearest(envelope.points[p], kTouching);
    parts[p] = !nearest;
    if (parts[p]) continue;
    envelope.points[p] = nearest->point;
    atEdge[p] = open[nearest->triangle];
  }
  std::vector<char> ring(envelope.points.size(), 0);  // whether a point is a corner of a deviating triangle
  for (const Vec3I& t : envelope.triangles) {
    if (parts[t[0]] || parts[t[1]] || parts[t[2]]) ring[t[0]] = ring[t[1]] = ring[t[2]] = 1;
  }
  Lids lids;
  DisjointSets<std::uint32_t> pieces(envelope.points.size());
  for (const Vec3I& t : envelope.triangles) {
    if (!ring[t[0]] && !ring[t[1]] && !ring[t[2]]) continue;
    lids.surface.triangles.push_back(t);
    pieces.join(t[0], t[1]);
    pieces.join(t[1], t[2]);
  }
  std::vector<char> pieceAtEdge(envelope.points.size(), 0);
  for (const Vec3I& t : lids.surface.triangles) {
    for (int c = 0; c < 3; ++c) {
      if (ring[t[c]] && atEdge[t[c]]) pieceAtEdge[pieces.find(t[c])] = 1;
    }
  }
  for (const Vec3I& t : lids.surface.triangles) lids.atEdge.push_back(pieceAtEdge[pieces.find(t[0])] != 0);
  lids.surface.points = std::move(envelope.points);
  return lids;
}

/// The result for one gap width.
struct Closing {
  Lattice lattice;
  double radius = 0;     ///< of the ball, lattice units
  FloatGrid::Ptr field;  ///< signed distance to the region of the ball's centres, lattice units; -radius where it ends
  Lids lids;
  double lost = 1;  ///< the fraction of the mesh that bounds nothing in it
};

Closing closeGaps(const Mesh& mesh, const MeshReport& report, const std::vector<bool>& open, double spacing, double gap,
                  Monitor& monitor) {
  const Phase phase(PhaseKind::ClosingGaps, "of " + shortText(gap));
  Closing closing;
  Lattice& lattice = closing.lattice;
  lattice.middle = report.box.getCenter();
  lattice.spacing = spacing;
  // Half a node more than half the gap: the flood moves from node to node, and could step through a narrower wall.
  closing.radius = 0.5 * gap / lattice.spacing + 0.5;
  const double radius = closing.radius;

  LevelSurface local;
  local.points.reserve(mesh.points.size());
  for (const Vec3d& p : mesh.points) local.points.push_back(lattice.toLattice(p));
  local.triangles = mesh.triangles;

  const TriangleTree tree(local.points, local.triangles);
  const FloatGrid::Ptr distance = unsignedDistances(tree, static_cast<float>(radius + kMargin), phase, monitor);
  floodFromOutside(*distance, radius);
  const LevelSurface reached = levelSurface(*distance, 0);
  // Offset back by the same amount: the closed region begins where the distance from the ball's centres exceeds its
  // radius.
  closing.field = signedDistances(TriangleTree(reached.points, reached.triangles), kMargin,
                                  static_cast<float>(radius + kMargin), phase, monitor);
  closing.lids = findLids(levelSurface(*closing.field, -radius), tree, open);
  monitor.throwIfCancelled();

  closing.lost = lostShare(*closing.field, sampleSurface(local.points, local.triangles, kSamples),
                           static_cast<float>(-radius - kNoInside));
  return closing;
}

/// The welded mesh and its lids as one surface in index space.
LevelSurface withLids(const Mesh& mesh, const Closing& closing, double voxelSize, bool all) {
  LevelSurface surface{toIndexSpace(mesh.points, voxelSize), mesh.triangles};
  const auto first = static_cast<std::uint32_t>(surface.points.size());
  for (const Vec3d& p : closing.lids.surface.points) surface.points.push_back(closing.lattice.toWorld(p) / voxelSize);
  for (std::size_t n = 0; n < closing.lids.surface.triangles.size(); ++n) {
    if (!all && !closing.lids.atEdge[n]) continue;
    const Vec3I& t = closing.lids.surface.triangles[n];
    surface.triangles.emplace_back(t[0] + first, t[1] + first, t[2] + first);
  }
  return surface;
}

/// Signed distances to the surface of a field. Near the surface they are read from the field; farther away they are
/// computed from the surface itself, so that they do not depend on the width of the field's band.
class SurfaceDistance {
 public:
  SurfaceDistance(const FloatGrid& grid, const MeshToSdfOptions& options)
      : mGrid(grid), mPhi(grid.getConstAccessor()), mVoxel(options.voxelSize) {
    // If the value is below this, all corners of the cell lie within any band of at least kExponentMargin voxels.
    constexpr double kNear = 5;
    constexpr double kKnown = 0.99;  // fraction of a narrower band
    mNear = std::min(kNear, kKnown * std::min(options.exteriorBandWidth, options.interiorBandWidth)) * mVoxel;
  }

  /// @param p  world units
  double at(const Vec3d& p) {
    const double value{openvdb::tools::BoxSampler::sample(mPhi, p / mVoxel)};
    if (std::abs(value) < mNear) return value;
    if (!mTree) {
      mSurface = levelSurface(mGrid, 0);
      mTree = std::make_unique<const TriangleTree>(mSurface.points, mSurface.triangles);
    }
    const auto nearest = mTree->nearest(p, std::numeric_limits<double>::max());
    return std::copysign(nearest ? nearest->distance : value, value);
  }

 private:
  const FloatGrid& mGrid;
  FloatGrid::ConstAccessor mPhi;
  double mVoxel, mNear = 0;  ///< world units
  LevelSurface mSurface;     ///< world units; made on first use
  std::unique_ptr<const TriangleTree> mTree;
};

/// See RepairedSdf::moved.
double howFarMoved(const FloatGrid& grid, const Closing& closing, double gap, const Mesh& mesh,
                   const MeshToSdfOptions& options) {
  SurfaceDistance distance(grid, options);
  const FloatGrid::ConstAccessor closed = closing.field->getConstAccessor();
  using openvdb::tools::BoxSampler;
  // The field ends kMargin beyond the ball's reach.
  const double innerWall = std::min(gap / 2 / closing.lattice.spacing, 0.9 * kMargin);
  double moved = 0;
  const auto look = [&](const Vec3d& p) {
    const double depth = -BoxSampler::sample(closed, closing.lattice.toLattice(p)) - closing.radius;
    if (depth > innerWall) return;
    moved = std::max(moved, std::abs(distance.at(p)));
  };
  for (const Vec3I& t : mesh.triangles) {
    for (int c = 0; c < 3; ++c) look(mesh.points[t[c]]);
    look((mesh.points[t[0]] + mesh.points[t[1]] + mesh.points[t[2]]) / 3.0);
  }
  return moved;
}

/// An upper bound of how far the surface lies outside of the field's if the mesh itself was converted: only parts that
/// bound nothing remain.
double howFarLeftOut(const FloatGrid& grid, const Mesh& mesh, const MeshToSdfOptions& options) {
  SurfaceDistance distance(grid, options);
  double moved = 0;
  const auto look = [&](const Vec3d& p) { moved = std::max(moved, distance.at(p)); };
  for (const Vec3I& t : mesh.triangles) {
    for (int c = 0; c < 3; ++c) look(mesh.points[t[c]]);
    look((mesh.points[t[0]] + mesh.points[t[1]] + mesh.points[t[2]]) / 3.0);
  }
  return moved;
}

/// The fraction of the mesh that even the widest gap leaves open. A wider ball encloses whatever a narrower one does,
/// so narrower ones need not be tried. It uses a coarse lattice, which is quick.
double lostAtBest(const Mesh& welded, const MeshReport& report, const std::vector<bool>& open, double voxelSize,
                  double widest, double longest, Monitor& monitor) {
  constexpr double kNodesAlong = 96;
  const double spacing = std::max(voxelSize, longest / kNodesAlong);
  return closeGaps(welded, report, open, spacing, widest, monitor).lost;
}

}  // namespace

RepairedSdf repairedMeshToSdf(const Mesh& mesh, const MeshToSdfOptions& options, const RepairOptions& repair,
                              Monitor& monitor) {
  const MeshReport given = reportMesh(mesh);
  checkOptions(given, options);
  const double h = options.voxelSize;
  const Vec3d sides = given.box.extents();
  const double longest = std::max({sides[0], sides[1], sides[2]});
  if (!(repair.gap >= 0) || repair.gap > longest) {
    throw std::invalid_argument("the gap " + shortText(repair.gap) +
                                " is not between 0 and the longest side of the mesh, " + shortText(longest));
  }
  const Mesh welded = weldMesh(mesh);
  const MeshReport report = reportMesh(welded);
  const std::vector<bool> open = findOpenTriangles(welded);
  const std::vector<SurfaceSample> samples = sampleSurface(toIndexSpace(welded.points, h), welded.triangles, kSamples);

  RepairedSdf best;
  double bestLost = 1;
  const double widest = repair.gap > 0 ? repair.gap : std::max(longest / 4, 2 * h);
  const auto tryCaps = [&](const HoleCappedMesh& capped) {
    PartCounts parts;
    const FloatGrid::Ptr grid =
        convert(toIndexSpace(capped.mesh.points, h), capped.mesh.triangles, options, monitor, &parts);
    const double lost = insideNodes(*grid) > 0 ? lostShare(*grid, samples) : 1;
    if (lost >= bestLost) return;
    best = {grid, howFarLeftOut(*grid, welded, options), capped.widest, capped.caps, parts};
    bestLost = lost;
  };
  bool sheetsOnly = false, hasGaps = false;
  if (repair.gap == 0 && report.openEdges > 0) {
    const HoleCappedMesh capped = capHoles(welded);
    if (capped.caps > 0) tryCaps(capped);
    if (bestLost <= kLostWell) return best;
    hasGaps = capped.gaps > 0;
    sheetsOnly = capped.sheetsOnly;
    // Sheets that do not close up still have pockets that the ball cannot reach.
    constexpr double kLostOfSheets = 0.25;
    if ((sheetsOnly && report.components == 1) ||
        (bestLost > kLostAtMost &&
         lostAtBest(welded, report, open, h, widest, longest, monitor) > (sheetsOnly ? kLostOfSheets : kLostClearly)))
      throw DataError("the mesh encloses nothing that closing its holes could complete (" +
                          std::to_string(report.components) + (report.components == 1 ? " part, " : " parts, ") +
                          std::to_string(report.openEdges) + " open edges): it is terrain, a sheet, or thinner than " +
                          "the voxels, and has to be given a thickness",
                      Remedy::SolidifySheet);
  }
  double gap = repair.gap > 0 ? repair.gap : 2 * h;
  for (;;) {
    const bool wasGood = best.grid && bestLost <= kLostAtMost;
    double spacing = std::max(h, gap / kNodesAcrossGap);
    bool isClosed = false;
    while (!isClosed) {
      const Closing closing = closeGaps(welded, report, open, spacing, gap, monitor);
      if (closing.lost > kLostClearly) break;
      for (const bool all : {false, true}) {
        const LevelSurface surface = withLids(welded, closing, h, all);
        PartCounts parts;
        const FloatGrid::Ptr grid = convert(surface.points, surface.triangles, options, monitor, &parts);
        const double lost = insideNodes(*grid) > 0 ? lostShare(*grid, samples) : 1;
        if (lost < bestLost) {
          best = {grid, howFarMoved(*grid, closing, gap, welded, options), gap, 0, parts};
          bestLost = lost;
        }
        isClosed = lost <= kLostAtMost;
        if (isClosed) break;
      }
      if (spacing <= h) break;
      spacing = std::max(h, spacing / 2);
      const double nodes = report.area / (spacing * spacing) * (gap / spacing + 2 * kMargin);
      if (nodes > kMostLatticeNodes) break;
    }
    if (bestLost <= kLostWell || wasGood || gap >= widest) break;
    gap = std::min(gap * kGapGrowth, widest);
  }
  // Sides of a gap that no ball bridges on this lattice are treated as separate surfaces.
  if (bestLost > kLostAtMost && hasGaps) tryCaps(capHoles(welded, true));
  if (bestLost <= kLostAtMost) return best;
  throw DataError(
      "no gap up to " + shortText(gap) + " encloses the mesh (" + std::to_string(report.openEdges) +
          " open edges, voxel size " + shortText(h) + ", at best " + shortText(100 * bestLost) +
          " % of the surface bounds nothing): it is open, has loose sheets, or is thinner than a voxel; remove "
          "or thicken these, name a wider gap, or use another voxel size",
      sheetsOnly ? Remedy::SolidifySheet : Remedy::None);
}

}  // namespace vdbtools
