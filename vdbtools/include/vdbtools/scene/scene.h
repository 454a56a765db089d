// SPDX-License-Identifier: Apache-2.0
/// @file scene.h
/// The room `scene` makes ready what a job evaluates, step by step: target -> space -> exponent -> map -> lattice ->
/// evaluator. The options of a fractal are read here, too, and features are measured that voxels are chosen by.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/exponent/exponent_grid.h"
#include "vdbtools/field/fractal_field.h"
#include "vdbtools/files/input_files.h"
#include "vdbtools/maps/map_descriptor.h"
#include "vdbtools/scene/feature_sizes.h"
#include "vdbtools/scene/fractal_options.h"

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

/// What is found out on the way and recorded in files, by name: hashes, the space, the shell, the versor's roots.
using Metadata = std::map<std::string, std::string>;

/// What the file of a mesh says besides its surface.
struct TargetParts {
  std::vector<std::string> attributes{};
  bool uvs = false;
  std::size_t materials = 0, groups = 0;
};

/// The parts that a recipe does not ask for, each in a few words: "texture coordinates", "2 materials".
std::vector<std::string> unusedParts(const TargetParts& parts, const Recipe& recipe);

/// What `--resolution auto` stands for (voxel_advice.h).
struct ChosenResolution {
  enum class Limit { None, Most, Memory };

  double resolution = 0;  ///< voxels along the target's longest side, a whole number
  Limit limit = Limit::None;
};

/// A target, and what the scene knows of it.
struct SceneTarget {
  Target distances;
  double volume = 0;                         ///< world units cubed
  TargetParts parts{};                       ///< of a mesh
  std::optional<OctaveGrid> octave{};        ///< of a map with a frequency
  ControlGrids controls{};                   ///< of a map that reads some
  std::shared_ptr<const Mesh> mesh{};        ///< as it was read, if attributes are transferred from it
  openvdb::FloatGrid::ConstPtr thickness{};  ///< if it is an attribute: world units, every node of its box active
};

/// The shell about a target in which detail is made.
struct SceneShell {
  /// What the exponent was made with, and what was measured of it.
  struct Made {
    ExponentGridOptions options;
    FeatureSizes features{};
  };

  ExponentGrid exponent;
  std::optional<Made> made{};  ///< not of a scene that was read from a file (prepared_scene.h)
};

/// What is evaluated: a map's field at points of its own space.
struct SceneField {
  std::shared_ptr<const MapInstance> map{};
  julia::OrbitOptions orbit{};
  Arithmetic arithmetic = Arithmetic::Double;  ///< as options.precision has it or as it was chosen
  std::unique_ptr<julia::FieldEvaluator> evaluator{};
  FractalSpace space{};  ///< of the evaluator's points: that of Scene::placed, moved by the map's shift of the lattice
};

/// Everything that is made ready before the first node is evaluated.
///
///     const Recipe recipe = completeRecipe({{"input", "bunny.obj"}, {"detail", "0.4"}}, fractalOptionTable());
///     const Scene scene = makeScene(parseFractalOptions(recipe), monitor);
///     std::vector<double> field(1);
///     scene.field.evaluator->evaluate(std::vector{scene.field.space.toFractal({0, 0.1, 0})}, field, {});
struct Scene {
  FractalOptions options;
  std::optional<SceneTarget> target;  ///< none if no input was given
  /// Where the surface can lie: in a shell about the target or, of a map without one, in a box, world units.
  std::variant<openvdb::BBoxd, SceneShell> domain;
  PlacedSpace placed;    ///< where the options place the set; the exponent, the octave and the controls lie there
  double voxelSize = 0;  ///< of the result, world units
  std::optional<ChosenResolution> chosenResolution;  ///< of `auto`; the options have the number
  std::optional<double> chosenSdfResolution;  ///< of the target's distances, if it was not given; the options have it
  SceneField field;
  Metadata metadata;

  FieldSource source() const { return {*field.evaluator, field.space}; }
  /// The source of what is made of a plan, in whose space the plan's origin is 0.
  FieldSource source(const FieldPlan& plan) const;

  /// Those of the shell; nullptr if there is none or, for the features, if none were measured.
  const ExponentGrid* exponent() const;
  const FeatureSizes* features() const;
  /// What the exponent was made with. @throw std::logic_error  no shell, or a scene that was read from a file
  const ExponentGridOptions& shellOptions() const;
  /// The box of a map without a shell. @throw std::bad_variant_access  there is a shell
  const openvdb::BBoxd& region() const { return std::get<openvdb::BBoxd>(domain); }
};

/// Opens the target that options name.
using TargetOpener = std::function<std::unique_ptr<const TargetInput>(const TargetOptions&, Monitor& monitor)>;

/// Makes scenes one after another; what they share of a target is made once.
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
  std::unique_ptr<Shared> mShared;
};

/// One scene.
Scene makeScene(const FractalOptions& options, Monitor& monitor);

/// The target's mesh, for the attributes of it that are transferred; nullptr if none is.
/// @throw DataError  the target is a VDB, or its mesh has no such attribute at each point
std::shared_ptr<const Mesh> transferredMesh(const FractalOptions& options, const TargetInput& input);

/// The files that the options name: those whose hashes are recorded.
std::vector<NamedFile> filesOf(const FractalOptions& options);
/// The same, so that none of them becomes an output.
InputFiles inputsOf(const FractalOptions& options);

/// A scene's evaluators with other random versors: what its target gives is made once and shared.
class VersorSeeds {
 public:
  /// @param scene  must outlive this
  /// @throw std::invalid_argument  the scene's map has no random roots over a target
  explicit VersorSeeds(const Scene& scene);

  std::uint64_t first() const;  ///< the scene's own

  /// The evaluator that makeScene() would make for this seed: the same bits.
  /// @throw as julia::randomPolynomial()
  std::unique_ptr<julia::FieldEvaluator> evaluator(std::uint64_t seed) const;

 private:
  const Scene& mScene;
};

/// The nodes at which the scene is evaluated: those of the options' box or of the whole set, and with a @a window only
/// those of them that lie in it.
FieldPlan planScene(const Scene& scene, const std::optional<openvdb::CoordBBox>& window = {});

/// How far 32-bit positions are rounded where coordinates are largest, voxels.
double floatRounding(const Scene& scene);

/// Where node 0 of the lattice lies, world units: 0, but for maps with a latticeShift(). Their field is evaluated as if
/// the nodes lay at multiples of the voxel size, in a space that is moved instead (SceneField::space); meshes and grids
/// are moved by this when they leave the program.
openvdb::Vec3d latticeOffset(const FractalOptions& options, double voxelSize);

/// Holds every vertex of the plan's mesh, world units.
openvdb::BBoxd meshBox(const FieldPlan& plan);

/// The recipe of what a scene makes: with the number of voxels where it leaves that to the program.
Recipe resolvedRecipe(const Scene& scene, Recipe recipe);

/// The metadata of what a scene makes: its recipe, the scene's own metadata, the program's version.
std::map<std::string, std::string> sceneMetadata(const Scene& scene, const Recipe& recipe);

}  // namespace vdbtools
