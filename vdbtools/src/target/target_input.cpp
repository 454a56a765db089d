// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/target/target_input.h"

#include "base/elementary.h"
#include "base/lattice_transform.h"
#include "distance/band_growth.h"
#include "distance/hole_caps.h"
#include "distance/mesh_conversion.h"
#include "distance/united_parts.h"
#include "recipe/option_rows.h"
#include "repair/solid_input.h"
#include "vdbtools/base/voxel_choice.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/recipe/option_value.h"

#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::BBoxd;

using openvdb::FloatGrid;
using openvdb::Vec3d;

constexpr double kWholeInside = std::numeric_limits<double>::infinity();
constexpr const char* kAutomatic = "auto";  ///< a value of --sdf-resolution
constexpr double kSurveyMargin = 4;         ///< voxels known outside, in the survey

/// Distances on the lattice of a survey. @param deep  known in the whole inside, and as far outside as the survey
/// reaches
FloatGrid::ConstPtr resampled(const Target& deep, double voxel) {
  const FloatGrid::Ptr coarse = FloatGrid::create(static_cast<float>(kSurveyMargin * voxel));
  coarse->setTransform(latticeTransform(voxel));
  const BBoxd at = coarse->transform().worldToIndex(deep.box);
  openvdb::CoordBBox nodes(openvdb::Coord::floor(at.min()), openvdb::Coord::ceil(at.max()));
  nodes.expand(static_cast<int>(kSurveyMargin));
  coarse->denseFill(nodes, 0.0f, true);
  coarse->tree().voxelizeActiveTiles();
  const auto accessor = deep.phi->getConstAccessor();
  for (auto value = coarse->beginValueOn(); value; ++value) {
    Vec3d point = deep.phi->worldToIndex(coarse->indexToWorld(value.getCoord()));
    // Beyond the faces of a dense field the nearest face's value applies.
    if (deep.denseBox)
      for (int axis = 0; axis < 3; ++axis)
        point[axis] = std::clamp<double>(point[axis], deep.denseBox->min()[axis], deep.denseBox->max()[axis]);
    value.setValue(openvdb::tools::BoxSampler::sample(accessor, point));
  }
  return coarse;
}

class MeshInput final : public TargetInput {
 public:
  explicit MeshInput(const TargetOptions& options)
      : mSource(openSolid(options.input.path, options.mesh, options.mend, options.moment)), mMend(options.mend) {
    const VoxelChoice usual{.resolution = kUsualSdfResolution};
    const double voxel = options.sdfVoxels.value_or(usual).sizeFor(longestSide(mSource.box));
    requireResolved(mMend, voxel);
    // A target for which even the narrowest band is too large is refused before the survey, which takes a while.
    constexpr double kNarrowest = 1.5;
    if (mMend.offset() == 0) checkOptions(mSource.report, sdfBand(voxel, kNarrowest, kNarrowest));
    // For a mesh that gets walls, or a cloud that gets balls, their thickness was chosen with the voxels in mind.
    if (options.sdfVoxels)
      mVoxels = Voxels{voxel, std::nullopt};
    else if (mMend.offset() > 0)
      mVoxels = Voxels{voxel, kUsualSdfResolution};
  }

  const BBoxd& box() const override { return mSource.box; }
  double usualDepth() const override { return 5.5; }

  Target distances(const BandWidths& widths, Monitor& monitor) const override {
    const MeshSdf sdf = sdfOf(sdfBandOf(widths, monitor), monitor);
    Target target = makeTarget(sdf.grid, mSource.box);
    target.repairMoved = sdf.moved;
    for (const auto& [name, count] : partFacts(sdf.parts, mMend.hollows))
      target.phi->insertMeta(name, openvdb::StringMetadata(count));
    return target;
  }

  Target band(const Target& distances, const BandWidths& widths, Monitor& monitor) const override {
    const FloatGrid::Ptr phi = narrowed(distances.phi, sdfBandOf(widths, monitor));
    if (phi == distances.phi) return distances;
    Target target = makeTarget(phi, distances.box);
    target.repairMoved = distances.repairMoved;
    for (const char* fact : kPartFacts)
      if (const auto found = (*distances.phi)[fact]) target.phi->insertMeta(fact, *found);
    return target;
  }

