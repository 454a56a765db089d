// SPDX-License-Identifier: Apache-2.0
/// @file target_input.h
/// The target of a job: what a recipe says of it, and its distances, made as far from the surface as they are wanted.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/base/voxel_choice.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/recipe/recipe_reader.h"
#include "vdbtools/target/exponent_grid.h"
#include "vdbtools/target/mend_options.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

struct TargetOptions {
  NamedFile input;
  std::shared_ptr<const Mesh> mesh;  ///< a target in memory, which is not read; input.path is its name
  std::string grid;                  ///< which grid of a VDB input; empty: the only one
  VoxelChoice sdfVoxels;             ///< of a mesh's distance field
  MendOptions mend;                  ///< of a mesh
};

/// Whether both make the same distances of the same file, or of the same mesh in memory.
bool sameTarget(const TargetOptions& a, const TargetOptions& b);

std::vector<OptionSpec> targetOptionSpecs();
/// The SHA-256 of a mesh: of its points as three doubles each and, behind them, of its triangles as three 32-bit
/// numbers each, all little-endian.
std::string sha256OfMesh(const Mesh& mesh);

/// None if the recipe names no input. @throw std::invalid_argument
std::optional<TargetOptions> parseTargetOptions(const RecipeReader& reader);

/// How far from the surface distances are wanted, world units.
struct BandWidths {
  double exterior = 0;
  double interior = 0;
};

inline constexpr double kMostSurveyVoxels = 128;

/// A target that was opened: its box is known, its distances are yet to be made.
class TargetInput {
 public:
  virtual ~TargetInput() = default;

  virtual const openvdb::BBoxd& box() const = 0;  ///< of the shape, world units

  /// -E at the depth to which distances are best made at first. Most targets are trapped before; making a mesh's
  /// distances again costs more than going deep at once, while a VDB may have them.
  virtual double usualDepth() const = 0;

  /// @throw DataError, Interrupted
  virtual Target make(const BandWidths& widths, Monitor& monitor) const = 0;

  /// What make() gave for @a widths with the distances known over the whole inside. That takes long, and is seldom
  /// needed.
  virtual Target deepened(const Target& target, const BandWidths& widths, Monitor& monitor) const = 0;

  /// Distances over the whole inside and a few voxels outside, on a lattice of half the resolution and no more than
  /// kMostSurveyVoxels along the longest side.
  /// @throw DataError, Interrupted
  virtual openvdb::FloatGrid::ConstPtr coarseDistances(Monitor& monitor) const = 0;

  /// The mesh as it was read, or a cloud of points as asPoints() has it; nullptr: the target is a VDB.
  virtual std::shared_ptr<const Mesh> mesh() const { return nullptr; }
};

/// @throw MissingInputError, DataError, IoError  as reading the file
/// @throw DataError  a mesh in memory has no triangle, a coordinate that is not finite, or an index out of range
std::unique_ptr<const TargetInput> openTarget(const TargetOptions& options);

}  // namespace vdbtools
