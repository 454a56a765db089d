// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/job/fractal_job.h"

#include "target/solid_input.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/file_hash.h"
#include "vdbtools/formats/peer_formats.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/formats/versor_file.h"
#include "vdbtools/target/fit_space.h"

#include "julia/quadratic_map.h"
#include "julia/rational_map.h"
#include "julia/shape_modulus.h"

#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <limits>

namespace vdbtools {
namespace {

using openvdb::BBoxd;
using openvdb::FloatGrid;
using openvdb::Vec3d;

constexpr const char* kVersorJson = "julia_versor_json";
// Around the target, of its longest side: where the set of a map without a shell is looked for.
constexpr double kRegionMargin = 0.25;
// How far a cross-product set is moved, as a share of the tolerance: by irrational numbers, so that no node of the
// lattice lies on its planes of symmetry. A and A' are not defined on one, which counts as outside (cross_map.h), and
// others hold sheets of the set: neither has volume, a ray meets either by chance only, but whole planes of nodes would
// show a cut or a disc.
const Vec3d kLatticeShift(0.6180339887498949, 0.4142135623730951, 0.2360679774997897);

/// The shortest text that reads back as the same doubles.
std::string numbersText(std::initializer_list<double> values) {
  std::string text;
  for (const double value : values) {
    char digits[32];
    if (!text.empty()) text += ',';
    text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
  }
  return text;
}

std::string boxText(const BBoxd& box) {
  const Vec3d &a = box.min(), &b = box.max();
  return numbersText({a[0], a[1], a[2], b[0], b[1], b[2]});
}

void requireHash(const std::string& expected, const std::string& found, const std::filesystem::path& path) {
  if (!expected.empty() && expected != found)
    throw DataError("'" + path.string() + "' is not the file that the recipe was made with: its SHA-256 is " + found +
                    " and was " + expected + "; give the options without --config to use it all the same");
}

Control readControl(const std::string& option, const std::string& text, const BBoxd& targetBox) {
  const auto parsed = parseControl(text);
  if (const double* number = std::get_if<double>(&parsed)) return Control(*number);
  if (const Ramp* ramp = std::get_if<Ramp>(&parsed)) return Control(*ramp, targetBox);
  // FILE.vdb or FILE.vdb:GRID
  std::string file = text, grid;
  if (!isVdbPath(file)) {
    const std::size_t colon = text.rfind(':');
    if (colon == std::string::npos || !isVdbPath(text.substr(0, colon)))
      throw std::invalid_argument("--" + option + " is '" + text +
                                  "'; it must be a number, a ramp such as x:10:300:smooth, or FILE.vdb[:GRID]");
    file = text.substr(0, colon);
    grid = text.substr(colon + 1);
  }
  return Control(chooseFloatGrid(readVdb(file), grid, file));
}

double spaceScale(const FractalOptions& options, const BBoxd& box) {
  return options.space == SpaceKind::World ? 1 : longestSide(box);
}

/// The target's box and the controls that may refer to it, then the target itself with the band that they need.
struct Input {
  Target target;
  ExponentGridOptions exponent;
  /// Makes the target's distances known over the whole inside, which takes long and is seldom needed.
  std::function<void(Target&)> deepen;
};

/// -E at the depth to which distances are made at first. Most targets are trapped before; making a mesh's distances
/// again costs more than going deep at once, while a VDB may have them.
constexpr double kMeshDepth = 5.5, kVdbDepth = 2.5;

/// How deep the distances must be known at first, world units.
double interiorWidth(const FractalOptions& options, const ExponentGridOptions& exponent, const BBoxd& box,
                     double depth) {
  double width = interiorReach(exponent, depth) * spaceScale(options, box);
  if (options.versor == "random" && options.randomRoots.placement == julia::RootPlacement::Surface)
    width = std::max(width, options.randomRoots.surfaceDistance * longestSide(box));
  return width;
}

ExponentGridOptions exponentOptions(const FractalOptions& options, const BBoxd& box) {
  return {.alpha = readControl("alpha", options.alpha, box),
          .beta = readControl("beta", options.beta, box),
          .maxIterations = options.iterations,
          .escapeRadius = options.escape,
          .interpolation = options.interpolation};
}

Input readMeshInput(const FractalOptions& options, std::map<std::string, std::string>& facts, Monitor& monitor) {
  const auto mesh = std::make_shared<const Mesh>(readMesh(options.input));
  const MeshReport report = reportOfSolid(*mesh, options.input);
  const double voxel = options.sdfVoxels.sizeFor(longestSide(report.box));
  ExponentGridOptions exponent = exponentOptions(options, report.box);
  const double reach = exteriorReach(exponent) * spaceScale(options, report.box);
  const auto makeAt = [=, &options, &facts, &monitor](double depth) {
    const MeshSdf sdf = makeSdfAbout(report.box.getCenter(), *mesh,
                                     sdfBand(voxel, reach / voxel + kExponentMargin, depth / voxel + kExponentMargin),
                                     options.repair, options.gap, monitor);
    if (sdf.moved) facts["julia_repair_moved"] = numbersText({*sdf.moved});
    return makeTarget(sdf.grid, report.box);
  };
  const double depth = interiorWidth(options, exponent, report.box, kMeshDepth);
  return {makeAt(depth), std::move(exponent),
          [makeAt](Target& target) { target = makeAt(std::numeric_limits<double>::infinity()); }};
}

Input readVdbInput(const FractalOptions& options, Monitor& monitor) {
  Input input{readVdbTarget(options.input, options.grid), {}, {}};
  input.exponent = exponentOptions(options, input.target.box);
  const double reach = exteriorReach(input.exponent) * spaceScale(options, input.target.box);
  extendBand(input.target, reach, interiorWidth(options, input.exponent, input.target.box, kVdbDepth), monitor);
  input.deepen = [reach, &monitor](Target& target) {
    extendBand(target, reach, std::numeric_limits<double>::infinity(), monitor);
  };
  return input;
}

/// The space of the target; without one, that of the shape that a rational map was fitted to, if it was.
FractalSpace makeSpace(const FractalOptions& options, const Target* target, const std::optional<FittedTo>& fitted) {
  FractalSpace space;
  if (target && options.space == SpaceKind::Fit) return fitFractalSpace(*target->phi, target->box, options.origin);
  if (!target && fitted && options.space == SpaceKind::Fit) space = fitted->space;
  space.centre += options.origin * space.scale;
  return space;
}

julia::Rational randomVersor(const FractalOptions& options, const Scene& scene, std::uint64_t seed) {
  julia::RandomRootsOptions random = options.randomRoots;
  random.seed = seed;
  // The roots lie in the target's space; moving the dynamics' origin does not strew them anew.
  FractalSpace unmoved = scene.space;
  unmoved.centre -= options.origin * (options.space == SpaceKind::Fit ? scene.space.scale : 1.0);
  if (scene.target) {
    random.boxMin = unmoved.toFractal(scene.target->box.min());
    random.boxMax = unmoved.toFractal(scene.target->box.max());
    if (options.space == SpaceKind::World) random.surfaceDistance *= longestSide(scene.target->box);
    const FloatGrid::ConstPtr phi = scene.target->phi;
    random.distance = [phi, unmoved](const julia::Point& x) {
      return openvdb::tools::BoxSampler::sample(phi->tree(), phi->worldToIndex(unmoved.toWorld(x))) / unmoved.scale;
    };
  }
  return {0, julia::randomPolynomial(random), {}};
}

bool hasVersor(MapKind map) { return map == MapKind::ShapeModulus || map == MapKind::Rational; }

/// The file that --versor or --rational names; none for random roots.
std::optional<RationalFile> readVersorFile(const FractalOptions& options, std::map<std::string, std::string>& facts) {
  if (!hasVersor(options.map) || options.versor == "random") return std::nullopt;
  RationalFile file;
  if (isVdbPath(options.versor)) {
    const auto metadata = readVdbMetadata(options.versor);
    const auto json = metadata.find(kVersorJson);
    if (json == metadata.end())
      throw DataError("'" + options.versor + "' holds no versor; only a VDB that 'juliavdb fractal' made does");
    file = rationalFileFromJson(json->second, options.versor);
  } else {
    file = readRationalFile(options.versor);
  }
  const std::string hash = sha256OfFile(options.versor);
  requireHash(options.versorHash, hash, options.versor);
  facts["julia_versor_sha256"] = hash;
  return file;
}

/// Scaled and moved as the options say.
julia::Rational placed(julia::Rational rational, const FractalOptions& options) {
  if (options.versorScale != 1) rational = scaled(std::move(rational), options.versorScale);
  const Vec3d& by = options.versorTranslate;
  const julia::Embedding unsliced{0, options.dropAxis};
  return translated(std::move(rational), unsliced.quaternion<double>({by[0], by[1], by[2]}));
}

julia::Rational makeVersor(const FractalOptions& options, const std::optional<RationalFile>& file, Scene& scene) {
  julia::Rational rational = file ? file->rational : randomVersor(options, scene, options.randomRoots.seed);
  scene.facts[kVersorJson] = rationalToJson(rational, {}, file ? file->target : std::nullopt);
  return placed(std::move(rational), options);
}

/// Of maps in log-polar form.
template <class Real>
std::shared_ptr<const julia::Map<Real>> makeMap(const Scene& scene) {
  switch (scene.options.map) {
    case MapKind::Rational: return std::make_shared<julia::RationalMap<Real>>(scene.rational);
    case MapKind::Quadratic: return std::make_shared<julia::QuadraticMap<Real>>(scene.options.c);
    default: break;
  }
  return std::make_shared<julia::ShapeModulus<Real>>(makeExponentField<Real>(*scene.exponent), scene.rational,
                                                     scene.options.dropAxis);
}

/// Of sums by nature; none for the other maps.
template <class Real>
std::shared_ptr<const julia::CartesianMap<Real>> makeCartesianMap(const FractalOptions& options) {
  switch (options.map) {
    case MapKind::Cross: return std::make_shared<julia::CrossMap<Real>>(options.cross);
    case MapKind::Mandelbulb: return std::make_shared<julia::Mandelbulb<Real>>(options.mandelbulb);
    case MapKind::Quadratic:
      if (options.mandelbrot) return std::make_shared<julia::QuadraticMandelbrot<Real>>();
      break;
    default: break;
  }
  return nullptr;
}

/// Whether 32 bits are as good as 64 for what the scene shows: the voxels are large against the rounding of positions,
/// and neither powers nor iterations pile up more of it (docs/precision.md has the measurements).
bool floatServes(const Scene& scene, const julia::Rational& rational) {
  constexpr double kLeastVoxel = 1e-3;  // of the largest coordinate: a thousandth of it is still resolved
  constexpr double kMostSummedPowers = 250;
  constexpr int kMostIterations = 5;
  if (makeCartesianMap<float>(scene.options)) return false;  // not measured
  if (scene.options.iterations > kMostIterations) return false;
  double powers = 0;
  for (const julia::Polynomial* polynomial : {&rational.top, &rational.bottom})
    for (const julia::Root& root : polynomial->roots) powers += std::abs(root.power * polynomial->powerScale);
  if (powers > kMostSummedPowers) return false;
  double largest = std::max(1.0, std::abs(scene.options.slice));
  const BBoxd& box = scene.exponent ? scene.target->box : scene.region;
  for (const Vec3d& corner : {box.min(), box.max()})
    for (const double x : scene.space.toFractal(corner)) largest = std::max(largest, std::abs(x));
  return scene.voxelSize / scene.space.scale >= kLeastVoxel * largest;
}

bool choosesFloats(const Scene& scene, const julia::Rational& rational) {
  const Precision precision = scene.options.precision;
  return precision == Precision::Float || (precision == Precision::Auto && floatServes(scene, rational));
}

template <class Real, template <class> class AnyMap>
std::unique_ptr<julia::FieldEvaluator> makeEvaluator(const Scene& scene, std::shared_ptr<const AnyMap<Real>> map) {
  const FractalOptions& options = scene.options;
  julia::OrbitOptions orbit{
      .maxIterations = options.iterations, .escapeRadius = options.escape, .confirmTrap = options.exhaustive};
  if (scene.exponent) orbit.logTrap = scene.exponent->shell.lower;
  return julia::makeFieldEvaluator<Real>(std::move(map), {options.slice, options.dropAxis}, orbit);
}

template <class Real>
std::unique_ptr<julia::FieldEvaluator> makeEvaluator(const Scene& scene) {
  if (auto map = makeCartesianMap<Real>(scene.options)) return makeEvaluator<Real>(scene, std::move(map));
  return makeEvaluator<Real>(scene, makeMap<Real>(scene));
}

/// The shape modulus of a scene with another versor.
template <class Real>
std::unique_ptr<julia::FieldEvaluator> makeEvaluator(const Scene& scene, const julia::Rational& versor,
                                                     std::shared_ptr<const julia::ScalarField<Real>>& exponent) {
  if (!exponent) exponent = makeExponentField<Real>(*scene.exponent);
  const std::shared_ptr<const julia::Map<Real>> map =
      std::make_shared<julia::ShapeModulus<Real>>(exponent, versor, scene.options.dropAxis);
  return makeEvaluator<Real>(scene, map);
}

/// A ball about the dynamics' origin in which the whole set lies, by its radius in fractal space; none where no such
/// ball is known. Nothing is in the set from the escape radius on; for some maps a smaller ball is proved to hold it.
std::optional<double> radiusOfSet(const FractalOptions& options) {
  using julia::CrossPair;
  switch (options.map) {
    case MapKind::ShapeModulus:
    case MapKind::Rational: return std::nullopt;
    case MapKind::Quadratic:
      if (!options.mandelbrot) return julia::quadraticBound(options.c, options.iterations, options.escape);
      return julia::triplexBound({.power = 2}, options.iterations, options.escape);
    case MapKind::Mandelbulb: return julia::triplexBound(options.mandelbulb, options.iterations, options.escape);
    case MapKind::Cross: break;
  }
  // |f x g| = |p|^2 for these pairs.
  const julia::CrossOptions& cross = options.cross;
  const bool squares = cross.pair == CrossPair::A || cross.pair == CrossPair::APrime || cross.pair == CrossPair::D;
  julia::MandelbulbOptions square{.power = 2};
  if (cross.scheme == julia::CrossScheme::Julia) square.constant = cross.constant;
  return squares && cross.scheme != julia::CrossScheme::FixedFactor
             ? julia::triplexBound(square, options.iterations, options.escape)
             : options.escape;
}

/// Where a map without a shell is evaluated, world units.
/// @param known  the box of the shape that it has, if it has one
BBoxd regionOf(const Scene& scene, const std::optional<BBoxd>& known) {
  const FractalOptions& options = scene.options;
  if (options.box) return *options.box;
  if (known) {
    BBoxd box = *known;
    box.expand(kRegionMargin * longestSide(box));
    return box;
  }
  if (const std::optional<double> found = radiusOfSet(options)) {
    const double radius = *found;
    return {scene.space.toWorld({-radius, -radius, -radius}), scene.space.toWorld({radius, radius, radius})};
  }
  if (lowerExtension(options.versor) == ".o3d") {
    const OptimisedShape shape = readOptimisedShape(options.versor);
    Vec3d low, high;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[static_cast<int>(axis)] = shape.centre[axis] - shape.lengths[axis] / 2;
      high[static_cast<int>(axis)] = shape.centre[axis] + shape.lengths[axis] / 2;
    }
    return {low, high};
  }
  throw std::invalid_argument(
      "a rational map that was not fitted to a shape has no region of its own; give --box, or a mesh");
}

}  // namespace

