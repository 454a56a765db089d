// SPDX-License-Identifier: Apache-2.0
#include "farm/merged_grids.h"

#include "base/lattice_transform.h"
#include "field/block_evaluator.h"
#include "field/block_layers.h"
#include "job/output_grids.h"
#include "surface/band_distances.h"

#include "scene/prepared_scene.h"
#include "vdbtools/base/errors.h"

#include <algorithm>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>

namespace vdbtools::farm {
namespace {

namespace fs = std::filesystem;
using openvdb::FloatGrid;
using openvdb::FloatTree;
using Leaf = FloatTree::LeafNodeType;

bool writes(const Manifest& manifest, std::uint64_t index, const std::string& name) {
  const std::vector<std::string>& names = manifest.tasks.at(index - 1).writes;
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Adds the leaves and the active values of one tree to another.
void addPart(FloatTree& whole, const FloatTree& part) {
  for (auto leaf = part.cbeginLeaf(); leaf; ++leaf) {
    Leaf* const there = whole.probeLeaf(leaf->origin());
    if (!there) {
      whole.addLeaf(new Leaf(*leaf));
      continue;
    }
    for (auto value = leaf->cbeginValueOn(); value; ++value) there->setValueOn(value.pos(), *value);
  }
}

/// The distances to the remaining mesh; negative at the nodes of the islands that are kept.
FloatGrid::Ptr keptSurface(const fs::path& folder, const TileJob& job, const PlanIslands& islands, Monitor& monitor) {
  const Mesh mesh = keptMesh(folder, job, islands, monitor);
  if (mesh.triangles.empty()) return nullptr;
  const TileLattice& lattice = job.lattice();
  FloatGrid::Ptr surface = bandDistances(mesh, lattice.voxelSize, lattice.domain, monitor);
  openvdb::tree::ValueAccessor<FloatTree> leaves(surface->tree());
  monitor.begin(PhaseKind::Signs, islands.tiles.size());
  for (std::size_t tile = 0; tile < islands.tiles.size(); ++tile) {
    islands.tiles[tile].forEachOwn([&](std::span<const InsideRun> runs) {
      for (const InsideRun& run : runs) {
        if (!islands.joined.keptParts[tile][run.part]) continue;
        for (int z = run.first; z <= run.last; z = (z | (kBlock - 1)) + 1) {
          Leaf* const leaf = leaves.probeLeaf({run.x, run.y, z});
          if (!leaf) continue;
          const int end = std::min(run.last, z | (kBlock - 1));
          for (int k = z; k <= end; ++k)
            if (const openvdb::Index at = Leaf::coordToOffset({run.x, run.y, k}); leaf->isValueOn(at))
              leaf->setValueOnly(at, -leaf->getValue(at));
        }
      }
    });
    monitor.advance(1);
    monitor.throwIfCancelled();
  }
  return surface;
}

/// The grids of a plan while their parts arrive.
struct GridParts {
  FloatGrid::Ptr surface;
  FractalField field;
};

GridParts readGrids(const fs::path& folder, const TileJob& job, Monitor& monitor) {
  const Manifest& manifest = job.manifest;
  const TileLattice& lattice = job.lattice();
  GridParts parts{.field = emptyField({.domain = lattice.domain,
                                       .bounded = lattice.bounded,
                                       .voxelSize = lattice.voxelSize,
                                       .window = lattice.domain,
                                       .blocks = nullptr},
                                      true)};
  monitor.begin(PhaseKind::MergingGrids, manifest.tasks.size());
  for (std::uint64_t index = 1; index <= manifest.tasks.size(); ++index) {
    if (!writes(manifest, index, tileGridsName(index))) continue;
    const VdbFile file = readVdb(folder / tileGridsName(index));
    if (const FloatGrid::Ptr part = partNamed(file, "surface"); part && !part->empty()) {
      if (!parts.surface) {
        parts.surface = FloatGrid::create(part->background());
        parts.surface->setTransform(latticeTransform(lattice.voxelSize));
      }
      addPart(parts.surface->tree(), part->tree());
    }
    if (const FloatGrid::Ptr part = partNamed(file, "logmodulus")) addPart(parts.field.field->tree(), part->tree());
    if (const FloatGrid::Ptr part = partNamed(file, "iterations"))
      addPart(parts.field.iterations->tree(), part->tree());
    monitor.advance(1);
    monitor.throwIfCancelled();
  }
  return parts;
}

}  // namespace

FloatGrid::Ptr partNamed(const VdbFile& file, const char* name) {
  for (const auto& grid : file.grids)
    if (grid->getName() == name) return openvdb::gridPtrCast<FloatGrid>(grid);
  return nullptr;
}

std::vector<openvdb::GridBase::Ptr> mergeGrids(const fs::path& folder, const TileJob& job, const PlanIslands* islands,
                                               const PlanAttributes* attributes, MergeResult& result,
                                               Monitor& monitor) {
  GridParts parts = readGrids(folder, job, monitor);
  if (job.grids.needsLevelSet()) {
    if (islands) parts.surface = keptSurface(folder, job, *islands, monitor);
    if (!parts.surface && result.crumbs) requireMoreThanCrumbs(*result.crumbs);
    if (!parts.surface) throw DataError("the fractal is empty: no tile has a part of its level set");
    finishLevelSet(*parts.surface);
    result.check = checkSurface(*parts.surface);
    if (!result.check.failure.empty())
      throw std::logic_error("the level set fails OpenVDB's check: " + result.check.failure);
    result.bandVoxels = parts.surface->activeVoxelCount();
  }
  if (job.grids.has(OutputGrid::LogModulus)) {
    fillTiles(parts.field);
    if (islands) dropIslands(parts.field, islands->options, monitor);
  }
  std::optional<Scene> scene;
  std::optional<FieldSource> source;
  if (job.grids.has(OutputGrid::Versor))
    source.emplace(scene.emplace(readPreparedScene(job.options, folder / kPreparedName)).source());
  const std::vector<openvdb::GridBase::Ptr> grids = outputGrids(job.grids,
                                                                {.surface = parts.surface,
                                                                 .field = &parts.field,
                                                                 .source = source ? &*source : nullptr,
                                                                 .attributes = attributes ? &**attributes : nullptr},
                                                                monitor);
  moveGrids(grids, latticeOffset(job.options, job.lattice().voxelSize));
  return grids;
}

}  // namespace vdbtools::farm
