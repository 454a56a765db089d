// SPDX-License-Identifier: Apache-2.0
#include "repair/solid_input.h"

#include "base/lattice_transform.h"
#include "distance/mesh_conversion.h"
#include "distance/volume_levels.h"
#include "repair/open_shapes.h"
#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/recipe/option_value.h"
#include "vdbtools/recipe/recipe.h"
#include "vdbtools/repair/mesh_repair.h"

#include <openvdb/tools/SignedFloodFill.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

namespace vdbtools {

using openvdb::BBoxd;
using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3d;

std::string boxText(const BBoxd& box) {
  const Vec3d &a = box.min(), &b = box.max();
  return numbersText({a[0], a[1], a[2], b[0], b[1], b[2]});
}

namespace {

/// Checks a mesh that no reader has checked, except its indices, which reportMesh() checks.
void requireUsable(const Mesh& mesh, bool asCloud) {
  if (asCloud && mesh.points.empty()) throw DataError("the mesh has no point");
  if (!asCloud && mesh.triangles.empty()) throw DataError("the mesh has no triangle");
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    if (!mesh.points[i].isFinite())
      throw DataError("point " + std::to_string(i) + " of the mesh has a coordinate that is not finite");
}

}  // namespace

SolidSource openSolid(const std::filesystem::path& path, const std::shared_ptr<const Mesh>& given,
                      const MendOptions& mend) {
  return openSolid(path, given, mend, std::nullopt);
}

SolidSource openSolid(const std::filesystem::path& path, const std::shared_ptr<const Mesh>& given,
                      const MendOptions& mend, const std::optional<MeshMoment>& moment) {
  const bool asCloud = mend.pointsRadius > 0;
  SolidSource source;
  if (given) {
    requireUsable(*given, asCloud);
    source.mesh = asCloud ? std::make_shared<const Mesh>(asPoints(*given)) : given;
  } else {
    source.mesh = std::make_shared<const Mesh>(asCloud ? readPoints(path, moment) : readMesh(path, moment));
  }
  source.solid =
      mend.solidify ? std::make_shared<const Mesh>(solidified(*source.mesh, *mend.solidify, mend.repair)) : source.mesh;
  source.report = reportMesh(*source.solid);
  source.box = source.report.box;
  if (mend.offset() > 0) source.box.expand(mend.offset());
  if (!(longestSide(source.box) > 0))
    throw DataError("'" + path.string() + "' has no extent: all its triangles lie in one point");
  return source;
}

void requireResolved(const MendOptions& mend, double voxelSize) {
  constexpr double kVoxelsAcross = 2;
  const double least = kVoxelsAcross * voxelSize, across = 2 * mend.offset();
  if (!(across > 0) || across >= least) return;
  const bool cloud = mend.pointsRadius > 0;
  throw std::invalid_argument(cloud
                                  ? "--points-radius is " + numbersText({mend.pointsRadius}) + "; with voxels of " +
                                        shortText(voxelSize) + " in the target's distance field it must be at least " +
                                        shortText(least / 2) + ", or the voxels smaller"
                                  : "--thicken is " + numbersText({mend.thicken}) + "; with voxels of " +
                                        shortText(voxelSize) + " in the target's distance field it must be at least " +
                                        shortText(least) + ", or the voxels smaller");
}

MeshToSdfOptions sdfBand(double voxelSize, double exteriorWidth, double interiorWidth) {
  return {.voxelSize = voxelSize, .exteriorBandWidth = exteriorWidth, .interiorBandWidth = interiorWidth};
}

MeshSdf makeSdf(const Mesh& solid, const MeshToSdfOptions& asked, const MendOptions& mend, Monitor& monitor) {
  MeshToSdfOptions options = asked;
  options.hollows = mend.hollows;
  if (mend.offset() > 0 || !mend.repair || mend.solidify) {
    MeshSdf sdf;
    sdf.grid = mend.offset() > 0 ? meshToSdf(offsetSurface(solid, mend.offset(), options.voxelSize, monitor), options,
                                             monitor, &sdf.parts)
                                 : meshToSdf(solid, options, monitor, &sdf.parts);
    return sdf;
  }
  RepairedSdf repaired = repairedMeshToSdf(solid, options, {.gap = mend.gap}, monitor);
  return {repaired.grid, repaired.moved, repaired.closedGap, repaired.caps, repaired.parts};
}

namespace {

/// The origin of the leaf nearest to a point. @throw std::invalid_argument  no leaf is near
Coord nearestLeaf(const Vec3d& index) {
  constexpr double kLeaf = openvdb::FloatTree::LeafNodeType::DIM, kFarthest = 1 << 30;
  Coord origin;
  for (int axis = 0; axis < 3; ++axis) {
    const double at = kLeaf * std::round(index[axis] / kLeaf);
    if (!(std::abs(at) < kFarthest))
      throw std::invalid_argument("the middle of the mesh lies at node " + shortText(at) +
                                  " of its distance field, but 2^30 is the last one; use larger voxels, or move the "
                                  "mesh nearer to the origin");
    origin[axis] = static_cast<int>(at);
  }
  return origin;
}

/// The tree of a level set, moved by a number of nodes that are multiples of a leaf's size.
openvdb::FloatTree::Ptr movedTree(const Coord& nodes, const openvdb::FloatTree& tree) {
  auto moved = std::make_shared<openvdb::FloatTree>(tree.background());
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
    auto copy = std::make_unique<openvdb::FloatTree::LeafNodeType>(*leaf);
    copy->setOrigin(leaf->origin() + nodes);
    moved->addLeaf(copy.release());
  }
  float inside = -tree.background();
  for (auto value = tree.cbeginValueOff(); value; ++value) inside = std::min(inside, *value);
  openvdb::tools::signedFloodFillWithValues(*moved, tree.background(), inside);
  return moved;
}

}  // namespace

