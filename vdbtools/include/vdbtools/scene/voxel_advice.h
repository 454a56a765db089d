// SPDX-License-Identifier: Apache-2.0
/// @file voxel_advice.h
/// Measures how much of a scene is finer than its voxels, says which voxels would show it, and chooses `--resolution
/// auto`.
#pragma once

#include "vdbtools/scene/scene.h"

#include <optional>
#include <string>

namespace vdbtools {

/// Voxels are fine enough if no more than these fractions of the texture and of the core are finer than two voxels.
inline constexpr double kTextureLeftOut = 0.1, kCoreLeftOut = 0.02;
/// From these fractions on, it is reported that the texture or the core is finer than two voxels.
inline constexpr double kTextureWorthSaying = 0.25, kCoreWorthSaying = 0.03;

/// How much of a scene is finer than two voxels, which a lattice needs to show a wave, or to have a node in every wall.
struct VoxelAdvice {
  double textureShare = 0;  ///< fraction of the surface where the texture is narrower than two voxels
  double coreShare = 0;     ///< fraction of the surface where the guaranteed core is thinner than two voxels
  /// The voxels that are fine enough, world units: for all but kTextureLeftOut of the texture, and for all but
  /// kCoreLeftOut of the core, if there is one. Empty if no voxels are.
  std::optional<double> textureVoxel{}, coreVoxel{};
};

/// @param voxel  world units
VoxelAdvice adviseVoxels(const FeatureSizes& sizes, double voxel);

/// A sentence about what is finer than a scene's voxels, with options that would show it; empty if that is little, or
/// if nothing was measured.
std::string finerThanVoxelsText(const Scene& scene);

/// A warning if floats were requested although they are wrong for the scene's voxels; otherwise empty.
std::string coarseFloatsText(const Scene& scene);

/// How the number of `--resolution auto` was chosen: "resolution 440: ..."; empty for a scene whose resolution was
/// given.
std::string chosenResolutionText(const Scene& scene);

/// A sentence about distances that are finer than usual because thin parts of the target need them; otherwise empty.
std::string chosenSdfResolutionText(const Scene& scene);

/// The number that replaces `--resolution auto`, a multiple of 10: the smallest one whose voxels are fine enough
/// according to adviseVoxels(), between 300 and 1000 voxels along the longest side of the target or of the box, as far
/// as memory allows. A core that needs more than 1000 is ignored.
/// @param scene  complete up to its features; the box of its options is used
ChosenResolution chooseResolution(const Scene& scene, bool withinMemory);

/// The resolution whose files can be made and held within this memory, a multiple of 10, by the estimate of
/// `--resolution auto`; 0 if none can. Empty if the scene's own can, or if nothing was measured.
/// @param bytes  for the whole process
std::optional<double> fittingResolution(const Scene& scene, double bytes);

}  // namespace vdbtools
