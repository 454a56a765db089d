// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/target/target_input.h"

#include "base/elementary.h"
#include "base/lattice_transform.h"
#include "distance/band_growth.h"
#include "distance/mesh_conversion.h"
#include "distance/united_parts.h"
#include "repair/solid_input.h"
#include "vdbtools/files/file_hash.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/mesh_files/mesh_animation.h"
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

namespace vdbtools {
namespace {

using openvdb::BBoxd;

using openvdb::FloatGrid;
using openvdb::Vec3d;

constexpr double kWholeInside = std::numeric_limits<double>::infinity();
constexpr double kSurveyMargin = 4;  ///< voxels known outside, in the survey

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
      : mSource(openSolid(options.input.path, options.mesh, options.mend, options.moment)),
        mVoxel(options.sdfVoxels.sizeFor(longestSide(mSource.box))),
        mMend(options.mend) {
    requireResolved(mMend, mVoxel);
    // A target for which even the narrowest band is too large is refused before the survey, which takes a while.
    constexpr double kNarrowest = 1.5;
    if (mMend.offset() == 0) checkOptions(mSource.report, sdfBand(mVoxel, kNarrowest, kNarrowest));
  }

  const BBoxd& box() const override { return mSource.box; }
  double usualDepth() const override { return 5.5; }

  Target distances(const BandWidths& widths, Monitor& monitor) const override {
    const MeshSdf sdf = makeSdfAbout(mSource.box.getCenter(), *mSource.solid, sdfBandOf(widths), mMend, monitor);
    Target target = makeTarget(sdf.grid, mSource.box);
    target.repairMoved = sdf.moved;
    if (sdf.united > 0) target.phi->insertMeta(kUnitedParts, openvdb::StringMetadata(std::to_string(sdf.united)));
    return target;
  }

  Target band(const Target& distances, const BandWidths& widths, Monitor&) const override {
    const FloatGrid::Ptr phi = narrowed(distances.phi, sdfBandOf(widths));
    if (phi == distances.phi) return distances;
    Target target = makeTarget(phi, distances.box);
    target.repairMoved = distances.repairMoved;
    if (const auto united = (*distances.phi)[kUnitedParts]) target.phi->insertMeta(kUnitedParts, *united);
    return target;
  }

  FloatGrid::ConstPtr coarseDistances(Monitor& monitor) const override {
    const double voxel = std::max(mVoxel, surveyVoxel(mSource.box));
    // Coarse voxels would close holes between points, or in a sheet, that the distances leave open; what a surface with
    // a hole encloses is not inside.
    if (mMend.offset() > 0) {
      const MeshToSdfOptions deep = sdfBand(mVoxel, 2 * kSurveyMargin * voxel / mVoxel, kWholeInside);
      return resampled(
          makeTarget(makeSdfAbout(mSource.box.getCenter(), *mSource.solid, deep, mMend, monitor).grid, mSource.box),
          voxel);
    }
    return makeSdfAbout(mSource.box.getCenter(), *mSource.solid, sdfBand(voxel, kSurveyMargin, kWholeInside), mMend,
                        monitor)
        .grid;
  }

  std::shared_ptr<const Mesh> solid() const override {
    return mMend.offset() > 0 || (mMend.repair && !mMend.solidify) ? nullptr : mSource.solid;
  }
  std::shared_ptr<const Mesh> mesh() const override { return mSource.mesh; }

 private:
  MeshToSdfOptions sdfBandOf(const BandWidths& widths) const {
    const double interior = widths.wholeInside ? kWholeInside : widths.interior;
    return sdfBand(mVoxel, widths.exterior / mVoxel + kExponentMargin, interior / mVoxel + kExponentMargin);
  }

  SolidSource mSource;
  double mVoxel;
  MendOptions mMend;
};

class VdbInput final : public TargetInput {
 public:
  explicit VdbInput(const TargetOptions& options) : mTarget(readVdbTarget(options.input.path, options.grid)) {}

  const BBoxd& box() const override { return mTarget.box; }
  double usualDepth() const override { return 2.5; }

  Target distances(const BandWidths&, Monitor&) const override { return mTarget; }
  /// The result of sweeping depends on how far it goes, so each band is swept from the file's own band.
  Target band(const Target& distances, const BandWidths& widths, Monitor& monitor) const override {
    const std::lock_guard lock(mMutex);
    const Target near = grown(mNear, distances, widths.exterior, widths.interior, monitor);
    return widths.wholeInside ? grown(mWhole, near, widths.exterior, kWholeInside, monitor) : near;
  }

