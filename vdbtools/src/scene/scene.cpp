// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/scene/scene.h"

#include "control/control_lattice.h"
#include "distance/united_parts.h"
#include "repair/solid_input.h"
#include "scene/target_parts.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/base/number_text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/recipe/option_value.h"
#include "vdbtools/scene/voxel_advice.h"
#include "vdbtools/target/target_survey.h"

#include "julia/detail.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace vdbtools {
namespace {

using openvdb::BBoxd;
using openvdb::FloatGrid;
using openvdb::Vec3d;

/// The orbit as far as the options give it: the exponent adds its trap.
julia::OrbitOptions orbitOf(const FractalOptions& options) {
  julia::OrbitOptions orbit = options.map->orbit();
  orbit.confirmTrap = options.lattice.exhaustive;
  return orbit;
}

Metadata hashesOf(const FractalOptions& options) {
  Metadata metadata;
  for (const auto& [name, hash] : verifiedHashes(filesOf(options))) metadata[metadataName(name)] = hash;
  if (options.target && options.target->mesh) {
    const NamedFile& input = options.target->input;
    const std::string hash = sha256OfMesh(*options.target->mesh);
    if (!input.expectedHash.empty() && input.expectedHash != hash)
      throw DataError("the mesh is not the one that the recipe was made with: its SHA-256 is " + hash + " and was " +
                      input.expectedHash);
    metadata[metadataName(input.recordedAs)] = hash;
  }
  return metadata;
}

/// All of a scene that its exponent over a target is made from, and nothing else is used to make it: so two scenes with
/// equal sources share one exponent.
struct ExponentSources {
  SpaceOptions space;
  ShellSettings shell;
  Metadata controlFiles;  ///< the SHA-256 of the files that the shell's controls read
  julia::OrbitOptions orbit;
  double interiorReach = 0;  ///< as MapSettings has it
  bool isSmooth = false;     ///< E is read quadratically unless the distances are too coarse for that

  bool operator==(const ExponentSources&) const = default;
};

ExponentSources exponentSources(const FractalOptions& options, const ShellSettings& shell, const Metadata& hashes) {
  ExponentSources sources{.space = options.space,
                          .shell = shell,
                          .controlFiles = {},
                          .orbit = orbitOf(options),
                          .interiorReach = options.map->interiorReach()};
  sources.isSmooth = options.picture && picturesDiffer(options);
  if (!shell.interpolation)
    sources.shell.interpolation = sources.isSmooth ? julia::Interpolation::Quadratic : julia::Interpolation::Trilinear;
  for (const ControlSetting& control : shell.controls())
    for (const NamedFile& file : control->files())
      sources.controlFiles[metadataName(file.recordedAs)] = hashes.at(metadataName(file.recordedAs));
  return sources;
}

/// A target as far as its space and its exponent ask for it.
struct PlacedTarget {
  PlacedSpace placed{};
  Target target;
  std::optional<ExponentGridOptions> exponentOf{};
  std::optional<ExponentGrid> exponent{};
  bool isSurveyed = false;  ///< the target's survey was used for it
};

/// What one target gives to all scenes over it, each part made when it is first asked for. What it gives depends on
/// what is asked for alone, and not on what was asked for before.
class SharedTarget {
 public:
  SharedTarget(const TargetOptions& options, const TargetOpener& open) : mOptions(options), mInput(open(options)) {}

  const TargetOptions& options() const { return mOptions; }
  const TargetInput& input() const { return *mInput; }

  TargetSurvey& survey(Monitor& monitor) {
    if (!mSurvey) mSurvey.emplace(mInput->coarseDistances(monitor));
    return *mSurvey;
  }

  /// The fine distances in a band of these widths.
  const Target& band(const BandWidths& widths, Monitor& monitor) {
    if (mBand && mBand->widths == widths) return mBand->target;
    mBand.reset();
    if (!mDistances || !mDistances->widths.holds(widths)) mDistances = distances(widths, monitor);
    mBand = Known{widths, mInput->band(mDistances->target, widths, monitor)};
    return mBand->target;
  }