  Target bandOf(double voxel, const BandWidths& widths, Monitor& monitor) const override {
    if (mMend.offset() > 0) voxel = std::min(voxel, voxels(monitor).size);
    return makeTarget(sdfOf(bandAt(voxel, widths), monitor).grid, mSource.box);
  }

  CoarseDistances coarseDistances(Monitor& monitor) const override {
    const Voxels known = voxels(monitor);
    if (known.survey.phi) return known.survey;
    const double voxel = std::max(known.size, surveyVoxel(mSource.box));
    // Coarse voxels would close holes between points, or in a sheet, that the distances leave open; what a surface with
    // a hole encloses is not inside.
    if (mMend.offset() > 0) {
      const MeshToSdfOptions deep = sdfBand(known.size, 2 * kSurveyMargin * voxel / known.size, kWholeInside);
      return {resampled(makeTarget(sdfOf(deep, monitor).grid, mSource.box), voxel)};
    }
    return {sdfOf(sdfBand(voxel, kSurveyMargin, kWholeInside), monitor).grid};
  }

  std::optional<double> chosenSdfResolution(Monitor& monitor) const override { return voxels(monitor).chosen; }

  std::shared_ptr<const Mesh> solid() const override {
    return mMend.offset() > 0 || (mMend.repair && !mMend.solidify) ? nullptr : mSource.solid;
  }
  std::shared_ptr<const Mesh> mesh() const override { return mSource.mesh; }

 private:
  struct Voxels {
    double size = 0;               ///< world units
    std::optional<double> chosen;  ///< voxels along the longest side; nullopt if they were given
    CoarseDistances survey{};      ///< by which they were chosen
  };

  MeshSdf sdfOf(const MeshToSdfOptions& options, Monitor& monitor) const {
    return makeSdfAbout(mSource.box.getCenter(), *mSource.solid, options, mMend, monitor);
  }

  MeshToSdfOptions sdfBandOf(const BandWidths& widths, Monitor& monitor) const {
    return bandAt(voxels(monitor).size, widths);
  }
  static MeshToSdfOptions bandAt(double voxel, const BandWidths& widths) {
    const double interior = widths.wholeInside ? kWholeInside : widths.interior;
    return sdfBand(voxel, widths.exterior / voxel + kExponentMargin, interior / voxel + kExponentMargin);
  }

  Voxels voxels(Monitor& monitor) const {
    const std::lock_guard lock(mMutex);
    if (!mVoxels) mVoxels = chosenVoxels(monitor);
    return *mVoxels;
  }

  /// Implements chosenSdfResolution(). The limit does not depend on the memory of the machine, so that every machine
  /// makes the same set.
  Voxels chosenVoxels(Monitor& monitor) const {
    constexpr double kShare = 0.05, kAcross = 8, kMostOnSurface = 400'000;
    const double side = longestSide(mSource.box), coarse = surveyVoxel(mSource.box);
    Voxels result{.survey = {sdfOf(sdfBand(coarse, kSurveyMargin, kWholeInside), monitor).grid}};
    double resolution = std::max(kUsualSdfResolution, side / coarse);
    try {
      result.survey.thickness.emplace(*result.survey.phi, monitor);
      if (const std::optional<double> thin = result.survey.thickness->leastThickness(kShare, monitor))
        resolution = std::max(
            resolution, std::min(kAcross / *thin,
                                 std::sqrt(kMostOnSurface / areaOf(mSource.solid->triangles, mSource.solid->points))) *
                            side);
    } catch (const DataError&) {
      // It has no inside at these voxels; the finer ones will show whether it has one.
    }
    result.chosen = upToTens(resolution);
    result.size = VoxelChoice{.resolution = result.chosen}.sizeFor(side);
    return result;
  }

  SolidSource mSource;
  MendOptions mMend;
  mutable std::mutex mMutex;  // guards what follows
  mutable std::optional<Voxels> mVoxels;
};

class VdbInput final : public TargetInput {
 public:
  VdbInput(const TargetOptions& options, Monitor& monitor)
      : mTarget(readVdbTarget(options.input.path, options.grid, options.mend.volume, monitor)) {}

  const BBoxd& box() const override { return mTarget.box; }
  double usualDepth() const override { return 2.5; }
  std::optional<double> chosenSdfResolution(Monitor&) const override { return std::nullopt; }

