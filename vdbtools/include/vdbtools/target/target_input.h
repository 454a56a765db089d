// SPDX-License-Identifier: Apache-2.0
/// @file target_input.h
/// The room `target` opens the target that a recipe names, surveys it, and places the space in which maps are iterated.
/// It uses the rooms up to `exponent`.
///
/// The target of a job: what a recipe says of it, and its distances, made as far from the surface as they are wanted.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/base/voxel_choice.h"
#include "vdbtools/distance/target.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/recipe/recipe_reader.h"
#include "vdbtools/repair/mend_options.h"

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

  bool operator==(const TargetOptions&) const = default;
};

/// The rule of options that a VDB as the target has and a mesh has not.
std::string idleWithoutVdb(const OptionRun& run);

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
  /// From these on over the whole inside. That takes long, and is seldom needed.
  bool wholeInside = false;

  bool operator==(const BandWidths&) const = default;
  /// Whether a band of these widths holds one of the others.
  bool holds(const BandWidths& other) const {
    return other.exterior <= exterior && (wholeInside || (!other.wholeInside && other.interior <= interior));
  }
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

  /// What band() is made from, for these widths and for all that they hold.
  /// @throw DataError, Interrupted
  virtual Target distances(const BandWidths& widths, Monitor& monitor) const = 0;

  /// The target with its distances in a band of these widths. It depends on the target and on the widths, to the bit,
  /// and not on how much wider the distances are.
  /// @param distances  of widths that hold these
  /// @throw DataError, Interrupted
  virtual Target band(const Target& distances, const BandWidths& widths, Monitor& monitor) const = 0;

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
