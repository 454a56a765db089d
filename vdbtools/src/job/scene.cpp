// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/job/scene.h"

#include "target/solid_input.h"
#include "vdbtools/base/errors.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace vdbtools {
namespace {

using openvdb::BBoxd;
using openvdb::Vec3d;

/// The orbit as far as the options give it: the exponent adds its trap.
julia::OrbitOptions orbitOf(const FractalOptions& options) {
  julia::OrbitOptions orbit = options.map->orbit();
  orbit.confirmTrap = options.lattice.exhaustive;
  return orbit;
}

std::unique_ptr<const TargetInput> openInput(const FractalOptions& options) {
  if (options.target) return openTarget(*options.target);
  if (options.map->shell())
    throw std::invalid_argument("the map needs a target: give a mesh, or a VDB with its signed distance");
  return nullptr;
}

Facts hashesOf(const FractalOptions& options) {
  std::vector<NamedFile> files = options.map->files();
  if (options.target) files.push_back(options.target->input);
  Facts facts;
  for (const auto& [name, hash] : verifiedHashes(files)) facts[metadataName(name)] = hash;
  return facts;
}

/// alpha and beta over the target; none for a map without a shell.
std::optional<ExponentGridOptions> bindControls(const FractalOptions& options, const BBoxd& box) {
  const ShellSettings* shell = options.map->shell();
  if (!shell) return std::nullopt;
  const ControlContext context{.targetBox = box};
  return ExponentGridOptions{.alpha = shell->alpha->bind(context),
                             .beta = shell->beta->bind(context),
                             .orbit = orbitOf(options),
                             .interpolation = shell->interpolation};
}

/// How far from the surface distances are made at first. A map without a shell gets those of the usual one.
BandWidths widthsOf(const FractalOptions& options, const TargetInput& input,
                    const std::optional<ExponentGridOptions>& controls) {
  const ExponentGridOptions shell = controls.value_or(ExponentGridOptions{.orbit = orbitOf(options)});
  const double scale = spaceScale(options.space, input.box());
  return {.exterior = exteriorReach(shell) * scale,
          .interior = std::max(interiorReach(shell, input.usualDepth()) * scale,
                               options.map->interiorReach() * longestSide(input.box()))};
}

/// The target, as deep as its space needs it.
Target targetOf(const FractalOptions& options, const TargetInput& input, const BandWidths& widths, Monitor& monitor) {
  Target target = input.make(widths, monitor);
  return needsDeepestPoint(options.space, target) ? input.deepened(target, widths, monitor) : target;
}

struct Shell {
  Target target;  ///< as deep as the exponent needs it
  ExponentGrid exponent;
};

Shell makeShell(const Target& target, const TargetInput& input, const BandWidths& widths, const FractalSpace& space,
                const ExponentGridOptions& controls, Monitor& monitor) {
  ExponentGrid exponent = exponentGrid(target, space, controls, monitor);
  if (!exponent.tooShallow) return {target, std::move(exponent)};
  Target deep = input.deepened(target, widths, monitor);
  exponent = exponentGrid(deep, space, controls, monitor);
  return {std::move(deep), std::move(exponent)};
}

struct Lattice {
  double voxelSize = 0;  ///< world units
  BBoxd region;          ///< of a map without a shell, world units
};

/// Where a map without a shell is evaluated, world units.
/// @param shape  the box of the shape that it has, if it has one
BBoxd regionOf(const FractalOptions& options, const std::optional<BBoxd>& shape, const MapFiles& files,
               const FractalSpace& space) {
  constexpr double kMargin = 0.25;  // of the shape's longest side
  if (options.lattice.box) return *options.lattice.box;
  if (shape) {
    BBoxd box = *shape;
    box.expand(kMargin * longestSide(box));
    return box;
  }
  if (const std::optional<double> radius = options.map->radius())
    return {space.toWorld({-*radius, -*radius, -*radius}), space.toWorld({*radius, *radius, *radius})};
  if (files.region) return *files.region;
  throw std::invalid_argument(
      "a rational map that was not fitted to a shape has no region of its own; give a box, or a mesh");
}

/// @param hasShell  the region is that of the exponent, and not made here
Lattice chooseLattice(const FractalOptions& options, bool hasShell, const std::optional<BBoxd>& shape,
                      const MapFiles& files, const FractalSpace& space) {
  Lattice lattice;
  if (!hasShell) lattice.region = regionOf(options, shape, files, space);
  lattice.voxelSize = options.lattice.voxels.sizeFor(longestSide(shape ? *shape : lattice.region));
  // Room for the outermost cells of a set that fills its region.
  constexpr double kRoom = 2;  // voxels
  if (!hasShell && !options.lattice.box) lattice.region.expand(kRoom * lattice.voxelSize);
  return lattice;
}

/// Whether the voxels are large against the rounding of 32-bit positions.
bool voxelsAreLarge(double voxelSize, const BBoxd& box, const FractalSpace& space, const julia::Embedding& embedding) {
  constexpr double kLeastVoxel = 1e-3;  // of the largest coordinate: a thousandth of it is still resolved
  double largest = std::max(1.0, std::abs(embedding.slice));
  for (const Vec3d& corner : {box.min(), box.max()})
    for (const double x : space.toFractal(corner)) largest = std::max(largest, std::abs(x));
  return voxelSize / space.scale >= kLeastVoxel * largest;
}

/// @param box  what is evaluated, or the target's, world units
Arithmetic chooseArithmetic(const FractalOptions& options, const MapInstance& map, double voxelSize, const BBoxd& box,
                            const FractalSpace& space) {
  switch (options.precision) {
    case Precision::Float: return Arithmetic::Float;
    case Precision::Double: return Arithmetic::Double;
    case Precision::Auto: break;
  }
  // docs/precision.md has the measurements.
  const bool floats =
      map.floatsServe(options.map->orbit()) && voxelsAreLarge(voxelSize, box, space, options.map->embedding());
  return floats ? Arithmetic::Float : Arithmetic::Double;
}

Arithmetic chooseArithmetic(const Scene& scene, const MapInstance& map, const FractalSpace& space) {
  return chooseArithmetic(scene.options, map, scene.voxelSize, scene.exponent ? scene.target->box : scene.region,
                          space);
}

Facts spaceFacts(const FractalSpace& space) {
  const Vec3d& centre = space.centre;
  return {{"julia_space_centre", numbersText({centre[0], centre[1], centre[2]})},
          {"julia_space_scale", numbersText({space.scale})}};
}

Facts targetFacts(const Target& target) {
  Facts facts{{kTargetBox, boxText(target.box)}};
  if (target.repairMoved) facts["julia_repair_moved"] = numbersText({*target.repairMoved});
  return facts;
}

}  // namespace

