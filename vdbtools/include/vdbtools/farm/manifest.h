// SPDX-License-Identifier: Apache-2.0
/// @file manifest.h
/// The room `farm` cuts large jobs into tasks that any machine can do at any time, in any order and more than once, and
/// puts the results together again. It may use all other rooms.
///
/// Here: the plan of a farm, DIR/manifest.json. It is written once and only read afterwards; tasks share nothing else.
/// Tasks count from 1, as the arrays of Slurm and the jobs of GNU parallel do.
#pragma once

#include "vdbtools/base/grids.h"
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
  Tiles,   ///< one fractal, cut into boxes of nodes, to be merged
  Frames,  ///< a fractal for each frame
  Sheet,   ///< a fractal for each of some cells of a contact sheet
};

/// Of PlanKind::Tiles: the lattice that is cut.
struct TileLattice {
  openvdb::CoordBBox domain;  ///< the nodes of the whole, both ends included
  bool bounded = false;       ///< as FieldPlan::bounded
  double voxelSize = 0;       ///< world units
};

struct PlannedTask {
  Recipe recipe;                          ///< what it has besides the plan's recipe, or instead of it
  std::optional<openvdb::CoordBBox> box;  ///< of a tile: the nodes that it owns, both ends included
  std::vector<std::string> writes;        ///< names of files, relative to the folder of the plan
};

/// A file that tasks depend on.
struct PlannedInput {
  std::string path;  ///< absolute, or relative to the folder of the plan
  std::string sha256;
};

struct Manifest {
  PlanKind kind = PlanKind::Tiles;
  Recipe recipe;                                ///< of `juliavdb fractal`, complete, with the hashes of its files
  std::vector<std::string> makes;               ///< of "vdb" and the formats of meshes: what is wanted in the end
  std::map<std::string, std::string> metadata;  ///< of tiles: the metadata of the whole
  std::optional<TileLattice> lattice;           ///< of tiles
  std::vector<PlannedInput> inputs;
  std::vector<PlannedTask> tasks;  ///< task k is tasks[k - 1]
  std::string version;             ///< of the program that planned; filled in by encodeManifest()
};

/// Whether @a format, such as "vdb", is wanted in the end, and whether a mesh of any format is.
bool makes(const Manifest& manifest, std::string_view format);
bool makesMesh(const Manifest& manifest);

inline constexpr const char* kManifestName = "manifest.json";
inline constexpr const char* kLogsName = "logs";  ///< the folder of what engines of tasks say

/// JSON, with a hash over itself and the program's version.
std::string encodeManifest(const Manifest& manifest);

/// The manifest of a plan's folder.
/// @throw MissingInputError  there is none
/// @throw DataError          it is broken, was changed by hand, or was written by another version of the program
Manifest readManifest(const std::filesystem::path& folder);

/// The SHA-256 of all that the result of task @a index depends on. @throw std::out_of_range
std::string taskHash(const Manifest& manifest, std::uint64_t index);

/// The complete recipe of task @a index.
Recipe taskRecipe(const Manifest& manifest, std::uint64_t index);

}  // namespace vdbtools::farm
