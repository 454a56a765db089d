// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/scene/scene.h"

#include "control/control_lattice.h"
#include "distance/united_parts.h"
#include "repair/solid_input.h"
#include "scene/file_hashes.h"
#include "scene/placed_target.h"
#include "scene/posed_scene.h"
#include "scene/scene_colouring.h"
#include "scene/target_parts.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/recipe/option_value.h"
#include "vdbtools/scene/voxel_advice.h"

#include "julia/detail.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace vdbtools {
namespace {

using openvdb::BBoxd;
using openvdb::FloatGrid;
using openvdb::Vec3d;

/// The position of the origin as a value of --origin.
std::string originText(const SpaceOptions& options, const FractalSpace& space, const BBoxd& box) {
  const Vec3d from = options.kind == SpaceKind::World ? space.centre : (space.centre - box.getCenter()) / space.scale;
  return numbersText({from[0], from[1], from[2]});
}

/// The region in which a map without a shell is evaluated, world units.
/// @param shape  the box of the set's shape, if it is known
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

/// The largest coordinate in a box, fractal space.
double largestCoordinate(const BBoxd& box, const FractalSpace& space) {
  double largest = 0;
  for (const Vec3d& corner : {box.min(), box.max()})
    for (const double x : space.toFractal(corner)) largest = std::max(largest, std::abs(x));
  return largest;
}

/// Whether the voxels are large compared with the rounding of 32-bit positions.
bool voxelsAreLarge(double voxelSize, const BBoxd& box, const FractalSpace& space, const julia::Embedding& embedding) {
  constexpr double kLeastVoxel = 1e-3;  // of the largest coordinate: a thousandth of it is still resolved
  const double largest = std::max({1.0, std::abs(embedding.slice), largestCoordinate(box, space)});
  return voxelSize / space.scale >= kLeastVoxel * largest;
}

/// @param box  the evaluated box, or the target's box, world units
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

Arithmetic chooseArithmetic(const Scene& scene, const MapInstance& map) {
  const BBoxd& box = scene.exponent() ? scene.target->distances.box : scene.region();
  return chooseArithmetic(scene.options, map, scene.voxelSize, box, scene.placed.space);
}

/// The arithmetic of the evaluator with which the features of a scene are measured. It does not depend on the lattice,
/// and is usually the field's arithmetic, too.
Arithmetic measuringArithmetic(const Scene& scene) {
  if (scene.options.precision != Precision::Auto)
    return scene.options.precision == Precision::Float ? Arithmetic::Float : Arithmetic::Double;
  // A difference over 1/4096 of the longest side must be well above the rounding of coordinates.
  constexpr double kMostFar = 8;  // longest sides
  const FractalSpace& space = scene.placed.space;
  const BBoxd& box = scene.target->distances.box;
  double largest = 0;
  for (const Vec3d& corner : {box.min(), box.max()})
    for (const double x : space.toFractal(corner)) largest = std::max(largest, std::abs(x));
  return largest <= kMostFar * longestSide(box) / space.scale ? Arithmetic::Float : Arithmetic::Double;
}

FeatureSizes measureFeatures(const Scene& scene, Monitor& monitor) {
  const FractalSpace& space = scene.placed.space;
  const auto evaluator = scene.field.map->evaluator(measuringArithmetic(scene), scene.field.orbit);
  return measureFeatureSizes(scene.target->distances, scene.shellOptions(), *evaluator, space,
                             scene.options.lattice.box, monitor);
}

Metadata spaceMetadata(const FractalSpace& space) {
  const Vec3d& centre = space.centre;
  return {{"julia_space_centre", numbersText({centre[0], centre[1], centre[2]})},
          {"julia_space_scale", numbersText({space.scale})}};
}

Metadata shellMetadata(const ExponentGrid& exponent) {
  const auto text = [](const std::pair<double, double>& range) { return numbersText({range.first, range.second}); };
  Metadata metadata{{"julia_shell", numbersText({exponent.shell.lower, exponent.shell.upper})},
                    {"julia_alpha_range", text(exponent.alphaRange)},
                    {"julia_beta_range", text(exponent.betaRange)}};
  // K and P of docs/design.md 2.8.
  if (exponent.scale)
    metadata["julia_detail_law"] =
        numbersText({*exponent.scale, exponent.knee.more * julia::DetailLaw::kPlunge * *exponent.scale});
  return metadata;
}

Metadata targetMetadata(const Target& target) {
  Metadata metadata{{kTargetBox, boxText(target.box)}};
  metadata.insert(target.facts.begin(), target.facts.end());
  if (target.repairMoved) metadata["julia_repair_moved"] = numbersText({*target.repairMoved});
  for (const char* fact : kPartFacts)
    if (const auto found = (*target.phi)[fact]) metadata[fact] = found->str();
  return metadata;
}

}  // namespace