Scene makeScene(const FractalOptions& options, Monitor& monitor) {
  openvdb::initialize();
  Scene scene;
  scene.options = options;
  std::optional<Input> input;
  if (!options.input.empty()) {
    input = isVdbPath(options.input) ? readVdbInput(options, monitor) : readMeshInput(options, scene.facts, monitor);
    const std::string hash = sha256OfFile(options.input);
    requireHash(options.sourceHash, hash, options.input);
    scene.facts["julia_source_sha256"] = hash;
    scene.facts[kTargetBox] = boxText(input->target.box);
    if (options.space == SpaceKind::Fit && !centreIsInside(*input->target.phi, input->target.box))
      input->deepen(input->target);
  } else if (options.map == MapKind::ShapeModulus) {
    throw std::invalid_argument("the shape modulus needs a target: give a mesh, or a VDB with its signed distance");
  }
  const std::optional<RationalFile> versor = readVersorFile(options, scene.facts);
  const std::optional<FittedTo> fitted = versor && options.map == MapKind::Rational ? versor->target : std::nullopt;
  scene.space = makeSpace(options, input ? &input->target : nullptr, fitted);
  if (options.map == MapKind::ShapeModulus) {
    scene.exponent = exponentGrid(input->target, scene.space, input->exponent, monitor);
    if (scene.exponent->tooShallow) {
      input->deepen(input->target);
      scene.exponent = exponentGrid(input->target, scene.space, input->exponent, monitor);
    }
    const julia::ShellInterval& shell = scene.exponent->shell;
    scene.facts["julia_shell"] = numbersText({shell.lower, shell.upper});
  }
  if (input) scene.target = std::move(input->target);
  if (hasVersor(options.map)) scene.rational = makeVersor(options, versor, scene);
  std::optional<BBoxd> shape;
  if (scene.target) shape = scene.target->box;
  if (!scene.target && fitted && options.space == SpaceKind::Fit) shape = fitted->box;
  scene.region = scene.exponent ? BBoxd() : regionOf(scene, shape);
  scene.voxelSize = options.voxels.sizeFor(longestSide(shape ? *shape : scene.region));
  // Room for the outermost cells of a set that fills its region.
  constexpr double kRoom = 2;  // voxels
  if (!scene.exponent && !options.box) scene.region.expand(kRoom * scene.voxelSize);
  scene.inFloats = choosesFloats(scene, scene.rational);
  scene.facts["julia_arithmetic"] = scene.inFloats ? "float" : "double";
  scene.evaluator = scene.inFloats ? makeEvaluator<float>(scene) : makeEvaluator<double>(scene);
  if (options.map == MapKind::Cross) scene.space.centre += kLatticeShift * options.tolerance * scene.voxelSize;
  const Vec3d& centre = scene.space.centre;
  scene.facts["julia_space_centre"] = numbersText({centre[0], centre[1], centre[2]});
  scene.facts["julia_space_scale"] = numbersText({scene.space.scale});
  return scene;
}