MeshSdf makeSdfAbout(const Vec3d& middle, Mesh solid, const MeshToSdfOptions& options, const MendOptions& mend,
                     Monitor& monitor) {
  const bool ordinary = isOrdinaryScale(Vec3d(options.voxelSize));
  const Coord nodes = ordinary ? Coord() : nearestLeaf(middle / options.voxelSize);
  const Vec3d about = ordinary ? middle : nodes.asVec3d() * options.voxelSize;
  for (Vec3d& point : solid.points) point -= about;
  MeshSdf sdf = makeSdf(solid, options, mend, monitor);
  if (ordinary)
    sdf.grid->transform().postTranslate(about);
  else
    sdf.grid->setTree(movedTree(nodes, sdf.grid->tree()));
  return sdf;
}

std::string latticeText(const FloatGrid& grid) {
  const Vec3d origin = grid.indexToWorld(Vec3d(0));
  return numbersText({grid.voxelSize()[0], origin[0], origin[1], origin[2]});
}

void placeOnLattice(FloatGrid& grid, const std::string& text) {
  try {
    const std::vector<double> numbers = parseNumbers("lattice", text, 4);
    const VoxelChoice voxel{.voxelSize = numbers[0]};
    grid.setTransform(latticeTransform(voxel.sizeFor(1)));
    // With the smallest voxels OpenVDB accepts no translation, not even by 0.
    const Vec3d origin(numbers[1], numbers[2], numbers[3]);
    if (!origin.isZero()) grid.transform().postTranslate(origin);
  } catch (const std::invalid_argument& error) {
    throw DataError("'" + inOneLine(text) + "' is no lattice: " + error.what());
  }
}

namespace {

/// @throw DataError  @a text is not a box with an extent
BBoxd boxFromMetadata(const std::string& text, const std::filesystem::path& path) {
  try {
    const std::vector<double> b = parseNumbers(kTargetBox, text, 6);
    const BBoxd box(Vec3d(b[0], b[1], b[2]), Vec3d(b[3], b[4], b[5]));
    if (b[0] <= b[3] && b[1] <= b[4] && b[2] <= b[5] && longestSide(box) > 0) return box;
  } catch (const std::invalid_argument&) {
    // The file is at fault, not the request.
  }
  throw DataError("the metadata " + std::string(kTargetBox) + " of '" + path.string() + "' is '" + inOneLine(text) +
                  "'; it must be six finite numbers with commas between them, the smaller corner first");
}

/// Whether this program made the grid from a mesh.
bool isOfMesh(const VdbFile& file, const FloatGrid& grid) {
  if (grid.getName() == "phi") return true;
  const auto renamed = file.metadata.find(kDistanceGrid);
  return commandOfMetadata(file.metadata) == "sdf" && renamed != file.metadata.end() &&
         renamed->second == grid.getName();
}

/// The signed distance of a target that the values of a grid describe. @param facts  receives what was decided
FloatGrid::Ptr signedDistanceOf(FloatGrid::Ptr grid, const VolumeOptions& volume, bool needsCubes,
                                std::map<std::string, std::string>& facts, Monitor& monitor) {
  // An empty grid has no surface; makeTarget() reports it.
  if (grid->activeVoxelCount() == 0) return grid;
  std::optional<double> isovalue = volume.isovalue;
  if (!isovalue && grid->getGridClass() == openvdb::GRID_FOG_VOLUME) {
    const ValueRange range = valueRange(*grid);
    if (range.least >= 0 && range.greatest > 0) {
      isovalue = range.greatest / 2;
      facts[kChosenIsovalue] = numbersText({*isovalue});
    }
  }
  const bool isLevelSet = !isovalue || grid->getGridClass() == openvdb::GRID_LEVEL_SET;
  if (isLevelSet && volume.invert) {
    if (!isDense(*grid) && grid->background() > 0 && !isNegativeOutside(*grid))
      throw std::invalid_argument("--invert turns the sign of a level set, and '" + grid->getName() +
                                  "' is negative inside already; leave it out");
    grid = withOtherSign(*grid);
  }
  const bool becomesCubes = !hasCubicVoxels(*grid) && (isovalue || needsCubes || !isDense(*grid));
  if (!isovalue && !becomesCubes) return grid;
  const Vec3d sides = grid->voxelSize();
  if (becomesCubes) facts[kUnequalSides] = numbersText({sides[0], sides[1], sides[2]});
  return levelSetOfVolume(*grid, isovalue.value_or(0), !isLevelSet && !volume.invert, monitor);
}

}  // namespace

Target readVdbTarget(const std::filesystem::path& path, const std::string& grid, const VolumeOptions& volume,
                     Monitor& monitor, bool needsCubes) {
  const VdbFile file = readVdb(path);
  const FloatGrid::Ptr stored = chooseFloatGrid(file, grid, path);
  std::map<std::string, std::string> facts;
  const FloatGrid::Ptr phi = signedDistanceOf(stored, volume, needsCubes, facts, monitor);
  // The project's own SDF records the box of its mesh, half a voxel more exactly than its nodes do.
  std::optional<BBoxd> box;
  if (const auto found = file.metadata.find(kTargetBox);
      phi == stored && found != file.metadata.end() && isOfMesh(file, *phi))
    box = boxFromMetadata(found->second, path);
  Target target = makeTarget(phi, box);
  target.facts = std::move(facts);
  return target;
}

}  // namespace vdbtools