std::vector<NamedFile> filesOf(const FractalOptions& options) {
  std::vector<NamedFile> files = options.map->files();
  if (options.target && !options.target->mesh) files.push_back(options.target->input);
  if (options.rest && options.rest->file && !options.rest->mesh) files.push_back(*options.rest->file);
  if (options.velocity)
    for (const std::optional<NamedFile>& file : {options.velocity->before, options.velocity->after})
      if (file) files.push_back(*file);
  const std::optional<ColourChoice>& colour = options.output.attributes.colour;
  if (colour && colour->picture) files.push_back(*colour->picture);
  return files;
}

InputFiles inputsOf(const FractalOptions& options) { return InputFiles(filesOf(options)); }

std::shared_ptr<const Mesh> transferredMesh(const FractalOptions& options, const TargetInput& input) {
  const std::vector<std::string>& names = options.output.attributes.transferred;
  if (names.empty()) return nullptr;
  std::shared_ptr<const Mesh> mesh = input.mesh();
  if (!mesh)
    throw DataError(
        "--transfer cannot be used: the target is a VDB, which has neither texture coordinates nor vertex attributes; "
        "give the mesh itself as the target");
  const auto require = [&](const char* name) { requireAttribute(*mesh, name, "the target's mesh"); };
  for (const std::string& name : names) {
    if (name == "uv")
      requireUvs(*mesh);
    else if (name == "Cd")
      for (const char* channel : {"red", "green", "blue"}) require(channel);
    else
      require(name.c_str());
  }
  return mesh;
}

std::shared_ptr<const SurfaceVelocity> velocityOf(const FractalOptions& options,
                                                  const std::shared_ptr<const Mesh>& now) {
  if (!options.velocity) return nullptr;
  const MotionDepth depth = options.rest ? options.rest->depth : MotionDepth::Stretched;
  return surfaceVelocity(*options.velocity, options.target.value(), now, depth);
}

struct SceneMaker::Shared {
  /// The shared parts of the target of these options. The target is opened again if its file has changed.
  /// @param hashes  receives the hashes of the options' files
  SharedTarget& over(const FractalOptions& options, Metadata& hashes, Monitor& monitor) {
    if (target && target->options() != *options.target) target.reset();
    if (!target) target = std::make_unique<SharedTarget>(*options.target, open, monitor);
    hashes = hashesOf(options);
    const std::string& hash = hashes.at(metadataName(options.target->input.recordedAs));
    if (!target->hash.empty() && target->hash != hash)
      target = std::make_unique<SharedTarget>(*options.target, open, monitor);
    target->hash = hash;
    return *target;
  }

  /// Points in memory that are the same as those of the last scene are the same mesh.
  void share(std::shared_ptr<const Mesh>& mesh) const {
    if (mesh && target && target->options().mesh && sha256OfMesh(*mesh) == target->hash) mesh = target->options().mesh;
  }

  TargetOpener open;
  std::unique_ptr<SharedTarget> target{};
};

SceneMaker::SceneMaker(TargetOpener open) : mShared(std::make_unique<Shared>()) { mShared->open = std::move(open); }
SceneMaker::~SceneMaker() = default;

Scene makeScene(const FractalOptions& options, Monitor& monitor) { return SceneMaker().make(options, monitor); }

std::unique_ptr<julia::FieldEvaluator> Scene::evaluator(const julia::OrbitOptions& orbit) const {
  return carriedAlong(field.map->evaluator(field.arithmetic, orbit), field.deformation);
}

std::vector<Vec3d> Scene::atRest(std::span<const Vec3d> points) const {
  std::vector<Vec3d> result(points.begin(), points.end());
  if (!field.deformation) return result;
  std::vector<julia::Point> from, carried(points.size());
  for (const Vec3d& point : points) from.push_back(placed.space.toFractal(point));
  std::vector<julia::Decision> decisions(points.size());
  field.deformation->carry(from, carried, decisions);
  for (std::size_t i = 0; i < result.size(); ++i)
    if (decisions[i] == julia::Decision::Undecided) result[i] = placed.space.toWorld(carried[i]);
  return result;
}

