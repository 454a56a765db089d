// SPDX-License-Identifier: Apache-2.0
/// @file made_fractal.h
/// Files that need not be made again.
#pragma once

#include "vdbtools/recipe/recipe.h"

#include <filesystem>

namespace vdbtools {

/// Whether a file is what writeFractal() of this version of the program makes of a recipe: a VDB, PLY or OBJ that can
/// be read to its end and holds this recipe and no other. False for a file of any other kind, which holds none (STL),
/// and where there is none.
/// @param recipe  complete, and with the hashes of its files
bool holdsFractal(const std::filesystem::path& path, const Recipe& recipe);

}  // namespace vdbtools
