// SPDX-License-Identifier: Apache-2.0
/// @file prepared_scene.h
/// What a scene takes long to make of its target, kept in a file: the distances, the exponent, and the numbers that
/// were found on the way. A scene that is read from it evaluates the same bits.
#pragma once

#include "vdbtools/scene/scene.h"

#include <filesystem>
#include <string>

namespace vdbtools {

/// The bytes of a VDB with the grids "phi", "exponent", "octave", "thickness" and those of controls, as far as the
/// scene has them.
std::string encodePreparedScene(const Scene& scene);

/// The scene again, without SceneShell::made. The target's mesh, the controls and their files are not opened.
/// @param options  those that the scene was made with
/// @throw MissingInputError, DataError, IoError
Scene readPreparedScene(const FractalOptions& options, const std::filesystem::path& path);

}  // namespace vdbtools