const ExponentGrid* Scene::exponent() const {
  const SceneShell* const shell = std::get_if<SceneShell>(&domain);
  return shell ? &shell->exponent : nullptr;
}

const FeatureSizes* Scene::features() const {
  const SceneShell* const shell = std::get_if<SceneShell>(&domain);
  return shell && shell->made ? &shell->made->features : nullptr;
}

const ExponentGridOptions& Scene::shellOptions() const {
  const SceneShell* const shell = std::get_if<SceneShell>(&domain);
  if (!shell || !shell->made) throw std::logic_error("the scene does not know what its exponent was made with");
  return shell->made->options;
}

FieldSource Scene::source(const FieldPlan& plan) const {
  FieldSource moved = source();
  moved.space.centre -= plan.origin;
  return moved;
}

std::shared_ptr<const MapInstance> mapInstance(const Scene& scene, const MapFiles& files) {
  const std::optional<SceneTarget>& target = scene.target;
  return scene.options.map->instance({.files = files,
                                      .target = target ? &target->distances : nullptr,
                                      .space = scene.placed.space,
                                      .unmovedSpace = scene.placed.unmoved,
                                      .exponent = scene.exponent(),
                                      .octave = target && target->octave ? &*target->octave : nullptr,
                                      .controls = target ? &target->controls : nullptr});
}

namespace {

/// The unit of the target's coordinates, if it is known.
std::optional<LengthUnit> unitOfTarget(const FractalOptions& options) {
  const TargetOptions& target = options.target.value();
  const std::optional<LengthUnit> asked = options.output.axes.unit;
  return target.mesh ? asked : agreedUnit(asked, unitOfFile(target.input.path), target.input.path);
}

/// Sets everything in a scene that depends on its target.
/// @return the target's box
BBoxd setTarget(Scene& scene, SharedTarget& shared, Monitor& monitor) {
  const FractalOptions& options = scene.options;
  const BBoxd shape = shared.input().box();
  scene.chosenSdfResolution = shared.input().chosenSdfResolution(monitor);
  if (scene.chosenSdfResolution) scene.options.target->sdfVoxels = VoxelChoice{.resolution = scene.chosenSdfResolution};
  SceneTarget& target = scene.target.emplace();
  target.mesh = transferredMesh(options, shared.input());
  scene.velocity = velocityOf(options, shared.input().mesh());
  const ShellSettings* const shell = options.map->shell();
  const PlacedTarget placed = shell ? placeShell(exponentSources(options, *shell, scene.metadata), shared, monitor)
                                    : placeTarget(options, shared, monitor);
  std::optional<double> voxel;
  if (!options.lattice.automatic) voxel = options.lattice.voxels.sizeFor(longestSide(shape));
  if (const ControlSetting* const frequency = options.map->frequency())
    target.octave = octaveOf(*frequency, shared, placed, voxel, monitor);
  target.controls = controlsOf(*options.map, shared, placed, voxel, monitor);
  target.distances = placed.target;
  scene.placed = placed.placed;
  if (placed.shell) {
    scene.domain = *placed.shell;
    scene.field.orbit = placed.shell->exponent.orbit;
    scene.metadata.merge(shellMetadata(placed.shell->exponent));
    scene.metadata["julia_origin_at"] = originText(options.space, placed.placed.unmoved, shape);
  }
  const bool wantsThickness = options.output.attributes.has(PointAttribute::Tau);
  const bool followsThickness = target.octave || target.controls.contains("over-octave");
  if (wantsThickness || placed.isSurveyed || followsThickness) {
    const LocalThickness thickness = shared.survey(monitor).thickness(monitor, slopeOf(placed.shell));
    scene.metadata["julia_thickness"] = numbersText({thickness.least, thickness.greatest});
    if (wantsThickness) target.thickness = thickness.tau;
  }
  target.volume = insideVolume(*target.distances.phi);
  scene.metadata.merge(targetMetadata(target.distances));
  if (const std::shared_ptr<const Mesh> mesh = shared.input().mesh()) {
    target.parts = partsOf(*mesh);
    if (mesh->pointsLeftOut > 0) scene.metadata[kPointsLeftOut] = std::to_string(mesh->pointsLeftOut);
  }
  return shape;
}

/// Sets the voxel size and, for a map without a shell, the region.
/// @param shape  the box of the set's shape, if it is known
void setLattice(Scene& scene, const std::optional<BBoxd>& shape, const MapFiles& files) {
  const LatticeOptions& lattice = scene.options.lattice;
  if (scene.exponent()) {
    scene.voxelSize = lattice.voxels.sizeFor(longestSide(shape.value()));
    return;
  }
  BBoxd region = regionOf(scene.options, shape, files, scene.placed.space);
  scene.voxelSize = lattice.voxels.sizeFor(longestSide(shape ? *shape : region));
  // Leaves room for the outermost cells of a set that fills its region.
  constexpr double kRoom = 2;  // voxels
  if (!lattice.box) region.expand(kRoom * scene.voxelSize);
  scene.domain = region;
}

}  // namespace

