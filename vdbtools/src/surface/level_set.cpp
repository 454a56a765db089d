// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/surface/level_set.h"

#include "distance/distance_band.h"
#include "distance/mesh_conversion.h"
#include "surface/band_distances.h"

#include <openvdb/tools/Diagnostics.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tools/Prune.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tree/LeafManager.h>

#include <cmath>

namespace vdbtools {

using openvdb::FloatGrid;
using openvdb::FloatTree;

FloatGrid::Ptr bandDistances(const Mesh& mesh, double voxelSize, const openvdb::CoordBBox& domain, Monitor& monitor) {
  const std::vector<openvdb::Vec3d> points = toIndexSpace(mesh.points, voxelSize);
  const TriangleTree tree(points, mesh.triangles, domain.getCenter());
  return toWorld(unsignedDistances(tree, kHalfWidth, PhaseKind::LevelSet, monitor), voxelSize);
}

FloatGrid::Ptr levelSetPart(const FractalField& field, const FieldSource& source, const Mesh& mesh,
                            const openvdb::CoordBBox& nodes, Monitor& monitor) {
  if (mesh.triangles.empty()) {
    FloatGrid::Ptr none = FloatGrid::create(static_cast<float>(kHalfWidth * field.field->voxelSize()[0]));
    none->setTransform(field.field->transform().copy());
    return none;
  }
  FloatGrid::Ptr grid = bandDistances(mesh, field.field->voxelSize()[0], field.domain, monitor);
  using LeafManager = openvdb::tree::LeafManager<FloatTree>;
  LeafManager leaves(grid->tree());
  tbb::parallel_for(leaves.leafRange(), [&](const LeafManager::LeafRange& range) {
    openvdb::tree::ValueAccessor<const FloatTree> known(field.field->tree());
    std::vector<openvdb::Index> offsets;
    std::vector<julia::Point> points;
    std::vector<double> values;
    for (auto leaf = range.begin(); leaf; ++leaf) {
      const FloatTree::LeafNodeType* const signs = known.probeConstLeaf(leaf->origin());
      offsets.clear();
      points.clear();
      for (auto value = leaf->beginValueOn(); value; ++value) {
        const openvdb::Coord node = value.getCoord();
        if (!nodes.isInside(node)) {
          value.setValueOff();
        } else if (signs) {
          if (signs->getValue(value.pos()) < 0) value.setValue(-*value);
        } else if (field.domain.isInside(node)) {
          // The sign must be that of the neighbours, which may lie beyond the window.
          offsets.push_back(value.pos());
          points.push_back(source.space.toFractal(node.asVec3d() * field.field->voxelSize()[0]));
        }
      }
      values.resize(points.size());
      if (!points.empty()) source.evaluator.evaluate(points, values, {});
      for (std::size_t i = 0; i < offsets.size(); ++i)
        if (julia::storedField(values[i]) < 0) leaf->setValueOnly(offsets[i], -leaf->getValue(offsets[i]));
    }
  });
  // Removes leaves without an active node.
  openvdb::tools::pruneInactive(grid->tree());
  return grid;
}

void finishLevelSet(FloatGrid& grid) {
  openvdb::tools::signedFloodFill(grid.tree());
  openvdb::tools::pruneLevelSet(grid.tree());
  grid.setName("surface");
  grid.setGridClass(openvdb::GRID_LEVEL_SET);
}

FloatGrid::Ptr levelSet(const FractalField& field, const Mesh& mesh, Monitor& monitor) {
  if (mesh.triangles.empty()) throw DataError("the fractal is empty here: there is no surface");
  FloatGrid::Ptr grid = bandDistances(mesh, field.field->voxelSize()[0], field.domain, monitor);
  // F gives the sign at every node, also in closed bubbles, which a flood fill from outside would call inside.
  using LeafManager = openvdb::tree::LeafManager<FloatTree>;
  LeafManager leaves(grid->tree());
  tbb::parallel_for(leaves.leafRange(), [&](const LeafManager::LeafRange& range) {
    openvdb::tree::ValueAccessor<const FloatTree> sign(field.field->tree());
    for (auto leaf = range.begin(); leaf; ++leaf)
      for (auto value = leaf->beginValueOn(); value; ++value)
        if (sign.getValue(value.getCoord()) < 0) value.setValue(-*value);
  });
  finishLevelSet(*grid);
  return grid;
}

FloatGrid::Ptr densityGrid(const FloatGrid& surface) {
  FloatGrid::Ptr grid = surface.deepCopy();
  openvdb::tools::sdfToFogVolume(*grid);
  grid->setName("density");
  return grid;
}

FloatGrid::Ptr logModulusGrid(const FractalField& field) {
  FloatGrid::Ptr grid = field.field->deepCopy();
  grid->setName("logmodulus");
  grid->setGridClass(openvdb::GRID_UNKNOWN);
  return grid;
}

openvdb::Vec3SGrid::Ptr versorGrid(const FloatGrid& surface, const FieldSource& source, Monitor& monitor) {
  auto tree = std::make_shared<openvdb::Vec3STree>(surface.tree(), openvdb::Vec3s(0), openvdb::TopologyCopy());
  openvdb::tree::LeafManager<openvdb::Vec3STree> leaves(*tree);
  monitor.begin(PhaseKind::Versor, leaves.leafCount());
  leaves.foreach ([&](openvdb::Vec3STree::LeafNodeType& leaf, std::size_t) {
    if (monitor.cancelled()) return;
    std::vector<julia::Point> points;
    for (auto value = leaf.cbeginValueOn(); value; ++value)
      points.push_back(source.space.toFractal(surface.indexToWorld(value.getCoord())));
    const std::vector<openvdb::Vec3s> versors = source.versorVectors(points);
    std::size_t k = 0;
    for (auto value = leaf.beginValueOn(); value; ++value, ++k) value.setValue(versors[k]);
    monitor.advance(1);
  });
  monitor.throwIfCancelled();
  auto grid = openvdb::Vec3SGrid::create(tree);
  grid->setTransform(surface.transform().copy());
  grid->setName("versor");
  return grid;
}

LevelSetCheck checkSurface(const FloatGrid& surface) {
  LevelSetCheck check;
  check.failure = openvdb::tools::checkLevelSet(surface, 8);
  // If voxels are not cubes there is no gradient to check; the check has reported it.
  if (!surface.hasUniformVoxels()) return check;
  openvdb::tools::Diagnose<FloatGrid> diagnose(surface);
  openvdb::tools::CheckNormGrad<FloatGrid> test(surface, 0.5f, 1.5f);
  const std::uint64_t active = surface.activeVoxelCount();
  const std::string failures = diagnose.check(test, false, true, false, false);
  (void)failures;
  check.gradientFraction = active ? 1 - static_cast<double>(diagnose.failureCount()) / static_cast<double>(active) : 0;
  return check;
}

}  // namespace vdbtools