VersorSeeds::VersorSeeds(const Scene& scene) : mScene(scene) {
  if (scene.options.map != MapKind::ShapeModulus)
    throw std::invalid_argument("only the shape modulus has random versors over a target, and the map is another one");
  if (scene.options.versor != "random")
    throw std::invalid_argument("the versor is '" + scene.options.versor +
                                "'; only random ones come in a row of seeds");
}

std::unique_ptr<julia::FieldEvaluator> VersorSeeds::evaluator(std::uint64_t seed) {
  const julia::Rational versor = placed(randomVersor(mScene.options, mScene, seed), mScene.options);
  return choosesFloats(mScene, versor) ? makeEvaluator<float>(mScene, versor, mFloats)
                                       : makeEvaluator<double>(mScene, versor, mDoubles);
}

FieldPlan planScene(const Scene& scene) {
  FractalFieldOptions field{.voxelSize = scene.voxelSize, .box = scene.options.box};
  if (scene.exponent)
    return scene.options.exhaustive ? planExhaustive(*scene.exponent, field) : planShell(*scene.exponent, field);
  field.box = scene.region;
  return planBox(field);
}

BBoxd meshBox(const FieldPlan& plan) {
  openvdb::CoordBBox nodes = plan.domain;
  nodes.expand(1);
  return {nodes.min().asVec3d() * plan.voxelSize, nodes.max().asVec3d() * plan.voxelSize};
}

