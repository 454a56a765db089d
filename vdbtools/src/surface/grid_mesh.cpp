// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/surface/level_set.h"

#include "base/grid_memory.h"
#include "base/lattice_transform.h"
#include "distance/distance_band.h"
#include "distance/mesh_conversion.h"
#include "distance/volume_levels.h"
#include "vdbtools/surface/extract_mesh.h"

#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

/// The grid as a field for the search, in index space.
class GridEvaluator final : public julia::FieldEvaluator {
 public:
  explicit GridEvaluator(const openvdb::FloatGrid& grid) : mGrid(grid) {}

  void evaluate(std::span<const julia::Point> points, std::span<double> field, std::span<int>) const override {
    const auto accessor = mGrid.getConstAccessor();
    for (std::size_t i = 0; i < points.size(); ++i)
      field[i] = openvdb::tools::BoxSampler::sample(accessor, openvdb::Vec3d(points[i].data()));
  }
  void versors(std::span<const julia::Point>, std::span<julia::Quaternion<double>> versors) const override {
    std::fill(versors.begin(), versors.end(), julia::Quaternion<double>::one());
  }
  void orbitTraps(std::span<const julia::Point>, std::span<double> nearest) const override {
    std::fill(nearest.begin(), nearest.end(), julia::kFieldLimit);
  }

 private:
  const openvdb::FloatGrid& mGrid;
};

[[noreturn]] void refuseWithoutSurface(const openvdb::FloatGrid& levelSet) {
  throw DataError("the grid '" + levelSet.getName() + "' has no surface: it changes sign nowhere");
}

/// Checks the values as far as possible before their tiles take memory as voxels.
void requireSigns(const openvdb::FloatGrid& levelSet) {
  const ValueRange range = valueRange(levelSet);
  if (!(range.least < 0) || range.greatest < 0) refuseWithoutSurface(levelSet);
}

}  // namespace

Mesh meshOfLevelSet(const openvdb::FloatGrid& levelSet, Monitor& monitor) {
  requireSigns(levelSet);
  FractalField field;
  field.field = openvdb::FloatGrid::create(std::make_shared<openvdb::FloatTree>(levelSet.tree()));
  field.field->setTransform(openvdb::math::Transform::createLinearTransform(1.0));
  field.field->setName(levelSet.getName());
  openvdb::FloatTree& tree = field.field->tree();
  voxelizeActiveTiles(*field.field);
  // A narrow band contains every cell that the surface crosses. Another grid may end inside; then the surface lies
  // between its leaves and the surrounding ones.
  if (levelSet.getGridClass() != openvdb::GRID_LEVEL_SET) {
    std::vector<openvdb::Coord> origins;
    for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) origins.push_back(leaf->origin());
    constexpr int kStep = openvdb::FloatTree::LeafNodeType::DIM;
    for (const openvdb::Coord& origin : origins)
      for (int k = 0; k < 27; ++k)
        tree.touchLeaf(origin.offsetBy((k % 3 - 1) * kStep, (k / 3 % 3 - 1) * kStep, (k / 9 - 1) * kStep));
  }
  field.domain = field.field->evalActiveVoxelBoundingBox();
  field.domain.expand(2);
  field.window = field.domain;
  const GridEvaluator evaluator(*field.field);
  Mesh mesh =
      extractMesh(field, FieldSource{evaluator, FractalSpace{}}, ExtractMeshOptions{.tolerance = 1e-6}, monitor);
  if (mesh.triangles.empty()) refuseWithoutSurface(levelSet);
  for (openvdb::Vec3d& point : mesh.points) point = levelSet.indexToWorld(point);
  const openvdb::Vec3d origin = levelSet.indexToWorld(openvdb::Vec3d(0));
  const auto axis = [&](int k) {
    openvdb::Vec3d unit(0);
    unit[k] = 1;
    return levelSet.indexToWorld(unit) - origin;
  };
  if (axis(0).cross(axis(1)).dot(axis(2)) < 0)  // a mirrored grid reverses its triangles
    for (openvdb::Vec3I& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  return mesh;
}

openvdb::FloatGrid::Ptr redistanced(const openvdb::FloatGrid& levelSet, double band, Monitor& monitor) {
  if (!hasCubicVoxels(levelSet))
    throw DataError("the voxels of the grid '" + levelSet.getName() +
                    "' are not cubes, so that its distances cannot be measured on them; resample it first");
  const double voxel = levelSet.voxelSize()[0];
  Mesh mesh = meshOfLevelSet(levelSet, monitor);
  checkOptions(reportMesh(mesh), {.voxelSize = voxel, .exteriorBandWidth = band, .interiorBandWidth = band});
  for (openvdb::Vec3d& point : mesh.points) point = levelSet.worldToIndex(point);
  const TriangleTree tree(mesh.points, mesh.triangles);
  openvdb::FloatGrid::Ptr grid = unsignedDistances(tree, static_cast<float>(band), PhaseKind::DistanceField, monitor);
  giveSigns(*grid, monitor, [&] {
    return [signs = levelSet.getConstAccessor()](const openvdb::Coord& node) { return signs.getValue(node) < 0; };
  });
  grid = toWorld(grid, voxel);
  grid->setTransform(levelSet.transform().copy());
  return grid;
}

}  // namespace vdbtools
