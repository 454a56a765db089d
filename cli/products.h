// SPDX-License-Identifier: Apache-2.0
/// @file products.h
/// The products that the files of a fractal are in the rules of its options.
#pragma once

#include "vdbtools/recipe/option_table.h"

#include <set>

namespace cli {

class CommandLine;

/// The products of -o and --mesh.
std::set<vdbtools::Product> productsOf(const CommandLine& line);
/// The products of --make, a list of formats.
std::set<vdbtools::Product> productsOf(const std::vector<std::string>& makes);

}  // namespace cli
