// SPDX-License-Identifier: Apache-2.0
/// @file grid_names.h
/// The names that grids have in files, so that the volume shaders of other programs find them without being told.
#pragma once

#include "vdbtools/recipe/recipe_reader.h"

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vdbtools {

/// The names that grids get in a file, by the program's own names; grids that are not listed keep theirs.
using GridNames = std::map<std::string, std::string>;

/// --grid-names: a program, or pairs such as trap=temperature, or both, with commas between them.
OptionSpec gridNamesOption();

/// @param text   the value of --grid-names; empty: all grids keep their names
/// @param grids  the grids that are made, by the program's own names
/// @throw std::invalid_argument  no such program; a pair for a grid that is not made; two grids that would have one
///                               name
GridNames parseGridNames(const std::string& text, std::span<const std::string> grids);

/// The metadata of a file in which the grid of distances called @a own has another name; empty if it has not.
std::map<std::string, std::string> distanceGridMetadata(const GridNames& names, const std::string& own);

}  // namespace vdbtools
