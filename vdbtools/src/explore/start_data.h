// SPDX-License-Identifier: Apache-2.0
/// @file start_data.h
/// The data about the program that the page needs at the start: options, maps, textures.
#pragma once

#include <nlohmann/json.hpp>

namespace vdbtools::explore {

/// {version, options: those of a fractal (vdbtools/recipe/option_table.h), each with the group that it belongs to,
/// maps: [{name, summary, target, roots, dimension}], textures: [{name, description, varies, thumbnail}], colours,
/// resolutions, formats}.
nlohmann::json programData();

}  // namespace vdbtools::explore
