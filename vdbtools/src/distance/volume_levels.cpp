// SPDX-License-Identifier: Apache-2.0
#include "distance/volume_levels.h"

#include "base/lattice_transform.h"
#include "distance/distance_band.h"
#include "distance/level_surface.h"
#include "distance/mesh_conversion.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/base/text.h"
#include "vdbtools/distance/target.h"

#include <openvdb/tools/ChangeBackground.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tree/ValueAccessor.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace vdbtools {

using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3d;

namespace {

/// In the index space of the field, in double precision wherever the field lies.
LevelSurface surfaceOf(const FloatGrid& field, double isovalue) {
  const Vec3d middle = Coord::round(field.evalActiveVoxelBoundingBox().getCenter()).asVec3d();
  const auto aboutMiddle = openvdb::math::Transform::createLinearTransform(1.0);
  aboutMiddle->postTranslate(-middle);
  LevelSurface surface = levelSurface(*field.copyReplacingTransform(aboutMiddle), isovalue);
  for (Vec3d& point : surface.points) point += middle;
  return surface;
}

/// Checks what the surface of large tiles takes before it is made: a few bytes of a file can stand for a box of any
/// size.
void requireRoomForSurface(const FloatGrid& field, double isovalue) {
  constexpr double kBytesOfCell = 150;
  const auto values = field.getConstAccessor();
  double cells = 0;
  auto tile = field.tree().cbeginValueAll();
  tile.setMaxDepth(openvdb::FloatTree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    const openvdb::CoordBBox box = tile.getBoundingBox();
    for (int axis = 0; axis < 3; ++axis)
      for (const int step : {-1, 1}) {
        Coord beside = box.min();
        if (step > 0) beside[axis] = box.max()[axis];
        if (beside[axis] == (step < 0 ? Coord::min() : Coord::max())[axis]) continue;
        beside[axis] += step;
        if ((values.getValue(beside) < isovalue) != (*tile < isovalue))
          cells += static_cast<double>(box.dim()[0]) * box.dim()[0];
      }
  }
  requireMemory(kBytesOfCell * cells, MemoryUse::File, "the surface of the grid '" + field.getName() + "'");
}

openvdb::math::Transform::Ptr latticeOfCubes(const FloatGrid& field) {
  if (hasCubicVoxels(field)) return field.transform().copy();
  const Vec3d sides = field.voxelSize(), origin = field.indexToWorld(Vec3d(0));
  openvdb::math::Transform::Ptr lattice = latticeTransform(std::min({sides[0], sides[1], sides[2]}));
  // With the smallest voxels OpenVDB accepts no translation, not even by 0.
  if (!origin.isZero()) lattice->postTranslate(origin);
  return lattice;
}

/// The field with a value beyond its voxels that lies outside, since a dense grid says nothing of what is there.
FloatGrid::ConstPtr withEnd(const FloatGrid& field, bool insideAbove) {
  if (!isDense(field)) return field.copy();
  const ValueRange range = valueRange(field);
  const FloatGrid::Ptr ends = field.deepCopy();
  openvdb::tools::changeBackground(ends->tree(), insideAbove ? range.least : range.greatest);
  return ends;
}

void requireSurface(const FloatGrid& field, double isovalue, bool insideAbove) {
  const ValueRange range = valueRange(field);
  const std::string name = "the grid '" + field.getName() + "'";
  if (!(range.least < isovalue && isovalue < range.greatest))
    throw DataError("the values of " + name + " are " + shortText(range.least) + " to " + shortText(range.greatest) +
                        "; a surface must lie at a value between them, and " + shortText(isovalue) + " is not",
                    Remedy::GiveIsovalue);
  const float beyond = field.background();
  if (insideAbove ? beyond > isovalue : beyond < isovalue)
    throw DataError(name + " has " + shortText(beyond) + " beyond its voxels, which is " +
                        (insideAbove ? "above " : "below ") + shortText(isovalue) +
                        ", so that its inside would have no end",
                    Remedy::TurnSign);
}

}  // namespace

ValueRange valueRange(const FloatGrid& grid) {
  ValueRange range{grid.background(), grid.background()};
  for (auto value = grid.tree().cbeginValueAll(); value; ++value) {
    if (!std::isfinite(*value)) {
      const Coord node = value.getCoord();
      throw DataError("the grid '" + grid.getName() + "' holds a value that is not finite near index " +
                      std::to_string(node[0]) + ", " + std::to_string(node[1]) + ", " + std::to_string(node[2]));
    }
    range.least = std::min(range.least, *value);
    range.greatest = std::max(range.greatest, *value);
  }
  return range;
}

bool isDense(const FloatGrid& grid) { return grid.evalActiveVoxelBoundingBox().volume() == grid.activeVoxelCount(); }

bool isNegativeOutside(const FloatGrid& grid) {
  // Beyond the band, the sign may be stored in tiles of any size.
  return grid.background() < 0 || !grid.evalActiveVoxelBoundingBox().isInside(insideNodeBox(grid));
}

FloatGrid::Ptr withOtherSign(const FloatGrid& grid) {
  const FloatGrid::Ptr turned = grid.deepCopy();
  for (auto value = turned->tree().beginValueAll(); value; ++value) value.setValue(-*value);
  turned->tree().root().setBackground(std::abs(grid.background()), false);
  return turned;
}

FloatGrid::Ptr levelSetOfVolume(const FloatGrid& given, double isovalue, bool insideAbove, Monitor& monitor) {
  constexpr double kBand = 3;  // voxels
  const FloatGrid::ConstPtr ends = withEnd(given, insideAbove);
  const FloatGrid& field = *ends;
  requireSurface(field, isovalue, insideAbove);
  requireRoomForSurface(field, isovalue);
  // OpenVDB's extraction can be stopped before and after it only.
  monitor.throwIfCancelled();
  LevelSurface surface = surfaceOf(field, isovalue);
  monitor.throwIfCancelled();
  const openvdb::math::Transform::Ptr lattice = latticeOfCubes(field);
  const double voxel = lattice->voxelSize()[0];
  for (Vec3d& point : surface.points) point = field.indexToWorld(point);
  try {
    checkOptions(reportMesh({.points = surface.points, .triangles = surface.triangles}),
                 {.voxelSize = voxel, .exteriorBandWidth = kBand, .interiorBandWidth = kBand});
  } catch (const std::invalid_argument& error) {
    // The voxels are those of the file, and nobody chose them.
    throw DataError("the distances to the surface of the grid '" + field.getName() +
                    "' cannot be made: " + error.what());
  }
  for (Vec3d& point : surface.points) point = lattice->worldToIndex(point);
  const TriangleTree tree(surface.points, surface.triangles);
  FloatGrid::Ptr grid = unsignedDistances(tree, static_cast<float>(kBand), PhaseKind::DistanceField, monitor);
  const auto isInside = [=](double value) { return insideAbove ? value > isovalue : value < isovalue; };
  if (hasCubicVoxels(field))
    giveSigns(*grid, monitor, [&] {
      return [&, values = field.getConstAccessor()](const Coord& node) { return isInside(values.getValue(node)); };
    });
  else
    giveSigns(*grid, monitor, [&] {
      return [&, values = field.getConstAccessor()](const Coord& node) {
        return isInside(openvdb::tools::BoxSampler::sample(values, field.worldToIndex(lattice->indexToWorld(node))));
      };
    });
  grid = toWorld(grid, voxel);
  grid->setTransform(lattice);
  grid->setName(field.getName());
  return grid;
}

}  // namespace vdbtools