Scene SceneMaker::make(const FractalOptions& options, Monitor& monitor) {
  if (!options.rest) return makeStill(options, monitor);
  FractalOptions atRest = optionsAtRest(options);
  mShared->share(atRest.target->mesh);
  Metadata hashes;
  const TargetInput& rest = mShared->over(atRest, hashes, monitor).input();
  // Faces that differ are found before the work begins.
  const TargetPose pose = openPose(options, rest, mShared->open, monitor);
  Scene scene = makeStill(atRest, monitor);
  scene.rest = SceneAtRest{*scene.exponent(), scene.target->distances, rest.mesh(), rest.box()};
  poseScene(scene, options, pose, monitor);
  return scene;
}

Scene SceneMaker::makeStill(const FractalOptions& options, Monitor& monitor) {
  openvdb::initialize();
  Scene scene;
  scene.options = options;
  scene.field.orbit = orbitOf(options);
  const MapFiles files = options.map->readFiles();
  requireTarget(options);

  std::optional<BBoxd> shape;
  if (options.target) {
    SharedTarget& shared = mShared->over(options, scene.metadata, monitor);
    if (const std::optional<LengthUnit> unit = unitOfTarget(options)) scene.metadata[kLengthUnit] = nameOf(*unit);
    shape = setTarget(scene, shared, monitor);
  } else {
    const std::optional<FittedTo> fitted = files.roots ? files.roots->target : std::nullopt;
    scene.metadata.merge(hashesOf(options));
    scene.placed = placeSpace(options.space, fitted ? &fitted->space : nullptr);
    if (fitted && options.space.kind == SpaceKind::Fit) shape = fitted->box;
  }

  scene.field.map = mapInstance(scene, files);
  scene.metadata.merge(scene.field.map->metadata());

  if (scene.exponent()) {
    std::get<SceneShell>(scene.domain).made.value().features = measureFeatures(scene, monitor);
    if (options.lattice.automatic) {
      scene.chosenResolution = chooseResolution(scene, options.lattice.withinMemory);
      scene.options.lattice.automatic = false;
      scene.options.lattice.voxels = {.resolution = scene.chosenResolution->resolution};
    }
  }
  setLattice(scene, shape, files);

  SceneField& field = scene.field;
  field.arithmetic = chooseArithmetic(scene, *field.map);
  scene.metadata["julia_arithmetic"] = field.arithmetic == Arithmetic::Float ? "float" : "double";
  field.evaluator = field.map->evaluator(field.arithmetic, field.orbit);
  field.space = scene.placed.space;
  field.space.centre -= latticeOffset(options, scene.voxelSize);
  scene.metadata.merge(spaceMetadata(scene.placed.space));
  return scene;
}

LocalThickness SceneMaker::thickness(const FractalOptions& options, double slope, Monitor& monitor) {
  openvdb::initialize();
  requireTarget(options);
  Metadata hashes;
  return mShared->over(options, hashes, monitor).survey(monitor).thickness(monitor, slope);
}

VersorSeeds::VersorSeeds(const Scene& scene) : mScene(scene) {
  if (scene.field.map->seed() && scene.target) return;
  const std::vector<NamedFile> files = scene.options.map->files();
  const bool fromFile = scene.field.map->roots() && !files.empty();
  throw std::invalid_argument("the map has no random versor over its target" +
                              (fromFile ? ": its roots are those of '" + files.front().path.string() + "'" : "") +
                              "; only random ones come in a row of seeds");
}