FractalResult runFractal(const Scene& scene, const FieldPlan& plan, bool wantGrids, MeshSink* sink, Monitor& monitor) {
  const std::vector<std::string>& names = scene.options.grids;
  const auto wants = [&](const char* name) {
    return wantGrids && std::find(names.begin(), names.end(), name) != names.end();
  };
  const auto requireSurface = [&](std::uint64_t triangles) {
    if (triangles == 0)
      throw DataError(std::string("the fractal is empty here: F changes sign nowhere in the region; try ") +
                      (scene.exponent ? "a larger --beta or --box" : "other constants, or another --box"));
  };
  const bool capMesh = scene.options.cap || !plan.bounded;
  const ExtractMeshOptions asked{.tolerance = scene.options.tolerance, .border = capMesh ? Border::Cap : Border::Open};
  const bool dropsIslands = scene.options.islands.largest > 0 || scene.options.islands.minSize > 0;
  FractalResult result;
  if (!wantGrids && !dropsIslands && !scene.options.follow) {
    if (!sink) return result;
    result.mesh = streamMesh(plan, scene.source(), asked, *sink, monitor);
    result.evaluatedNodes = result.mesh.evaluatedNodes;
    requireSurface(result.mesh.triangles);
    return result;
  }

  const EvaluateFieldOptions evaluate{.keepIterations = wants("iterations"),
                                      .everyNode = wants("iterations") || wants("logmodulus")};
  FractalField field = scene.options.follow ? followSurface(plan, scene.source(), evaluate, *scene.options.follow,
                                                            result.follow.emplace(), monitor)
                                            : evaluateField(plan, scene.source(), evaluate, monitor);
  result.evaluatedNodes = field.evaluatedNodes;
  if (dropsIslands) result.islands = dropIslands(field, scene.options.islands, monitor);
  FloatGrid::Ptr surface;
  if (wants("surface") || wants("density") || wants("versor")) {
    CappedMesh capped = extractCappedMesh(field, scene.source(), scene.options.tolerance, monitor);
    requireSurface(capped.mesh.triangles.size());
    surface = levelSet(field, capped.mesh, monitor);
    result.check = checkSurface(*surface);
    if (sink) {
      Mesh mesh = capMesh ? std::move(capped.mesh) : withoutCaps(std::move(capped));
      requireSurface(mesh.triangles.size());
      computeNormals(mesh);
      sink->addPoints(mesh.points, mesh.normals);
      sink->addTriangles(mesh.triangles, 0);
      result.mesh = {mesh.points.size(), mesh.triangles.size()};
    }
  }
  if (sink && result.mesh.triangles == 0) result.mesh = extractMesh(field, scene.source(), asked, *sink, monitor);
  if (sink) requireSurface(result.mesh.triangles);
  for (const std::string& name : names) {
    if (!wantGrids) break;
    if (name == "surface") result.grids.push_back(surface);
    if (name == "density") result.grids.push_back(densityGrid(*surface));
    if (name == "logmodulus") result.grids.push_back(logModulusGrid(field));
    if (name == "iterations") result.grids.push_back(field.iterations);
    if (name == "versor") result.grids.push_back(versorGrid(*surface, scene.source(), monitor));
  }
  return result;
}

Mesh fractalMesh(const Scene& scene, Monitor& monitor) {
  Mesh mesh;
  MeshCollector collector(mesh);
  runFractal(scene, planScene(scene), false, &collector, monitor);
  return mesh;
}

SdfResult runSdf(const SdfOptions& options, Monitor& monitor) {
  openvdb::initialize();
  const Mesh mesh = readMesh(options.input);
  SdfResult result;
  result.report = reportOfSolid(mesh, options.input);
  const double voxel = options.voxels.sizeFor(longestSide(result.report.box));
  MeshSdf sdf = makeSdf(mesh, sdfBand(voxel, options.band, options.band), options.repair, options.gap, monitor);
  result.grid = sdf.grid;
  result.grid->setName("phi");
  result.moved = sdf.moved;
  result.closedGap = sdf.closedGap;
  result.facts["julia_source_sha256"] = sha256OfFile(options.input);
  result.facts[kTargetBox] = boxText(result.report.box);
  if (sdf.moved) result.facts["julia_repair_moved"] = numbersText({*sdf.moved});
  return result;
}

}  // namespace vdbtools
