// SPDX-License-Identifier: Apache-2.0
/// @file voxel_advice.h
/// Measures how much of a scene is finer than its voxels, says which voxels would show it, and chooses `--resolution
/// auto`.
#pragma once

#include "vdbtools/scene/scene.h"

#include <optional>
#include <string>

namespace vdbtools {

/// Of the texture, this share may be finer than two voxels where voxels are said to do; of the core, this one.
inline constexpr double kTextureLeftOut = 0.1, kCoreLeftOut = 0.02;
/// From these shares on it is worth saying that something is finer than two voxels.
inline constexpr double kTextureWorthSaying = 0.25, kCoreWorthSaying = 0.03;

/// Two voxels are what a lattice needs to show a wave, or to be sure to have a node in a wall.
struct VoxelAdvice {
  double textureShare = 0;  ///< of the surface where the texture is narrower than two voxels, 0 to 1
  double coreShare = 0;     ///< of the surface where the core that is promised is thinner than two voxels, 0 to 1
  /// The voxels that would do, world units: for all but kTextureLeftOut of the texture, and for all but kCoreLeftOut of
  /// the core where there is one. None where none would.
  std::optional<double> textureVoxel{}, coreVoxel{};
};

/// @param voxel  world units
VoxelAdvice adviseVoxels(const FeatureSizes& sizes, double voxel);

/// A sentence about what is finer than a scene's voxels, with options that would do; empty if it is little, or if
/// nothing was measured.
std::string finerThanVoxelsText(const Scene& scene);

/// A sentence for a scene in whose voxels floats, which were asked for, are wrong; empty for any other.
std::string coarseFloatsText(const Scene& scene);

/// How `--resolution auto` came to its number: "resolution 440: ..."; empty for a scene whose resolution was given.
std::string chosenResolutionText(const Scene& scene);

/// A sentence about distances finer than usual, which thin parts of the target need; empty if they are the usual ones.
std::string chosenSdfResolutionText(const Scene& scene);

/// The number that `--resolution auto` stands for, a multiple of 10: the least one whose voxels would do by
/// adviseVoxels(), and 300 to 1000 voxels along the longest side of the target or of the box, as far as memory allows.
/// A core that needs more than 1000 is left out of account.
/// @param scene  made as far as its features; its options' box counts
ChosenResolution chooseResolution(const Scene& scene, bool withinMemory);

/// What a run needs at most, about: for its mesh and its level set at this voxel size; bytes.
double estimatedMemory(const Scene& scene, double voxel);

}  // namespace vdbtools