  Target distances(const BandWidths&, Monitor&) const override { return mTarget; }
  /// The result of sweeping depends on how far it goes, so each band is swept from the file's own band.
  Target band(const Target& distances, const BandWidths& widths, Monitor& monitor) const override {
    const std::lock_guard lock(mMutex);
    const Target near = grown(mNear, distances, widths.exterior, widths.interior, monitor);
    return widths.wholeInside ? grown(mWhole, near, widths.exterior, kWholeInside, monitor) : near;
  }

  Target bandOf(double, const BandWidths&, Monitor&) const override {
    throw std::logic_error("the distances of a VDB have its own voxels");
  }

  CoarseDistances coarseDistances(Monitor& monitor) const override {
    const Vec3d size = mTarget.phi->voxelSize();
    const double finest = std::min({size[0], size[1], size[2]}), voxel = std::max(finest, surveyVoxel(mTarget.box));
    Target deep = mTarget;
    extendBand(deep, kSurveyMargin * voxel, kWholeInside, monitor);
    return {resampled(deep, voxel)};
  }

 private:
  /// The last swept band, for requests of the same band.
  struct Swept {
    FloatGrid::ConstPtr from;
    BandGrowth growth;
    Target target;
  };

  /// The result of extendBand() for @a from.
  static Target grown(std::optional<Swept>& swept, const Target& from, double exterior, double interior,
                      Monitor& monitor) {
    const std::optional<BandGrowth> growth = bandGrowth(from, exterior, interior, monitor);
    if (!growth) return from;
    if (swept && swept->from == from.phi && swept->growth == *growth) return swept->target;
    Target target = from;
    growBand(target, *growth, monitor);
    swept = Swept{from.phi, *growth, target};
    return target;
  }

  Target mTarget;
  mutable std::mutex mMutex;  // guards what follows
  mutable std::optional<Swept> mNear, mWhole;
};

}  // namespace

double surveyVoxel(const BBoxd& box) {
  constexpr double kSide = 128, kLongest = 512;
  const double longest = longestSide(box);
  const Vec3d sides = box.extents() / longest;
  return longest / std::min(kLongest, std::floor(kSide / elementary::cbrt(sides.product())));
}

std::string sha256OfMesh(const Mesh& mesh) {
  static_assert(std::endian::native == std::endian::little);
  static_assert(sizeof(Vec3d) == 3 * sizeof(double) && sizeof(openvdb::Vec3I) == 3 * sizeof(std::uint32_t));
  std::string bytes(reinterpret_cast<const char*>(mesh.points.data()), mesh.points.size() * sizeof(Vec3d));
  bytes.append(reinterpret_cast<const char*>(mesh.triangles.data()), mesh.triangles.size() * sizeof(openvdb::Vec3I));
  return sha256Hex(bytes);
}