std::uint64_t VersorSeeds::first() const { return mScene.field.map->seed().value(); }

std::unique_ptr<julia::FieldEvaluator> VersorSeeds::evaluator(std::uint64_t seed) const {
  const std::shared_ptr<const MapInstance> map = mScene.field.map->reseeded(seed);
  return carriedAlong(map->evaluator(chooseArithmetic(mScene, *map), mScene.field.orbit), mScene.field.deformation);
}

FieldPlan planScene(const Scene& scene, const std::optional<openvdb::CoordBBox>& window) {
  FractalFieldOptions field{.voxelSize = scene.voxelSize, .box = scene.options.lattice.box, .window = window};
  const ExponentGrid* const exponent = scene.exponent();
  if (!exponent) field.box = scene.region();
  field.origin = latticeOrigin(field);
  FieldPlan plan = !exponent                          ? planBox(field)
                   : scene.options.lattice.exhaustive ? planExhaustive(*exponent, field)
                                                      : planShell(*exponent, field);
  if (!dropsCrumbs(scene.options)) return plan;
  plan.crumbs.emplace();
  if (exponent) {
    plan.crumbs->exponent = exponent->grid;
    plan.crumbs->decided = exponent->shellOfNodes.lower;
    // If the whole target is only a few voxels long, pieces that users want to keep may be as small.
    constexpr double kShare = 1.0 / 40;  // of the target's longest side
    if (scene.options.surface.crumbs == Crumbs::Auto)
      plan.crumbs->longest =
          static_cast<int>(std::min<double>(kCrumb, kShare * exponent->space.scale / scene.voxelSize));
  }
  return plan;
}

double floatRounding(const Scene& scene) {
  const FractalSpace& space = scene.placed.space;
  const BBoxd box = scene.options.lattice.box.value_or(scene.exponent() ? scene.target->distances.box : scene.region());
  return 0x1p-24 * largestCoordinate(box, space) * space.scale / scene.voxelSize;
}

Vec3d latticeOffset(const FractalOptions& options, double voxelSize) {
  return options.map->latticeShift() * -options.surface.tolerance * voxelSize;
}

BBoxd meshBox(const FieldPlan& plan) {
  openvdb::CoordBBox nodes = plan.domain;
  nodes.expand(1);
  return {nodes.min().asVec3d() * plan.voxelSize + plan.origin, nodes.max().asVec3d() * plan.voxelSize + plan.origin};
}

Recipe resolvedRecipe(const Scene& scene, Recipe recipe) {
  if (scene.chosenResolution) recipe["resolution"] = numbersText({scene.chosenResolution->resolution});
  if (scene.chosenSdfResolution) recipe["sdf-resolution"] = numbersText({*scene.chosenSdfResolution});
  return recipe;
}

std::map<std::string, std::string> sceneMetadata(const Scene& scene, const Recipe& recipe) {
  std::map<std::string, std::string> metadata = recipeToMetadata(resolvedRecipe(scene, recipe), "fractal");
  metadata.insert(scene.metadata.begin(), scene.metadata.end());
  return metadata;
}

openvdb::BBoxd sliceFrame(const Scene& scene) {
  constexpr double kAir = 0.08;  // of the target's longest side
  if (scene.options.lattice.box) return *scene.options.lattice.box;
  if (!scene.target) return scene.region();
  openvdb::BBoxd box = scene.target->distances.box;
  box.expand(kAir * longestSide(box));
  return box;
}

openvdb::BBoxd pictureRegion(const Scene& scene) {
  if (scene.options.lattice.box) return *scene.options.lattice.box;
  return scene.exponent() ? meshBox(planScene(scene)) : scene.region();
}

FieldRenderOptions pictureOptions(const Scene& scene, const openvdb::BBoxd& region, const FieldPicture& picture,
                                  FieldColour usual) {
  FieldRenderOptions options = picture.render;
  options.camera = picture.view.camera(scene.source(), region,
                                       static_cast<double>(options.width) / static_cast<double>(options.height),
                                       scene.options.output.axes.target);
  const std::optional<ColourChoice>& chosen = scene.options.output.attributes.colour;
  options.colour = sceneColouring(scene, picture.colour.value_or(chosen.value_or(ColourChoice{.by = usual})));
  options.orbit = scene.field.orbit;
  options.dropAxis = scene.options.map->embedding().dropped;
  return options;
}

}  // namespace vdbtools
