// SPDX-License-Identifier: Apache-2.0
/// @file made_fractal.h
/// Recognises files that need not be made again.
#pragma once

#include "vdbtools/recipe/recipe.h"

#include <filesystem>

namespace vdbtools {

/// Whether a file is what writeFractal() of this version of the program makes of a recipe: a VDB, PLY or OBJ that can
/// be read to its end and records exactly this recipe. False for files of other formats, which do not record a recipe
/// (STL), and if there is no such file.
/// @param recipe  complete, with the hashes of its files
bool holdsFractal(const std::filesystem::path& path, const Recipe& recipe);

}  // namespace vdbtools