  FloatGrid::ConstPtr coarseDistances(Monitor& monitor) const override {
    const Vec3d size = mTarget.phi->voxelSize();
    const double finest = std::min({size[0], size[1], size[2]}), voxel = std::max(finest, surveyVoxel(mTarget.box));
    Target deep = mTarget;
    extendBand(deep, kSurveyMargin * voxel, kWholeInside, monitor);
    return resampled(deep, voxel);
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

std::string idleWithoutVdb(const OptionRun& run) {
  const std::string input = run.text("input");
  if (!input.empty() && isVdbPath(input)) return {};
  return "it chooses a grid of a VDB as the target, and " +
         (input.empty() ? "there is no target" : "'" + input + "' is a mesh") + "; leave it out";
}

namespace {

constexpr double kUsualFps = 24;

/// The rule for options that apply to an animated glTF.
std::string idleWithoutGltf(const OptionRun& run) {
  const std::string input = run.text("input");
  if (input.empty()) return "it is for an animated glTF as the target, and there is no target; leave it out";
  if (isGltfPath(input)) return {};
  return "it is for an animated glTF as the target, and '" + input + "' is none; leave it out";
}

std::string idleWithoutFrame(const OptionRun& run) {
  return run.text("target-frame").empty() ? "it is for --target-frame, which is not given" : "";
}

std::vector<OptionSpec> animationOptionSpecs() {
  return {{.name = "target-frame",
           .argument = "F",
           .help = "the frame at which an animated glTF is the target; with --frames each frame by itself. Without a "
                   "frame the nodes stand as the file says",
           .idle = idleWithoutGltf},
          {.name = "target-fps",
           .argument = "N",
           .help = "frames of that animation per second: frame F is F / N seconds after its beginning",
           .defaultNote = numbersText({kUsualFps}),
           .idle = idleByAny({idleWithoutGltf, idleWithoutFrame})},
          {.name = "target-animation",
           .argument = "NAME",
           .help = "which animation, by its name or by its number from 0; all: all of them at once",
           .defaultNote = "the first",
           .idle = idleByAny({idleWithoutGltf, idleWithoutFrame})}};
}

/// The moment that a recipe names. @param input  empty if there is no target
std::optional<MeshMoment> parseMomentOptions(const RecipeReader& reader, const std::filesystem::path& input) {
  const double fps = reader.has("target-fps") ? reader.positive("target-fps") : kUsualFps;
  if (!reader.has("target-frame")) return std::nullopt;
  const double frame = reader.number("target-frame");
  if (input.empty()) return std::nullopt;
  if (!isGltfPath(input))
    throw std::invalid_argument("--target-frame is for an animated glTF, and '" + input.string() +
                                "' is none; leave it out");
  return MeshMoment{frame / fps, reader.has("target-animation") ? reader.text("target-animation") : ""};
}

}  // namespace

std::vector<OptionSpec> targetOptionSpecs() {
  std::vector<OptionSpec> options = {
      {.name = "input",
       .argument = "MESH|SDF.vdb",
       .help = "the target: a mesh, or a VDB that holds its signed distance",
       .hash = "source-sha256"},
      {.name = "grid",
       .argument = "NAME",
       .defaultValue = "",
       .help = "which grid of the input VDB to use",
       .idle = idleWithoutVdb},
      {.name = "sdf-resolution",
       .argument = "N",
       .defaultValue = "200",
       .help = "voxels of the target's distance field along its longest side; the fractal depends on this",
       .alternative = "sdf-voxel-size",
       .idle = idleWithoutMesh},
      {.name = "sdf-voxel-size",
       .argument = "H",
       .help = "the same given as the size of a voxel, in the target's units",
       .alternative = "sdf-resolution",
       .idle = idleWithoutMesh},
  };
  for (OptionSpec& option : mendOptionSpecs()) options.push_back(std::move(option));
  for (OptionSpec& option : animationOptionSpecs()) options.push_back(std::move(option));
  return options;
}

std::optional<TargetOptions> parseTargetOptions(const RecipeReader& reader) {
  TargetOptions options{.input = reader.file("input"),
                        .grid = reader.text("grid"),
                        .sdfVoxels = reader.voxels("sdf-resolution", "sdf-voxel-size"),
                        .mend = parseMendOptions(reader)};
  options.moment = parseMomentOptions(reader, options.input.path);
  if (options.input.path.empty()) return std::nullopt;
  return options;
}

std::unique_ptr<const TargetInput> openTarget(const TargetOptions& options) {
  if (!options.mesh && isVdbPath(options.input.path)) return std::make_unique<VdbInput>(options);
  return std::make_unique<MeshInput>(options);
}

}  // namespace vdbtools
