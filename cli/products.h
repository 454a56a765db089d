// SPDX-License-Identifier: Apache-2.0
/// @file products.h
/// What the files of a fractal are to its options.
#pragma once

#include "vdbtools/recipe/option_table.h"

#include <set>

namespace cli {

class CommandLine;

/// Of -o and --mesh.
std::set<vdbtools::Product> productsOf(const CommandLine& line);
/// Of --make, a list of formats.
std::set<vdbtools::Product> productsOf(const std::vector<std::string>& makes);

}  // namespace cli
