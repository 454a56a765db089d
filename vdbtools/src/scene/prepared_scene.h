// SPDX-License-Identifier: Apache-2.0
/// @file prepared_scene.h
/// Stores in a file what takes long to compute of a scene: the distances, the exponent, and the numbers that were found
/// on the way. A scene that is read from the file evaluates to the same bits.
#pragma once

#include "vdbtools/scene/scene.h"

#include <filesystem>
#include <string>

namespace vdbtools {

/// The bytes of a VDB with the scene's grids: "phi", "exponent", "octave", "thickness" and the grids of controls, as
/// far as the scene has them.
std::string encodePreparedScene(const Scene& scene);

/// Reads the scene back, without SceneShell::made. The controls and their files are not opened, and the
/// target's mesh only if it moves: the scene is that of the target at rest, which is carried to the pose anew.
/// @param options  the options from which the scene was made
/// @throw MissingInputError, DataError, IoError
Scene readPreparedScene(const FractalOptions& options, const std::filesystem::path& path);

}  // namespace vdbtools