namespace {

constexpr double kUsualFps = 24;

/// The rule for options that apply to an animated glTF.
std::string idleWithoutGltf(const OptionRun& run) {
  const std::string input = run.text("input");
  if (input.empty()) return "it is for an animated glTF as the target, and there is no target; leave it out";
  if (mayBeAnimated(input)) return {};
  return "it is for an animated glTF as the target, and '" + input + "' is none; leave it out";
}

std::string idleWithoutFrame(const OptionRun& run) {
  return run.text("target-frame").empty() ? "it is for --target-frame, which is not given" : "";
}

/// What a recipe says of a target's animation.
struct AnimationOptions {
  double fps = kUsualFps;
  std::optional<double> frame{};
  std::string name{};  ///< empty: the first animation
};

const OptionRows<AnimationOptions>& animationRows() {
  static const OptionRows<AnimationOptions> rows{
      {{.name = "target-frame",
        .argument = "F",
        .help =
            "the frame at which an animated glTF is the target; with --frames each frame by itself. Without a frame "
            "the nodes stand as the file says",
        .idle = idleWithoutGltf},
       number(&AnimationOptions::frame)},
      {{.name = "target-fps",
        .argument = "N",
        .help = "frames of that animation per second: frame F is F / N seconds after its beginning",
        .defaultNote = numbersText({kUsualFps}),
        .idle = idleByAny({idleWithoutGltf, idleWithoutFrame})},
       withoutDefault(number(&AnimationOptions::fps, above(0)))},
      {{.name = "target-animation",
        .argument = "NAME",
        .help = "which animation, by its name or by its number from 0; all: all of them at once",
        .defaultNote = "the first",
        .idle = idleByAny({idleWithoutGltf, idleWithoutFrame})},
       withoutDefault(text(&AnimationOptions::name))}};
  return rows;
}

/// The moment that a recipe names. @param input  empty if there is no target
std::optional<MeshMoment> parseMomentOptions(const RecipeReader& reader, const std::filesystem::path& input) {
  const AnimationOptions options = animationRows().read(reader);
  if (!options.frame || input.empty()) return std::nullopt;
  if (!mayBeAnimated(input))
    throw std::invalid_argument("--target-frame is for an animated glTF, and '" + input.string() +
                                "' is none; leave it out");
  return MeshMoment{*options.frame / options.fps, options.name};
}

void parseSdfVoxels(const RecipeReader& reader, TargetOptions& options) {
  if (!reader.has("sdf-voxel-size")) {
    if (reader.text("sdf-resolution") == kAutomatic) return;
    if (!numberFromText(reader.text("sdf-resolution"))) reader.refuse("sdf-resolution", "a number of voxels, or auto");
  }
  options.sdfVoxels = reader.voxels("sdf-resolution", "sdf-voxel-size");
}

const OptionRows<TargetOptions>& targetRows() {
  static const OptionRows<TargetOptions> rows{
      {{.name = "input",
        .argument = "MESH|SDF.vdb",
        .help = "the target: a mesh, or a VDB that holds its signed distance or a volume",
        .displaces = {"target-before", "target-after"},
        .hash = "source-sha256"},
       parsed(&TargetOptions::input,
              [](const RecipeReader& reader, const std::string& name) { return reader.file(name); })},
      {{.name = "grid", .argument = "NAME", .help = "which grid of the input VDB to use", .idle = idleWithoutVdb},
       text(&TargetOptions::grid)},
      {{.name = "sdf-resolution",
        .argument = "N|auto",
        .defaultValue = kAutomatic,
        .help = "voxels of the target's distance field along its longest side; the fractal depends on this. auto: 200, "
                "or more where thin parts need them",
        .alternative = "sdf-voxel-size",
        .idle = idleWithoutMesh},
       readByRule(above(0), {kAutomatic})},
      {{.name = "sdf-voxel-size",
        .argument = "H",
        .help = "the same given as the size of a voxel, in the target's units",
        .alternative = "sdf-resolution",
        .idle = idleWithoutMesh},
       readByRule(above(0))}};
  return rows;
}

}  // namespace

std::vector<OptionSpec> targetOptionSpecs() {
  std::vector<OptionSpec> options = targetRows().specs();
  for (OptionSpec& option : mendOptionSpecs()) options.push_back(std::move(option));
  for (OptionSpec& option : animationRows().specs()) options.push_back(std::move(option));
  return options;
}

MeshMoment momentOfFrame(const RecipeReader& reader, double frame) {
  const AnimationOptions options = animationRows().read(reader);
  return {frame / options.fps, options.name};
}

std::optional<TargetOptions> parseTargetOptions(const RecipeReader& reader) {
  TargetOptions options{.mend = parseMendOptions(reader)};
  targetRows().read(reader, options);
  parseSdfVoxels(reader, options);
  options.moment = parseMomentOptions(reader, options.input.path);
  if (options.input.path.empty()) return std::nullopt;
  return options;
}

bool hasAutomaticSdfResolution(const Recipe& recipe) {
  const auto input = recipe.find("input"), resolution = recipe.find("sdf-resolution");
  return input != recipe.end() && !input->second.empty() && !isVdbPath(input->second) &&
         !recipe.contains("sdf-voxel-size") && (resolution == recipe.end() || resolution->second == kAutomatic);
}

std::unique_ptr<const TargetInput> openTarget(const TargetOptions& options, Monitor& monitor) {
  if (!options.mesh && isVdbPath(options.input.path)) return std::make_unique<VdbInput>(options, monitor);
  return std::make_unique<MeshInput>(options);
}

}  // namespace vdbtools