  /// The latest exponent, for scenes that differ in their maps only.
  struct Placed {
    ExponentSources sources;
    PlacedTarget target;
  };
  std::optional<Placed> placed{};
  std::string hash{};  ///< SHA-256 of the target

 private:
  struct Known {
    BandWidths widths;
    Target target;
  };

  /// Distances that hold a band of @a widths.
  Known distances(const BandWidths& widths, Monitor& monitor) {
    if (mDistances) {
      // Whoever asks again will ask for more once more: what is made again is made much wider.
      constexpr double kMore = 4;
      const BandWidths& known = mDistances->widths;
      BandWidths wide{known.exterior, known.interior, known.wholeInside || widths.wholeInside};
      if (widths.exterior > known.exterior) wide.exterior = std::max(widths.exterior, kMore * known.exterior);
      if (widths.interior > known.interior) wide.interior = std::max(widths.interior, kMore * known.interior);
      mDistances.reset();
      try {
        return {wide, mInput->distances(wide, monitor)};
      } catch (const MemoryError&) {            // what is asked for may fit nevertheless
      } catch (const std::invalid_argument&) {  // more nodes than a band may have
      }
    }
    return {widths, mInput->distances(widths, monitor)};
  }

  TargetOptions mOptions;
  std::unique_ptr<const TargetInput> mInput;
  std::optional<TargetSurvey> mSurvey;
  std::optional<Known> mDistances;  ///< the widest that were asked for
  std::optional<Known> mBand;       ///< the latest
};

/// Where the origin is, as --origin takes it.
std::string originText(const SpaceOptions& options, const FractalSpace& space, const BBoxd& box) {
  const Vec3d from = options.kind == SpaceKind::World ? space.centre : (space.centre - box.getCenter()) / space.scale;
  return numbersText({from[0], from[1], from[2]});
}

/// A control over the target. What its values may be is checked where they are used, as something that was asked for;
/// but those of a grid are its file's.
/// @throw DataError  values of a grid outside the range
Control bound(const ControlSource& source, const ControlContext& context, const std::string& name,
              const std::pair<double, double>& range) {
  Control control = source.bind(context);
  const std::vector<NamedFile> files = source.files();
  if (files.size() != 1 || !isVdbPath(files.front().path)) return control;
  const auto [least, most] = control.range();
  if (least < range.first || most > range.second)
    throw DataError(name + " is " + shortText(least < range.first ? least : most) + " somewhere in '" +
                    inOneLine(files.front().path.string()) + "'; it must be " +
                    (std::isfinite(range.second) ? "from 0 to 1" : "above 0") + " everywhere");
  return control;
}

/// Whether a control of the shell depends on the target's distances.
bool readsTarget(const ShellSettings& shell) {
  const std::vector<ControlSetting> controls = shell.controls();
  return std::any_of(controls.begin(), controls.end(), [](const auto& control) { return control->needsTarget(); });
}

/// What controls may refer to. @param needsTarget  whether one of them needs the target's distances
ControlContext controlContext(bool needsTarget, SharedTarget& shared, const PlacedSpace& placed, Monitor& monitor) {
  ControlContext context{.targetBox = shared.input().box(), .mesh = shared.input().mesh()};
  if (!needsTarget) return context;
  context.space = placed.unmoved;
  context.phi = shared.survey(monitor).phi();
  context.tau = [&] { return FloatGrid::ConstPtr(shared.survey(monitor).thickness(monitor).tau); };
  return context;
}

/// The slope of the thickness that goes with a shell.
double slopeOf(const std::optional<ExponentGridOptions>& shell) {
  return shell && shell->detail ? thicknessSlope(shell->detail->detail.range().second) : kThicknessSlope;
}

/// The controls of a shell over the target.
ExponentGridOptions bindControls(const ExponentSources& sources, SharedTarget& shared, const PlacedSpace& placed,
                                 Monitor& monitor) {
  const ShellSettings& shell = sources.shell;
  const ControlContext context = controlContext(readsTarget(shell), shared, placed, monitor);
  const std::pair positive(std::numeric_limits<double>::min(), std::numeric_limits<double>::infinity());
  constexpr double kRounding = 1e-5;  // of what is read between nodes
  const std::pair share(-kRounding, 1 + kRounding);
  ExponentGridOptions exponent{.orbit = sources.orbit,
                               .interpolation = shell.interpolation.value(),
                               .mask = bound(*shell.mask, context, "the mask", share)};
  if (!shell.detail) {
    exponent.alpha = bound(*shell.alpha, context, "alpha", positive);
    exponent.beta = shell.beta->bind(context);
    return exponent;
  }
  Control detail = bound(*shell.detail, context, "the detail", share);
  const double slope = thicknessSlope(detail.range().second);
  const LocalThickness thickness = shared.survey(monitor).thickness(monitor, slope);
  exponent.detail = DetailOptions{.detail = std::move(detail),
                                  .outward = bound(*shell.outward, context, "the outward reach", share),
                                  .thickness = thicknessControl(thickness),
                                  .greatestThickness = thickness.greatest,
                                  .origin = placed.unmoved.centre};
  return exponent;
}

/// How far from the surface distances are made at first.
/// @param mapReach  how deep the map must know distances for other reasons, as MapSettings::interiorReach() has it
BandWidths widthsOf(const SpaceOptions& space, double mapReach, const TargetInput& input,
                    const ExponentGridOptions& shell) {
  const double others = mapReach * longestSide(input.box());
  if (shell.detail) {
    const DetailReach reach = detailReach(shell);
    return {.exterior = reach.outside, .interior = std::max(reach.inside, others)};
  }
  const double scale = spaceScale(space, input.box());
  return {.exterior = exteriorReach(shell) * scale,
          .interior = std::max(interiorReach(shell, input.usualDepth()) * scale, others)};
}

/// How fine the texture is at each place of the target.
/// @param voxel  of the result, world units; none: it is chosen later
OctaveGrid octaveOf(const ControlSetting& frequency, SharedTarget& shared, const PlacedTarget& target,
                    const std::optional<double>& voxel, Monitor& monitor) {
  const ControlContext context = controlContext(frequency->needsTarget(), shared, target.placed, monitor);
  const std::pair positive(std::numeric_limits<double>::min(), std::numeric_limits<double>::infinity());
  const Control control = bound(*frequency, context, "the frequency", positive);
  const LocalThickness thickness = shared.survey(monitor).thickness(monitor, slopeOf(target.exponentOf));
  constexpr double kLeast = 2;  // voxels of a feature that shows
  constexpr double kFine = 4;   // a part may be thinner than the voxels, but more than this is somebody's wish
  const double coarsest = 2 * thickness.greatest / control.range().first;
  if (voxel && control.range().first > kFine && !(coarsest >= kLeast * *voxel))
    throw std::invalid_argument("--frequency is " + frequency->text() + ", whose features are " +
                                shortText(coarsest / *voxel) +
                                " voxels wide where the target is thickest, so that none of them shows; make the "
                                "frequency lower, or the voxels smaller than " +
                                shortText(coarsest / kLeast));
  return octaveGrid(thickness, control, target.placed.space);
}

/// What the map reads over the target, besides the exponent and the octave.
/// @param voxel  of the result, world units, if it is known already
ControlGrids controlsOf(const MapSettings& map, SharedTarget& shared, const PlacedTarget& target,
                        const std::optional<double>& voxel, Monitor& monitor) {
  ControlGrids grids;
  constexpr double kRounding = 1e-5;  // as of the shell's shares
  const std::pair share(-kRounding, 1 + kRounding);
  const std::pair any(-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity());
  for (const MapControl& control : map.controls()) {
    const std::string option = "--" + control.option;
    if (control.kind == MapControl::Kind::Frequency) {
      const OctaveGrid octave = octaveOf(control.control, shared, target, voxel, monitor);
      grids[control.name] = {octave.grid, octave.space};
      continue;
    }
    const ControlContext context = controlContext(control.control->needsTarget(), shared, target.placed, monitor);
    const bool isShare = control.kind == MapControl::Kind::Share;
    try {
      grids[control.name] = controlGrid(bound(*control.control, context, "the control", isShare ? share : any), context,
                                        target.placed.space);
    } catch (const DataError& error) {
      if (std::string(error.what()).find(option) != std::string::npos) throw;
      throw DataError(option + " '" + control.control->text() + "': " + error.what(), error.remedy());
    }
  }
  return grids;
}

PlacedTarget placeShell(const ExponentSources& sources, SharedTarget& shared, Monitor& monitor) {
  if (shared.placed && shared.placed->sources == sources) return shared.placed->target;
  const TargetInput& input = shared.input();
  const bool needsBall = needsInscribedBall(sources.space);
  PlacedTarget result;
  result.isSurveyed = needsBall || sources.shell.detail || readsTarget(sources.shell);
  const FloatGrid* phi = needsBall ? shared.survey(monitor).phi().get() : nullptr;
  result.placed = placeSpace(sources.space, input.box(), phi);
  result.exponentOf = bindControls(sources, shared, result.placed, monitor);
  BandWidths widths = widthsOf(sources.space, sources.interiorReach, input, *result.exponentOf);
  const auto make = [&] {
    result.target = shared.band(widths, monitor);
    const auto exponent = [&] { return exponentGrid(result.target, result.placed.space, *result.exponentOf, monitor); };
    try {
      try {
        result.exponent = exponent();
      } catch (const julia::NoDetail&) {
        // A B-spline reads farther about the origin, for which coarse distances may have no room.
        if (!sources.isSmooth) throw;
        result.exponentOf->interpolation = julia::Interpolation::Trilinear;
        result.exponent = exponent();
      }
    } catch (const julia::NoDetail&) {
      if (sources.space.origin != OriginKind::Auto) throw;  // another would do
      throw DataError(
          "the target leaves no room for detail: about its deepest point it is too thin for the voxels of its "
          "distances; make these finer, or the target thicker",
          Remedy::FinerDistances);
    }
  };
  make();
  if (result.exponent->tooShallow) {
    widths.wholeInside = true;
    make();
  }
  shared.placed = {sources, result};
  return result;
}

/// For a map without a shell, which gets the distances of the usual one.
PlacedTarget placeTarget(const FractalOptions& options, SharedTarget& shared, Monitor& monitor) {
  BandWidths widths = widthsOf(options.space, options.map->interiorReach(), shared.input(),
                               ExponentGridOptions{.orbit = orbitOf(options)});
  PlacedTarget result{.target = shared.band(widths, monitor)};
  if (needsDeepestPoint(options.space, result.target)) {
    widths.wholeInside = true;
    result.target = shared.band(widths, monitor);
  }
  result.placed = placeSpace(options.space, result.target);
  return result;
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

/// The evaluator with which the scene's features are measured. It does not depend on the lattice, and is most often the
/// one that the field has, too.
Arithmetic measuringArithmetic(const Scene& scene, const FractalSpace& space) {
  if (scene.options.precision != Precision::Auto)
    return scene.options.precision == Precision::Float ? Arithmetic::Float : Arithmetic::Double;
  // A difference over 1/4096 of the longest side is to be well above the rounding of coordinates.
  constexpr double kMostFar = 8;  // longest sides
  double largest = 0;
  for (const Vec3d& corner : {scene.target->box.min(), scene.target->box.max()})
    for (const double x : space.toFractal(corner)) largest = std::max(largest, std::abs(x));
  return largest <= kMostFar * longestSide(scene.target->box) / space.scale ? Arithmetic::Float : Arithmetic::Double;
}

void measureFeatures(Scene& scene, const FractalSpace& space, Monitor& monitor) {
  const auto evaluator = scene.map->evaluator(measuringArithmetic(scene, space), scene.orbit);
  scene.features =
      measureFeatureSizes(*scene.target, *scene.exponentOf, *evaluator, space, scene.options.lattice.box, monitor);
}

Metadata spaceMetadata(const FractalSpace& space) {
  const Vec3d& centre = space.centre;
  return {{"julia_space_centre", numbersText({centre[0], centre[1], centre[2]})},
          {"julia_space_scale", numbersText({space.scale})}};
}

Metadata shellMetadata(const ExponentGrid& exponent) {
  const auto text = [](const std::pair<double, double>& range) { return numbersText({range.first, range.second}); };
  return {{"julia_shell", numbersText({exponent.shell.lower, exponent.shell.upper})},
          {"julia_alpha_range", text(exponent.alphaRange)},
          {"julia_beta_range", text(exponent.betaRange)}};
}

Metadata targetMetadata(const Target& target) {
  Metadata metadata{{kTargetBox, boxText(target.box)}};
  if (target.repairMoved) metadata["julia_repair_moved"] = numbersText({*target.repairMoved});
  if (const auto united = (*target.phi)[kUnitedParts]) metadata[kUnitedParts] = united->str();
  return metadata;
}

}  // namespace

std::vector<NamedFile> filesOf(const FractalOptions& options) {
  std::vector<NamedFile> files = options.map->files();
  if (options.target && !options.target->mesh) files.push_back(options.target->input);
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

struct SceneMaker::Shared {
  /// What is shared of the target of these options; opened anew where the file has another content by now.
  /// @param hashes  becomes those of the options' files
  SharedTarget& over(const FractalOptions& options, Metadata& hashes) {
    if (target && target->options() != *options.target) target.reset();
    if (!target) target = std::make_unique<SharedTarget>(*options.target, open);
    hashes = hashesOf(options);
    const std::string& hash = hashes.at(metadataName(options.target->input.recordedAs));
    if (!target->hash.empty() && target->hash != hash) target = std::make_unique<SharedTarget>(*options.target, open);
    target->hash = hash;
    return *target;
  }

  TargetOpener open;
  std::unique_ptr<SharedTarget> target{};
};

SceneMaker::SceneMaker(TargetOpener open) : mShared(std::make_unique<Shared>()) { mShared->open = std::move(open); }
SceneMaker::~SceneMaker() = default;

Scene makeScene(const FractalOptions& options, Monitor& monitor) { return SceneMaker().make(options, monitor); }

Scene SceneMaker::make(const FractalOptions& options, Monitor& monitor) {
  openvdb::initialize();
  Scene scene;
  scene.options = options;
  scene.orbit = orbitOf(options);
  const MapFiles files = options.map->readFiles();
  const std::optional<FittedTo> fitted = files.roots ? files.roots->target : std::nullopt;
  const ShellSettings* const shell = options.map->shell();
  requireTarget(options);

  PlacedSpace placed;
  std::optional<BBoxd> shape;
  if (options.target) {
    SharedTarget& shared = mShared->over(options, scene.metadata);
    shape = shared.input().box();
    scene.targetMesh = transferredMesh(options, shared.input());
    PlacedTarget target = shell ? placeShell(exponentSources(options, *shell, scene.metadata), shared, monitor)
                                : placeTarget(options, shared, monitor);
    const ControlSetting* const frequency = options.map->frequency();
    std::optional<double> voxel;
    if (!options.lattice.automatic) voxel = options.lattice.voxels.sizeFor(longestSide(*shape));
    if (frequency) scene.octave = octaveOf(*frequency, shared, target, voxel, monitor);
    scene.controls = controlsOf(*options.map, shared, target, voxel, monitor);
    scene.target = std::move(target.target);
    scene.exponentOf = std::move(target.exponentOf);
    scene.exponent = std::move(target.exponent);
    placed = target.placed;
    if (scene.exponent) {
      scene.orbit = scene.exponent->orbit;
      scene.metadata.merge(shellMetadata(*scene.exponent));
      scene.metadata["julia_origin_at"] = originText(options.space, placed.unmoved, *shape);
    }
    const bool wantsThickness = options.output.attributes.has(PointAttribute::Tau);
    const bool followsThickness = frequency || scene.controls.contains("over-octave");
    if (wantsThickness || target.isSurveyed || followsThickness) {
      const LocalThickness thickness = shared.survey(monitor).thickness(monitor, slopeOf(scene.exponentOf));
      scene.metadata["julia_thickness"] = numbersText({thickness.least, thickness.greatest});
      if (wantsThickness) scene.thickness = thickness.tau;
    }
    scene.targetVolume = insideVolume(*scene.target->phi);
    scene.metadata.merge(targetMetadata(*scene.target));
    if (const std::shared_ptr<const Mesh> mesh = shared.input().mesh())
      scene.targetParts = partsOf(*mesh, options.target->mesh ? std::filesystem::path() : options.target->input.path);
  } else {
    scene.metadata.merge(hashesOf(options));
    placed = placeSpace(options.space, fitted ? &fitted->space : nullptr);
    if (fitted && options.space.kind == SpaceKind::Fit) shape = fitted->box;
  }

  scene.map = options.map->instance({.files = files,
                                     .target = scene.target ? &*scene.target : nullptr,
                                     .space = placed.space,
                                     .unmovedSpace = placed.unmoved,
                                     .exponent = scene.exponent ? &*scene.exponent : nullptr,
                                     .octave = scene.octave ? &*scene.octave : nullptr,
                                     .controls = &scene.controls});
  scene.metadata.merge(scene.map->metadata());

  if (scene.exponent) {
    measureFeatures(scene, placed.space, monitor);
    if (options.lattice.automatic) {
      scene.chosenResolution = chooseResolution(scene, options.lattice.withinMemory);
      scene.options.lattice.automatic = false;
      scene.options.lattice.voxels = {.resolution = scene.chosenResolution->resolution};
    }
  }

  const Lattice lattice = chooseLattice(scene.options, scene.exponent.has_value(), shape, files, placed.space);
  scene.voxelSize = lattice.voxelSize;
  scene.region = lattice.region;

  scene.arithmetic = chooseArithmetic(scene, *scene.map, placed.space);
  scene.metadata["julia_arithmetic"] = scene.arithmetic == Arithmetic::Float ? "float" : "double";
  scene.evaluator = scene.map->evaluator(scene.arithmetic, scene.orbit);
  scene.placed = placed;
  scene.space = placed.space;
  scene.space.centre += options.map->latticeShift() * options.surface.tolerance * scene.voxelSize;
  scene.metadata.merge(spaceMetadata(scene.space));
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
  return map->evaluator(chooseArithmetic(mScene, *map, mScene.placed.space), mScene.orbit);
}

FieldPlan planScene(const Scene& scene, const std::optional<openvdb::CoordBBox>& window) {
  FractalFieldOptions field{.voxelSize = scene.voxelSize, .box = scene.options.lattice.box, .window = window};
  if (!scene.exponent) field.box = scene.region;
  FieldPlan plan = !scene.exponent                    ? planBox(field)
                   : scene.options.lattice.exhaustive ? planExhaustive(*scene.exponent, field)
                                                      : planShell(*scene.exponent, field);
  if (!dropsCrumbs(scene.options)) return plan;
  plan.crumbs.emplace();
  if (scene.exponent) {
    plan.crumbs->exponent = scene.exponent->grid;
    plan.crumbs->decided = scene.exponent->shell.lower;
    // Where the whole target is only some voxels long, so are pieces of it that somebody would keep.
    constexpr double kShare = 1.0 / 40;  // of the target's longest side
    if (scene.options.surface.crumbs == Crumbs::Auto)
      plan.crumbs->longest =
          static_cast<int>(std::min<double>(kCrumb, kShare * scene.exponent->space.scale / scene.voxelSize));
  }
  return plan;
}

BBoxd meshBox(const FieldPlan& plan) {
  openvdb::CoordBBox nodes = plan.domain;
  nodes.expand(1);
  return {nodes.min().asVec3d() * plan.voxelSize, nodes.max().asVec3d() * plan.voxelSize};
}

Recipe resolvedRecipe(const Scene& scene, Recipe recipe) {
  if (scene.chosenResolution) recipe["resolution"] = numbersText({scene.chosenResolution->resolution});
  return recipe;
}

std::map<std::string, std::string> sceneMetadata(const Scene& scene, const Recipe& recipe) {
  std::map<std::string, std::string> metadata = recipeToMetadata(resolvedRecipe(scene, recipe), "fractal");
  metadata.insert(scene.metadata.begin(), scene.metadata.end());
  return metadata;
}

}  // namespace vdbtools
