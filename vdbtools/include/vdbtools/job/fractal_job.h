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
#include "vdbtools/scene/grid_plan.h"
#include "vdbtools/scene/scene.h"
#include "vdbtools/search/solid_meter.h"
#include "vdbtools/surface/extract_mesh.h"
#include "vdbtools/surface/level_set.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace vdbtools {

/// What is wanted of a fractal.
struct FractalProducts {
  bool grids = false;  ///< those of OutputOptions::grids and of its attributes
  bool mesh = false;
};

/// What runFractal() makes of a scene, and how; decided before the work begins.
struct FractalPlan {
  enum class Way {
    Streamed,  ///< mesh and level set are made layer by layer, and the field is not held in memory
    Held,      ///< the field is: for grids of it, to find islands, to follow the surface, and where a box cuts it open
  };

  FieldPlan nodes;
  GridPlan grids;
  bool mesh = false;
  Way way = Way::Streamed;
  Border border = Border::Cap;  ///< of the mesh
};

FractalPlan planFractal(const Scene& scene, const FractalProducts& wanted);

/// What runFractal() makes beside the mesh that goes to its sink.
///
///     Mesh mesh;
///     MeshCollector collector(mesh);
///     const FractalPlan plan = planFractal(scene, {.grids = true, .mesh = true});
///     const FractalResult result = runFractal(scene, plan, &collector, monitor);
///     const openvdb::GridBase::Ptr surface = result.grids.front();
struct FractalResult {
  std::vector<openvdb::GridBase::Ptr> grids;  ///< those of the plan
  MeshCounts mesh;                            ///< of what went to the sink
  std::uint64_t evaluatedNodes = 0;
  std::optional<FollowReport> follow;   ///< if the surface was followed
  std::optional<IslandReport> islands;  ///< if any were to be dropped
  std::optional<CrumbReport> crumbs;    ///< if they were dropped; before the islands
  LevelSetCheck check;                  ///< of the level set, if the grids needed one
  std::optional<SolidMeasure> solid;    ///< of the mesh, unless it ends open at a box
  std::vector<MeshLevel> levels;        ///< of detail, in a GLB that was written
};

/// Makes the grids and the mesh of a scene.
/// @param sink  takes the mesh, with normals and the columns that meshColumns() names; nullptr if the plan has none
/// @throw DataError  there is no surface, or none but that of crumbs
/// @throw Interrupted
FractalResult runFractal(const Scene& scene, const FractalPlan& plan, MeshSink* sink, Monitor& monitor);

/// Of a fractal without a surface. @throw DataError  it would have one if its crumbs had not been dropped
void requireMoreThanCrumbs(const CrumbReport& dropped);

/// For a mesh that is to be held in memory whole. What is surely inside the set bounds its surface from below.
/// @throw MemoryError  the mesh will not fit
void requireMemoryForMesh(const Scene& scene);

/// The mesh alone, in memory.
Mesh fractalMesh(const Scene& scene, Monitor& monitor);

}  // namespace vdbtools