Scene makeScene(const FractalOptions& options, Monitor& monitor) {
  openvdb::initialize();
  Scene scene;
  scene.options = options;
  scene.orbit = orbitOf(options);
  const MapFiles files = options.map->readFiles();
  const std::unique_ptr<const TargetInput> input = openInput(options);
  const std::optional<FittedTo> fitted = files.roots ? files.roots->target : std::nullopt;

  PlacedSpace placed;
  std::optional<BBoxd> shape;
  if (input) {
    shape = input->box();
    scene.exponentOf = bindControls(options, *shape);
    scene.facts.merge(hashesOf(options));
    const BandWidths widths = widthsOf(options, *input, scene.exponentOf);
    scene.target = targetOf(options, *input, widths, monitor);
    placed = placeSpace(options.space, *scene.target);
    if (scene.exponentOf) {
      Shell shell = makeShell(*scene.target, *input, widths, placed.space, *scene.exponentOf, monitor);
      scene.target = std::move(shell.target);
      scene.exponent = std::move(shell.exponent);
      scene.orbit = scene.exponent->orbit;
      const julia::ShellInterval& interval = scene.exponent->shell;
      scene.facts["julia_shell"] = numbersText({interval.lower, interval.upper});
    }
    scene.facts.merge(targetFacts(*scene.target));
  } else {
    scene.facts.merge(hashesOf(options));
    placed = placeSpace(options.space, fitted ? &fitted->space : nullptr);
    if (fitted && options.space.kind == SpaceKind::Fit) shape = fitted->box;
  }

  scene.map = options.map->instance({.files = files,
                                     .target = scene.target ? &*scene.target : nullptr,
                                     .space = placed.space,
                                     .unmovedSpace = placed.unmoved,
                                     .exponent = scene.exponent ? &*scene.exponent : nullptr});
  scene.facts.merge(scene.map->facts());

  const Lattice lattice = chooseLattice(options, scene.exponent.has_value(), shape, files, placed.space);
  scene.voxelSize = lattice.voxelSize;
  scene.region = lattice.region;

  scene.arithmetic = chooseArithmetic(scene, *scene.map, placed.space);
  scene.facts["julia_arithmetic"] = scene.arithmetic == Arithmetic::Float ? "float" : "double";
  scene.evaluator = scene.map->evaluator(scene.arithmetic, scene.orbit);
  scene.space = placed.space;
  scene.space.centre += options.map->latticeShift() * options.surface.tolerance * scene.voxelSize;
  scene.facts.merge(spaceFacts(scene.space));
  return scene;
}

VersorSeeds::VersorSeeds(const Scene& scene) : mScene(scene) {
  if (scene.map->seed() && scene.target) return;
  const std::vector<NamedFile> files = scene.options.map->files();
  const bool fromFile = scene.map->roots() && !files.empty();
  throw std::invalid_argument("the map has no random versor over its target" +
                              (fromFile ? ": its roots are those of '" + files.front().path.string() + "'" : "") +
                              "; only random ones come in a row of seeds");
}

std::uint64_t VersorSeeds::first() const { return mScene.map->seed().value(); }

std::unique_ptr<julia::FieldEvaluator> VersorSeeds::evaluator(std::uint64_t seed) const {
  const std::shared_ptr<const MapInstance> map = mScene.map->reseeded(seed);
  return map->evaluator(chooseArithmetic(mScene, *map, mScene.space), mScene.orbit);
}

FieldPlan planScene(const Scene& scene) {
  FractalFieldOptions field{.voxelSize = scene.voxelSize, .box = scene.options.lattice.box};
  if (scene.exponent)
    return scene.options.lattice.exhaustive ? planExhaustive(*scene.exponent, field)
                                            : planShell(*scene.exponent, field);
  field.box = scene.region;
  return planBox(field);
}

std::map<std::string, std::string> sceneMetadata(const Scene& scene, const Recipe& recipe) {
  std::map<std::string, std::string> metadata = recipeToMetadata(recipe, "fractal");
  metadata.insert(scene.facts.begin(), scene.facts.end());
  return metadata;
}

}  // namespace vdbtools
