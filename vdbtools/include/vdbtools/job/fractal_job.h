// SPDX-License-Identifier: Apache-2.0
/// @file fractal_job.h
/// The room `job` puts the other rooms together into the work of one command: fractals, distances, points and sheets.
/// It uses the rooms up to `scene`.
///
/// This header declares the main job, which makes the field, the mesh and the exported grids of a scene (scene.h).
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/field/crumbs.h"
#include "vdbtools/field/fractal_field.h"
#include "vdbtools/field/islands.h"
#include "vdbtools/field/lattice_options.h"
#include "vdbtools/files/atomic_file.h"
#include "vdbtools/formats/file_formats.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/recipe/recipe.h"
#include "vdbtools/scene/grid_plan.h"
#include "vdbtools/scene/scene.h"
#include "vdbtools/search/solid_meter.h"
#include "vdbtools/surface/extract_mesh.h"
#include "vdbtools/surface/level_set.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdbtools {

/// Which products of a fractal are requested.
struct FractalProducts {
  bool grids = false;  ///< the grids that OutputOptions names, and those of its attributes
  bool mesh = false;
};

/// What runFractal() makes of a scene, and how. It is decided before the work begins.
struct FractalPlan {
  enum class Way {
    Streamed,  ///< mesh and level set are made layer by layer, and the field is not held in memory
    InMemory,  ///< the field is held in memory: if grids of it are made, islands are found, the surface is followed, or
               ///< a box cuts it open
  };

  FieldPlan nodes;
  GridPlan grids;
  bool mesh = false;
  Way way = Way::Streamed;
  Border border = Border::Cap;  ///< of the mesh
};

FractalPlan planFractal(const Scene& scene, const FractalProducts& wanted);

/// The result of runFractal(), except for the mesh, which goes to the sink.
///
///     Mesh mesh;
///     MeshCollector collector(mesh);
///     const FractalPlan plan = planFractal(scene, {.grids = true, .mesh = true});
///     const FractalResult result = runFractal(scene, plan, &collector, monitor);
///     const openvdb::GridBase::Ptr surface = result.grids.front();
struct FractalResult {
  std::vector<openvdb::GridBase::Ptr> grids;  ///< the grids of the plan
  MeshCounts mesh;                            ///< counts of the mesh that went to the sink
  std::uint64_t evaluatedNodes = 0;
  std::optional<FollowReport> follow;   ///< if the surface was followed
  std::optional<IslandReport> islands;  ///< if islands were to be dropped
  std::optional<CrumbReport> crumbs;    ///< if crumbs were dropped, which happens before islands are dropped
  LevelSetCheck check;                  ///< of the level set, if the grids needed one
  std::optional<SolidMeasure> solid;    ///< of the mesh, unless it ends open at a box
  std::vector<MeshLevel> levels;        ///< levels of detail, if a GLB with them was written
  std::vector<ClampedGrid> clamped;     ///< grids with values that were too large for a file of 16-bit floats
};

/// Makes the grids and the mesh of a scene.
/// @param sink  receives the mesh, with normals and the columns that meshColumns() names; nullptr if the plan has no
///              mesh
/// @throw DataError  there is no surface, or only crumbs have one
/// @throw Interrupted
FractalResult runFractal(const Scene& scene, const FractalPlan& plan, MeshSink* sink, Monitor& monitor);

/// Call it for a fractal without a surface. @throw DataError  the fractal would have one if its crumbs had not been
/// dropped
void requireMoreThanCrumbs(const CrumbReport& dropped);

/// Checks whether the whole mesh of a scene can fit into memory. The part that is surely inside the set gives a lower
/// bound of its surface.
/// @throw MemoryError  the mesh will not fit
void requireMemoryForMesh(const Scene& scene);

/// The mesh alone, in memory.
Mesh fractalMesh(const Scene& scene, Monitor& monitor);

// Writes a fractal to files, as `juliavdb fractal` does.

/// A file that takes the grids or the mesh, whichever its format holds.
struct FractalFile {
  AtomicFile* file = nullptr;
  const FileFormat* format = nullptr;  ///< one that is written
};

/// The files of a fractal, at least one of which is given. They must outlive the call.
struct FractalFiles {
  std::vector<FractalFile> files{};
  NvdbValues nvdb = NvdbValues::Full;              ///< how a NanoVDB file stores numbers
  std::vector<NvdbWritten>* nvdbReport = nullptr;  ///< takes what became of the grids in such a file

  bool wantGrids() const;
  bool wantMesh() const;
};

/// The options with which the grids and the mesh of a scene are written.
/// @param metadata  the metadata of the scene
VdbWriteOptions vdbWriteOptions(const OutputOptions& output, std::map<std::string, std::string> metadata);
MeshWriteOptions meshWriteOptions(const FileFormat& format, const OutputOptions& output,
                                  std::map<std::string, std::string> metadata);

/// Makes the grids and the mesh of a scene and writes them, with their metadata. The caller commits the files.
/// @param recipe  the recipe of the scene, which the metadata record
/// @throw std::invalid_argument  no file was given, or an STL would have more triangles than it can count
/// @throw DataError              there is no surface
/// @throw IoError, Interrupted
FractalResult writeFractal(const Scene& scene, const Recipe& recipe, const FractalFiles& files, Monitor& monitor);

/// Writes what runFractal() made of a scene earlier, with the same bytes as writeFractal().
/// @param made          must have grids if a file of grids is written
/// @param mesh, values  the mesh and the values of its columns that runFractal() passed to its sink
/// @return grids with values that were too large for a file of 16-bit floats
/// @throw as writeFractal()
std::vector<ClampedGrid> writeMadeFractal(const Scene& scene, const Recipe& recipe, const FractalResult& made,
                                          const Mesh& mesh, std::span<const float> values, const FractalFiles& files,
                                          Monitor& monitor);

// Recognises files that need not be made again.

/// Whether a file is what writeFractal() of this version of the program makes of a recipe: a VDB, PLY or OBJ that can
/// be read to its end and records exactly this recipe. False for files of other formats, which do not record a recipe
/// (STL), and if there is no such file.
/// @param recipe  complete, with the hashes of its files
bool holdsFractal(const std::filesystem::path& path, const Recipe& recipe);

}  // namespace vdbtools
