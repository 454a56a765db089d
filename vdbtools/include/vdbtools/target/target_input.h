// SPDX-License-Identifier: Apache-2.0
/// @file target_input.h
/// The room `target` opens the target that a recipe names, surveys it, and places the space in which maps are iterated.
/// It uses the rooms up to `exponent`.
///
/// This header declares a job's target: what a recipe says about it, and its distances, computed as far from the
/// surface as they are needed.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/base/voxel_choice.h"
#include "vdbtools/distance/target.h"
#include "vdbtools/exponent/local_thickness.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/recipe/recipe_reader.h"
#include "vdbtools/repair/mend_options.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

struct TargetOptions {
  NamedFile input;
  std::shared_ptr<const Mesh> mesh;    ///< a target in memory, for which nothing is read; input.path is its name
  std::string grid;                    ///< of a VDB input; empty: its only one
  std::optional<MeshMoment> moment{};  ///< of a glTF input, at which its animation is shown
  /// The voxels of a mesh's distance field; nullopt: as many as its thin parts need.
  std::optional<VoxelChoice> sdfVoxels{};
  MendOptions mend;  ///< how a solid is made of the file

  bool operator==(const TargetOptions&) const = default;
};

std::vector<OptionSpec> targetOptionSpecs();
/// The SHA-256 of a mesh: of its points as three doubles each, followed by its triangles as three 32-bit numbers each,
/// all little-endian.
std::string sha256OfMesh(const Mesh& mesh);

/// Whether the voxels of a recipe's mesh are chosen by its thin parts.
bool hasAutomaticSdfResolution(const Recipe& recipe);

/// The moment of frame @a frame of the target's animation, as --target-fps and --target-animation say.
MeshMoment momentOfFrame(const RecipeReader& reader, double frame);

/// Returns nullopt if the recipe names no input. @throw std::invalid_argument
std::optional<TargetOptions> parseTargetOptions(const RecipeReader& reader);

/// How far from the surface distances are needed, world units.
struct BandWidths {
  double exterior = 0;
  double interior = 0;
  /// Whether the interior reaches over the whole inside. That takes long and is seldom needed.
  bool wholeInside = false;

  bool operator==(const BandWidths&) const = default;
  /// Whether a band of these widths includes a band of the other widths.
  bool holds(const BandWidths& other) const {
    return other.exterior <= exterior && (wholeInside || (!other.wholeInside && other.interior <= interior));
  }
};

/// The voxel size of the lattice on which a target of this box is surveyed, if its own distances are not coarser. The
/// box has as many voxels as a cube of 128 on a side, but no more than 512 along its longest side, so that thin parts
/// of a long target, such as a wire or a tree, are resolved too.
double surveyVoxel(const openvdb::BBoxd& box);

/// The voxels along the longest side that a mesh's distances have if nobody chose them, unless thin parts need more.
inline constexpr double kUsualSdfResolution = 200;

/// Distances on the lattice of a survey.
struct CoarseDistances {
  openvdb::FloatGrid::ConstPtr phi;
  std::optional<ThicknessFinder> thickness{};  ///< the local thickness, if it was found on the way
};

/// An opened target. Its box is known; its distances are computed on request.
class TargetInput {
 public:
  virtual ~TargetInput() = default;

  virtual const openvdb::BBoxd& box() const = 0;  ///< bounds of the shape, world units

  /// The number of voxels along the longest side that was chosen for the distances, a multiple of 10; nullopt if it was
  /// given, or for a VDB. It depends on the target alone: a twentieth of the surface may belong to parts that are less
  /// than 8 voxels thick, unless this would take more than 400,000 voxels on the surface; it is at least
  /// kUsualSdfResolution, or the resolution of surveyVoxel() if that is larger.
  /// @throw DataError, Interrupted
  virtual std::optional<double> chosenSdfResolution(Monitor& monitor) const = 0;

  /// -E at the depth to which distances should be computed first. Most targets are trapped before; computing a mesh's
  /// distances again costs more than going deep at once, while a VDB may already have them.
  virtual double usualDepth() const = 0;

  /// The distances from which band() makes bands of these widths and of all smaller ones.
  /// @throw DataError, Interrupted
  virtual Target distances(const BandWidths& widths, Monitor& monitor) const = 0;

  /// The target with its distances in a band of these widths. The result depends, to the bit, only on the target and
  /// the widths, not on how much wider the given distances are.
  /// @param distances  of widths that hold these
  /// @throw DataError, Interrupted
  virtual Target band(const Target& distances, const BandWidths& widths, Monitor& monitor) const = 0;

  /// The target with its distances in a band of these widths, on a lattice with voxels of another size; a plate or
  /// balls that would be lost there keep the voxels of the distances.
  /// @throw std::logic_error  the target is a VDB
  /// @throw DataError, Interrupted
  virtual Target bandOf(double voxel, const BandWidths& widths, Monitor& monitor) const = 0;

  /// Distances over the whole inside and a few voxels outside, on a lattice with voxels of surveyVoxel(), or of the
  /// distances' own size if this is larger. So what is surveyed does not depend on how fine they are.
  /// @throw DataError, Interrupted
  virtual CoarseDistances coarseDistances(Monitor& monitor) const = 0;

  /// The mesh that the distances are measured from, world units; nullptr if that is a VDB, or a surface that was made
  /// of a mesh.
  virtual std::shared_ptr<const Mesh> solid() const { return nullptr; }

  /// The mesh as it was read, or a point cloud as converted by asPoints(); nullptr if the target is a VDB.
  virtual std::shared_ptr<const Mesh> mesh() const { return nullptr; }
};

/// @throw MissingInputError, DataError, IoError  as when reading the file
/// @throw DataError  a mesh in memory has no triangle, a coordinate that is not finite, or an index out of range
/// @throw Interrupted
std::unique_ptr<const TargetInput> openTarget(const TargetOptions& options, Monitor& monitor);

}  // namespace vdbtools
