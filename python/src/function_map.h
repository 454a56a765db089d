// SPDX-License-Identifier: Apache-2.0
/// @file function_map.h
/// A map that is any function of the program's own, as a map beside those of the library. Nothing is proved of it:
/// every node of its ball is evaluated.
#pragma once

#include "vdbtools/maps/map_registry.h"

#include <functional>
#include <span>
#include <vector>

/// The next iterates of quaternions, given with the points where their orbits began: four numbers a quaternion in both
/// and in the result. One with a number that is not finite has escaped. Called in many threads at once; the same
/// iterate and start must always have the same result.
using MapFunction =
    std::function<std::vector<double>(std::span<const double> iterates, std::span<const double> starts)>;

/// The map "function".
vdbtools::MapRegistry::Descriptor functionMap(MapFunction function);
