// SPDX-License-Identifier: Apache-2.0
/// @file function_map.h
/// A map that is an arbitrary function of the calling program. Nothing can be proved about it, so every node of its
/// ball is evaluated.
#pragma once

#include "vdbtools/maps/map_registry.h"

#include <functional>
#include <span>
#include <vector>

/// Returns the next iterates of quaternions. Its arguments are the iterates and the points where their orbits began;
/// both and the result have four numbers per quaternion. An iterate with a number that is not finite has escaped. Many
/// threads may call it at once; the same iterate and start must always give the same result.
using MapFunction =
    std::function<std::vector<double>(std::span<const double> iterates, std::span<const double> starts)>;

/// The map "function".
vdbtools::MapRegistry::Descriptor functionMap(MapFunction function);
