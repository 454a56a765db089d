// SPDX-License-Identifier: Apache-2.0
/// @file fractal_job.h
/// The main job from end to end (DESIGN.md section 1): options in; target, exponent, map and evaluator made ready;
/// field, mesh and hand-off grids out.
#pragma once

#include "vdbtools/field/fractal_field.h"
#include "vdbtools/recipe/recipe.h"
#include "vdbtools/surface/extract_mesh.h"
#include "vdbtools/surface/level_set.h"
#include "vdbtools/target/exponent_grid.h"

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace vdbtools {

/// Everything that stands before the first node is evaluated.
struct Scene {
  FractalOptions options;
  std::optional<Target> target;  ///< none if no input was given
  FractalSpace space;
  std::optional<ExponentGrid> exponent;  ///< of the shape modulus
  julia::Rational rational;              ///< the versor, or the rational map
  bool inFloats = false;                 ///< the arithmetic, as options.precision has it or as it was chosen
  std::unique_ptr<julia::FieldEvaluator> evaluator;
  openvdb::BBoxd region;  ///< of a map without a shell, world units
  double voxelSize = 0;   ///< of the result, world units
  /// What was found out on the way, as metadata: hashes, the space, the shell, the versor's roots.
  std::map<std::string, std::string> facts;

  FieldSource source() const { return {*evaluator, space}; }
};

/// @throw what reading, repairing and the options' checks throw
Scene makeScene(const FractalOptions& options, Monitor& monitor);

/// A scene's evaluators with other random versors: what its target gives is made once and shared.
class VersorSeeds {
 public:
  /// @param scene  must outlive this
  /// @throw std::invalid_argument  the map is not the shape modulus, or its versor is not random
  explicit VersorSeeds(const Scene& scene);

  /// The evaluator that makeScene() would make for --versor-seed @a seed: the same bits.
  /// @throw as julia::randomPolynomial()
  std::unique_ptr<julia::FieldEvaluator> evaluator(std::uint64_t seed);

 private:
  const Scene& mScene;
  // Made when first needed, for the arithmetic may depend on the versor.
  std::shared_ptr<const julia::ScalarField<float>> mFloats;
  std::shared_ptr<const julia::ScalarField<double>> mDoubles;
};

/// What of the scene is evaluated: the options' box or the whole set.
FieldPlan planScene(const Scene& scene);

/// Holds every vertex of the plan's mesh, world units.
openvdb::BBoxd meshBox(const FieldPlan& plan);

struct FractalResult {
  std::vector<openvdb::GridBase::Ptr> grids;  ///< those of options.grids, if @a wantGrids
  MeshCounts mesh;                            ///< of what went to the sink
  std::uint64_t evaluatedNodes = 0;
  std::optional<FollowReport> follow;   ///< if the surface was followed
  std::optional<IslandReport> islands;  ///< if any were to be dropped
  LevelSetCheck check;                  ///< of the grid "surface", if it was made
};

/// The grids and the mesh of a scene. The field is held in memory for the grids, to find islands, and what is visited
/// of it to follow the surface; for a mesh alone it is not.
/// @param sink  takes the mesh, with normals; none: no mesh is wanted
/// @throw DataError if there is no surface
FractalResult runFractal(const Scene& scene, const FieldPlan& plan, bool wantGrids, MeshSink* sink, Monitor& monitor);

/// The mesh alone, in memory.
Mesh fractalMesh(const Scene& scene, Monitor& monitor);

struct SdfResult {
  openvdb::FloatGrid::Ptr grid;
  MeshReport report;
  std::optional<double> moved, closedGap;  ///< of a repair, world units
  std::map<std::string, std::string> facts;
};

/// Mesh -> signed distance field, as `juliavdb sdf` does it.
SdfResult runSdf(const SdfOptions& options, Monitor& monitor);

}  // namespace vdbtools
