// SPDX-License-Identifier: Apache-2.0
/// @file fractal_job.h
/// The room `job` puts the other rooms together into the work of one command: fractals, distances, points and sheets.
/// It uses the rooms up to `scene`.
///
/// The main job from end to end: a scene in (scene.h); field, mesh and hand-off grids out.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/field/crumbs.h"
#include "vdbtools/field/follow_surface.h"
#include "vdbtools/field/fractal_field.h"
#include "vdbtools/field/islands.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/scene/scene.h"
#include "vdbtools/search/solid_meter.h"
#include "vdbtools/surface/extract_mesh.h"
#include "vdbtools/surface/level_set.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace vdbtools {

/// What runFractal() makes beside the mesh that goes to its sink.
///
///     Mesh mesh;
///     MeshCollector collector(mesh);
///     const FractalResult result = runFractal(scene, planScene(scene), true, &collector, monitor);
///     const openvdb::GridBase::Ptr surface = result.grids.front();
struct FractalResult {
  /// Those of OutputOptions::grids, and those of its attributes over the band of the grid "surface", if @a wantGrids.
  std::vector<openvdb::GridBase::Ptr> grids;
  MeshCounts mesh;  ///< of what went to the sink
  std::uint64_t evaluatedNodes = 0;
  std::optional<FollowReport> follow;   ///< if the surface was followed
  std::optional<IslandReport> islands;  ///< if any were to be dropped
  std::optional<CrumbReport> crumbs;    ///< if they were dropped; before the islands
  LevelSetCheck check;                  ///< of the grid "surface", if it was made
  std::optional<SolidMeasure> solid;    ///< of the mesh, unless it ends open at a box
  std::vector<MeshLevel> levels;        ///< of detail, in a GLB that was written
};

/// The grids and the mesh of a scene. The field is held in memory for the grids, to find islands, and what is visited
/// of it to follow the surface; for a mesh alone it is not.
/// @param sink  takes the mesh, with normals and the columns that meshColumns() names; none: no mesh is wanted
/// @throw DataError if there is no surface, or none but that of crumbs
FractalResult runFractal(const Scene& scene, const FieldPlan& plan, bool wantGrids, MeshSink* sink, Monitor& monitor);

/// Of a fractal without a surface. @throw DataError  it would have one if its crumbs had not been dropped
void requireMoreThanCrumbs(const CrumbReport& dropped);

/// For a mesh that is to be held in memory whole. What is surely inside the set bounds its surface from below.
/// @throw MemoryError  the mesh will not fit
void requireMemoryForMesh(const Scene& scene);

/// The mesh alone, in memory.
Mesh fractalMesh(const Scene& scene, Monitor& monitor);

}  // namespace vdbtools
