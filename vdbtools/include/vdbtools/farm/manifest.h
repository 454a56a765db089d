// SPDX-License-Identifier: Apache-2.0
/// @file manifest.h
/// The room `farm` splits large jobs into tasks that any machine can run at any time, in any order and more than once,
/// and merges the results. It may use all other rooms.
///
/// This header declares a plan, DIR/manifest.json. It is written once and only read afterwards; tasks share nothing
/// else. Tasks count from 1, as the arrays of Slurm and the jobs of GNU parallel do.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/formats/file_formats.h"
#include "vdbtools/recipe/recipe.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdbtools::farm {

enum class PlanKind {
  Tiles,   ///< one fractal, cut into boxes of nodes, whose results are merged
  Frames,  ///< a fractal for each frame
  Sheet,   ///< a fractal for each of some cells of a contact sheet
};

/// The lattice that PlanKind::Tiles cuts.
struct TileLattice {
  openvdb::CoordBBox domain;  ///< the nodes of the whole, both ends included
  bool bounded = false;       ///< as FieldPlan::bounded
  double voxelSize = 0;       ///< world units
};

struct PlannedTask {
  Recipe recipe;                          ///< options that extend or override the plan's recipe
  std::optional<openvdb::CoordBBox> box;  ///< for a tile: the nodes that it owns, both ends included
  std::vector<std::string> writes;        ///< names of files, relative to the folder of the plan
};

/// A file on which tasks depend.
struct PlannedInput {
  std::string path;  ///< absolute, or relative to the folder of the plan
  std::string sha256;
};

struct Manifest {
  PlanKind kind = PlanKind::Tiles;
  Recipe recipe;  ///< of `juliavdb fractal`, complete, with the hashes of its files
  /// The final products: any of writtenFormats(), or kMakeCount alone.
  std::vector<std::string> makes;
  std::map<std::string, std::string> metadata;  ///< for tiles: the metadata of the whole
  std::optional<TileLattice> lattice;           ///< for tiles
  std::vector<PlannedInput> inputs;
  std::vector<PlannedTask> tasks;  ///< task k is tasks[k - 1]
  std::string version;             ///< version of the planning program; encodeManifest() fills it in
};

/// The tiles of a mesh are made and counted, and not kept (tile_count.h).
inline constexpr const char* kMakeCount = "count";

/// Whether @a product, such as "vdb" or kMakeCount, is a final one, and whether grids or a mesh of any format are.
bool makes(const Manifest& manifest, std::string_view product);
bool makesGrids(const Manifest& manifest);
bool makesMesh(const Manifest& manifest);
/// The formats among the products. kMakeCount is none.
std::vector<const FileFormat*> formatsOf(const std::vector<std::string>& products);

inline constexpr const char* kManifestName = "manifest.json";
inline constexpr const char* kLogsName = "logs";  ///< the folder for the logs of job schedulers

/// Encodes the manifest as JSON, with a hash of itself and the program's version.
std::string encodeManifest(const Manifest& manifest);

/// Reads the manifest of a plan's folder.
/// @throw MissingInputError  there is none
/// @throw DataError          it is broken, was edited, or was written by another version of the program
Manifest readManifest(const std::filesystem::path& folder);

/// The SHA-256 of everything on which the result of task @a index depends. @throw std::out_of_range
std::string taskHash(const Manifest& manifest, std::uint64_t index);

/// The complete recipe of task @a index.
Recipe taskRecipe(const Manifest& manifest, std::uint64_t index);

// The folder of a new plan.

/// Checks that a plan can be written there: the folder does not exist, or is empty and writable. writePlan() creates
/// it; whatever this check creates is removed again.
/// @throw CreateError
void requireNewPlanFolder(const std::filesystem::path& folder);

/// Creates the folder if necessary and writes the manifest, the last file of a plan. If that fails, a folder that was
/// created for it is removed again, together with what was prepared for its tasks.
/// @throw CreateError  also if another plan was created there meanwhile
/// @throw IoError
void writePlan(const std::filesystem::path& folder, const Manifest& manifest);

}  // namespace vdbtools::farm
