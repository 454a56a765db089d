// SPDX-License-Identifier: Apache-2.0
/// @file products.h
/// Determines the products, in the terms of the rules of a fractal's options, that files have.
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
