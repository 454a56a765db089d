// SPDX-License-Identifier: Apache-2.0
/// @file scene.h
/// The room `scene` prepares what a job evaluates, step by step: target -> space -> exponent -> map -> lattice ->
/// evaluator. It also reads the options of a fractal, and measures the features by which voxels are chosen.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/exponent/exponent_grid.h"
#include "vdbtools/field/fractal_field.h"
#include "vdbtools/files/input_files.h"
#include "vdbtools/maps/map_descriptor.h"
#include "vdbtools/render/view_options.h"
#include "vdbtools/scene/feature_sizes.h"
#include "vdbtools/scene/fractal_options.h"

#include "julia/deformed_evaluator.h"
#include "julia/evaluator.h"

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace vdbtools {

/// Facts that are found while a scene is made and that files record, by name: hashes, the space, the shell, the
/// versor's roots.
using Metadata = std::map<std::string, std::string>;

/// What the file of a mesh contains besides its surface.
struct TargetParts {
  std::vector<std::string> attributes{};
  bool uvs = false;
  std::size_t materials = 0, groups = 0;
};

/// The parts that a recipe does not use, each in a few words: "texture coordinates", "2 materials".
std::vector<std::string> unusedParts(const TargetParts& parts, const Recipe& recipe);

/// The number that replaces `--resolution auto` (voxel_advice.h).
struct ChosenResolution {
  enum class Limit { None, Most, Memory };

  double resolution = 0;  ///< voxels along the target's longest side, a whole number
  Limit limit = Limit::None;
};

/// The target of a scene, and what was found out about it.
struct SceneTarget {
  Target distances;
  double volume = 0;                         ///< world units cubed
  TargetParts parts{};                       ///< if it is a mesh
  std::optional<OctaveGrid> octave{};        ///< if the map has a frequency
  ControlGrids controls{};                   ///< if the map reads controls
  std::shared_ptr<const Mesh> mesh{};        ///< as it was read, if attributes are transferred from it
  openvdb::FloatGrid::ConstPtr thickness{};  ///< if it is an attribute: world units, every node of its box active
};

/// The shell about a target in which detail is made.
struct SceneShell {
  /// The options from which the exponent was made, and the features that were measured.
  struct Made {
    ExponentGridOptions options;
    FeatureSizes features{};
  };

  ExponentGrid exponent;
  std::optional<Made> made{};  ///< empty if the scene was read from a file (prepared_scene.h)
};

/// The target at rest, for a scene whose target has moved (FractalOptions::rest).
struct SceneAtRest {
  ExponentGrid exponent;
  Target distances;
  std::shared_ptr<const Mesh> mesh;
  openvdb::BBoxd box;  ///< of the shape, world units
  double jumps = 0;    ///< the part of the shell in the pose over which the way back jumps between parts of the surface
};

/// What is evaluated: a map's field at points of its own space.
struct SceneField {
  std::shared_ptr<const MapInstance> map{};
  julia::OrbitOptions orbit{};
  Arithmetic arithmetic = Arithmetic::Double;  ///< as options.precision requests, or chosen automatically
  std::unique_ptr<julia::FieldEvaluator> evaluator{};
  /// From a pose to the target at rest, if the options say how it is there; the evaluator is made with it.
  std::shared_ptr<const julia::Deformation> deformation{};
  FractalSpace
      space{};  ///< the space of the evaluator's points: Scene::placed's, moved by the map's shift of the lattice
};

/// Everything that is prepared before the first node is evaluated.
///
///     const Recipe recipe = completeRecipe({{"input", "bunny.obj"}, {"detail", "0.4"}}, fractalOptionTable());
///     const Scene scene = makeScene(parseFractalOptions(recipe), monitor);
///     std::vector<double> field(1);
///     scene.field.evaluator->evaluate(std::vector{scene.field.space.toFractal({0, 0.1, 0})}, field, {});
struct Scene {
  FractalOptions options;
  std::optional<SceneTarget> target;  ///< none if no input was given
  /// Where the surface can lie: in a shell about the target or, for a map without a shell, in a box, world units.
  std::variant<openvdb::BBoxd, SceneShell> domain;
  PlacedSpace placed;    ///< where the options place the set; the exponent, the octave and the controls lie there
  double voxelSize = 0;  ///< of the result, world units
  std::optional<ChosenResolution> chosenResolution;  ///< if it was `auto`; the options have the number
  std::optional<double> chosenSdfResolution;  ///< for the target's distances, if it was not given; the options have it
  SceneField field;
  std::optional<SceneAtRest> rest{};  ///< if the target has moved; target and domain are those of its pose
  std::shared_ptr<const SurfaceVelocity> velocity{};  ///< of the target, if it is wanted
  Metadata metadata;

  FieldSource source() const { return {*field.evaluator, field.space}; }
  /// The field source for a plan. In its space, the origin of the plan is 0.
  FieldSource source(const FieldPlan& plan) const;

  /// An evaluator as the field's, of other orbits.
  std::unique_ptr<julia::FieldEvaluator> evaluator(const julia::OrbitOptions& orbit) const;

  /// The places of points at rest; world units. Points far from the surface, and those of a target that has not moved,
  /// are where they are.
  std::vector<openvdb::Vec3d> atRest(std::span<const openvdb::Vec3d> points) const;

  /// The exponent and the features of the shell; nullptr if there is no shell or, for the features, if none were
  /// measured.
  const ExponentGrid* exponent() const;
  const FeatureSizes* features() const;
  /// The options from which the exponent was made. @throw std::logic_error  no shell, or a scene that was read from a
  /// file
  const ExponentGridOptions& shellOptions() const;
  /// The box of a map without a shell. @throw std::bad_variant_access  there is a shell
  const openvdb::BBoxd& region() const { return std::get<openvdb::BBoxd>(domain); }
};

/// Opens the target that options name.
using TargetOpener = std::function<std::unique_ptr<const TargetInput>(const TargetOptions&, Monitor& monitor)>;

/// Makes scenes one after another. Those parts of a target that several scenes share are made once.
class SceneMaker {
 public:
  explicit SceneMaker(TargetOpener open = openTarget);
  ~SceneMaker();

  /// @throw what reading, repairing and the options' checks throw
  Scene make(const FractalOptions& options, Monitor& monitor);
  /// The local thickness of the options' target, limited in slope to @a slope alone.
  /// @throw as make()
  LocalThickness thickness(const FractalOptions& options, double slope, Monitor& monitor);

 private:
  struct Shared;
  Scene makeStill(const FractalOptions& options, Monitor& monitor);
  std::unique_ptr<Shared> mShared;
};

/// Makes a single scene.
Scene makeScene(const FractalOptions& options, Monitor& monitor);

/// The target's mesh if any of its attributes are transferred; otherwise nullptr.
/// @throw DataError  the target is a VDB, or its mesh has no such attribute at each point
std::shared_ptr<const Mesh> transferredMesh(const FractalOptions& options, const TargetInput& input);

/// How the target moves; nullptr if that is not wanted. @param now  its mesh
/// @throw as surfaceVelocity()
std::shared_ptr<const SurfaceVelocity> velocityOf(const FractalOptions& options,
                                                  const std::shared_ptr<const Mesh>& now);

/// The files that the options name: those whose hashes are recorded.
std::vector<NamedFile> filesOf(const FractalOptions& options);
/// The same files, so that no output replaces one of them.
InputFiles inputsOf(const FractalOptions& options);

/// Makes the evaluators of a scene with other random versors. What depends on the target alone is made once and shared.
class VersorSeeds {
 public:
  /// @param scene  must outlive this
  /// @throw std::invalid_argument  the scene's map has no random roots over a target
  explicit VersorSeeds(const Scene& scene);

  std::uint64_t first() const;  ///< the seed of the scene itself

  /// The evaluator that makeScene() would make for this seed: the same bits.
  /// @throw as julia::randomPolynomial()
  std::unique_ptr<julia::FieldEvaluator> evaluator(std::uint64_t seed) const;

 private:
  const Scene& mScene;
};

/// The nodes at which the scene is evaluated: all nodes of the options' box, or of the whole set; with a @a window,
/// only the nodes in it.
FieldPlan planScene(const Scene& scene, const std::optional<openvdb::CoordBBox>& window = {});

/// How far 32-bit positions are rounded where coordinates are largest, voxels.
double floatRounding(const Scene& scene);

/// Where node 0 of the lattice lies, world units: 0, except for maps with a latticeShift(). For these, the field is
/// evaluated as if the nodes lay at multiples of the voxel size, in a space that is moved instead (SceneField::space);
/// meshes and grids are moved by this offset when they leave the program.
openvdb::Vec3d latticeOffset(const FractalOptions& options, double voxelSize);

/// A box that contains every vertex of the plan's mesh, world units.
openvdb::BBoxd meshBox(const FieldPlan& plan);

/// The recipe to record for a scene: if it left the number of voxels to the program, it gets the chosen number.
Recipe resolvedRecipe(const Scene& scene, Recipe recipe);

/// The metadata of files that are made from a scene: its recipe, its own metadata, and the program's version.
std::map<std::string, std::string> sceneMetadata(const Scene& scene, const Recipe& recipe);

// The part of a scene that a picture of a plane shows.

/// The scene's box, or its target with a margin, world units. A picture shows the rectangle that its plane cuts out of
/// this box.
openvdb::BBoxd sliceFrame(const Scene& scene);

// Prepares a scene for the renderer: the region that rays go through, and the options of the picture.

/// The region that rays go through, world units: the requested box, or the whole set.
openvdb::BBoxd pictureRegion(const Scene& scene);

/// The options for the renderer: @a picture with the scene's camera, colours, orbit and dropped axis.
/// @param region  as pictureRegion() has it
/// @param usual   the colours if neither the picture nor the recipe gives any
/// @throw what reading the gradient of the colours throws
FieldRenderOptions pictureOptions(const Scene& scene, const openvdb::BBoxd& region, const FieldPicture& picture,
                                  FieldColour usual = FieldColour::Clay);

}  // namespace vdbtools
