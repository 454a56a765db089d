// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/scene/voxel_advice.h"

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/base/text.h"
#include "vdbtools/base/voxel_choice.h"

#include <algorithm>
#include <cmath>

namespace vdbtools {
namespace {

/// The maximum resolution that is suggested: finer features fit into no lattice.
constexpr double kMostResolution = 4000;

constexpr double kTens = 10;  // chosen resolutions are multiples of it

std::optional<double> voxelFor(double size) {
  return size > 0 && std::isfinite(size) ? std::optional(size / 2) : std::nullopt;
}

std::string percent(double share) { return shortText(std::round(1000 * share) / 10) + " %"; }

/// "--resolution 440" or "--voxel-size 0.01", whichever the recipe has; empty if the number is unreasonable.
std::string voxelOptionFor(const Scene& scene, double voxel) {
  const double resolution = upToTens(longestSide(scene.target->distances.box) / voxel);
  if (resolution > kMostResolution) return {};
  if (scene.options.lattice.voxels.voxelSize) return "--voxel-size " + shortText(voxel, Rounding::Down);
  return "--resolution " + shortText(resolution);
}

std::string textureRemedy(const Scene& scene, const VoxelAdvice& advice) {
  const std::string option = advice.textureVoxel ? voxelOptionFor(scene, *advice.textureVoxel) : "";
  if (!option.empty()) return option + " shows all but " + percent(kTextureLeftOut) + " of it";
  return scene.target->octave ? "a lower --frequency makes it wider" : "a larger --texture-scale makes it wider";
}

std::string coreRemedy(const Scene& scene, const VoxelAdvice& advice) {
  const std::string option = advice.coreVoxel ? voxelOptionFor(scene, *advice.coreVoxel) : "";
  // If there is no core at all, smaller voxels do not create one.
  const bool voxelsDo = !option.empty() && scene.features()->core.shareBelow(2 * *advice.coreVoxel) < kCoreWorthSaying;
  if (voxelsDo) return option + " holds it";
  return option.empty() ? "less --detail makes it thicker" : option + " and less --detail hold it";
}

/// Estimates the memory of the whole process while it makes files. The figures are rounded up from peaks that were
/// measured with a bunny and with sixty spheres that intersect, at 200 to 1000 voxels (docs/performance.md).
double memoryAt(const Scene& scene, double voxel) {
  // Bytes, most of them for each square voxel of the target's surface. The shell itself takes little: only some layers
  // of it are in memory at a time.
  constexpr double kOfProcess = 180e6, kOfSurface = 750, kOfHeldMesh = 500, kOfAdaptivity = 3600, kOfValue = 200,
                   kOfVector = 400;
  const OutputOptions& output = scene.options.output;
  double bytes = kOfSurface;
  if (!output.levels.empty() || dropsIslands(scene.options)) bytes += kOfHeldMesh;
  if (scene.options.surface.adaptivity > 0) bytes += kOfAdaptivity;
  for (const OutputGrid grid : output.grids)
    if (grid != OutputGrid::Surface) bytes += grid == OutputGrid::Versor ? kOfVector : kOfValue;
  for (const VertexColumn& column : meshColumns(output.attributes))
    bytes += componentsOf(column.kind) == 1 ? kOfValue : kOfVector;
  return kOfProcess + bytes * scene.features()->area / (voxel * voxel);
}

}  // namespace

VoxelAdvice adviseVoxels(const FeatureSizes& sizes, double voxel) {
  return {.textureShare = sizes.texture.shareBelow(2 * voxel),
          .coreShare = sizes.core.shareBelow(2 * voxel),
          .textureVoxel = voxelFor(sizes.texture.quantile(kTextureLeftOut)),
          .coreVoxel = voxelFor(sizes.core.positiveQuantile(kCoreLeftOut))};
}

std::string finerThanVoxelsText(const Scene& scene) {
  if (!scene.features()) return {};
  const VoxelAdvice advice = adviseVoxels(*scene.features(), scene.voxelSize);
  std::string text;
  if (advice.textureShare > kTextureWorthSaying)
    text = percent(advice.textureShare) + " of the texture is finer than two voxels; " + textureRemedy(scene, advice);
  if (advice.coreShare > kCoreWorthSaying)
    text += (text.empty() ? "" : "; and ") + std::string("under ") + percent(advice.coreShare) +
            " of the surface the core that --detail leaves is thinner than two voxels, so that it may break; " +
            coreRemedy(scene, advice);
  return text;
}

std::string coarseFloatsText(const Scene& scene) {
  constexpr double kMost = 0.1;  // voxels: from this rounding on, many vertices leave their edges
  const double rounding = floatRounding(scene);
  if (scene.field.arithmetic != Arithmetic::Float || rounding < kMost) return {};
  return "--precision float rounds positions by up to " + shortText(rounding) +
         " voxels here, so that most vertices are not on the surface; --precision double places them";
}

ChosenResolution chooseResolution(const Scene& scene, bool withinMemory) {
  // The limits along the longest side of the result: no less than the default, and no more than floats resolve.
  constexpr double kLeast = 300, kMost = 1000;
  const double side = longestSide(scene.target->distances.box);
  const double made = scene.options.lattice.box ? std::min(side, longestSide(*scene.options.lattice.box)) : side;
  const double least = upToTens(kLeast * side / made), most = upToTens(kMost * side / made);
  const VoxelAdvice advice = adviseVoxels(*scene.features(), side / least);
  double wanted = least;
  if (advice.coreVoxel && upToTens(side / *advice.coreVoxel) <= most)
    wanted = std::max(wanted, upToTens(side / *advice.coreVoxel));
  if (advice.textureVoxel) wanted = std::max(wanted, upToTens(side / *advice.textureVoxel));
  ChosenResolution chosen{.resolution = std::min(wanted, most)};
  if (wanted > most) chosen.limit = ChosenResolution::Limit::Most;
  if (!withinMemory) return chosen;
  const double bytes = memoryInAll();  // the estimate is for the whole process, including the memory that it has now
  for (; chosen.resolution > kTens && memoryAt(scene, side / chosen.resolution) > bytes; chosen.resolution -= kTens)
    chosen.limit = ChosenResolution::Limit::Memory;
  return chosen;
}

std::optional<double> fittingResolution(const Scene& scene, double bytes) {
  if (!scene.features()) return std::nullopt;
  // Per square voxel, for the bytes of the files while they are handed over.
  constexpr double kOfFiles = 700;
  const double area = scene.features()->area;
  const auto needed = [&](double voxel) { return memoryAt(scene, voxel) + kOfFiles * area / (voxel * voxel); };
  if (needed(scene.voxelSize) <= bytes) return std::nullopt;
  const double side = longestSide(scene.target->distances.box);
  // More voxels take more memory, so that the bound can be found by halves: `fits` does, `more` does not.
  double fits = 0, more = std::ceil(side / scene.voxelSize / kTens);
  while (more - fits > 1) {
    const double middle = std::floor((fits + more) / 2);
    (needed(side / (kTens * middle)) <= bytes ? fits : more) = middle;
  }
  return kTens * fits;
}

std::string chosenResolutionText(const Scene& scene) {
  if (!scene.chosenResolution) return {};
  const auto& [resolution, limit] = *scene.chosenResolution;
  std::string text = "resolution " + shortText(resolution) + ": ";
  switch (limit) {
    case ChosenResolution::Limit::None:
      return text + "all but " + percent(adviseVoxels(*scene.features(), scene.voxelSize).textureShare) +
             " of the texture is at least two voxels wide";
    case ChosenResolution::Limit::Most: return text + "the most that 'auto' takes";
    case ChosenResolution::Limit::Memory: break;
  }
  return text + "limited by the memory that is left; --memory sets another limit";
}

std::string chosenSdfResolutionText(const Scene& scene) {
  if (scene.chosenSdfResolution.value_or(0) <= kUsualSdfResolution) return {};
  return "sdf-resolution " + shortText(*scene.chosenSdfResolution) + ": the target is slender or has thin parts";
}

}  // namespace vdbtools
