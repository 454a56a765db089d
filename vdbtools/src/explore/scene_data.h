// SPDX-License-Identifier: Apache-2.0
/// @file scene_data.h
/// A scene as data for the page of `juliavdb explore`, whose shaders evaluate the same F in 32-bit floats: the map's
/// numbers as JSON, and the exponent E as a dense texture. docs/explore.md lists the entries.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/scene/scene.h"

#include <nlohmann/json.hpp>

#include <string>

namespace vdbtools::explore {

struct SceneDataOptions {
  /// The maximum number of nodes of the volume along any axis, from 16 to 256, which every implementation of WebGL 2
  /// supports. A finer exponent is sampled at this many places. The grain is not, because its phases turn within a few
  /// nodes.
  int side = 256;
};

struct SceneData {
  /// All lengths are in fractal space, except in the entries "space" and "frame". Infinite numbers are null.
  nlohmann::json description;
  /// For a map with an exponent, the values of the exponent as little-endian 16-bit floats, X fastest, then Y;
  /// otherwise empty.
  std::string volume;
  /// For a texture that follows a grain, the four components of the phases at each node, and then the depths of all
  /// nodes, in the same format; otherwise empty.
  std::string grain;
};

/// @throw std::invalid_argument  the map has no description (julia/map_description.h), or options out of their ranges
/// @throw Interrupted
SceneData sceneData(const Scene& scene, const SceneDataOptions& options, Monitor& monitor);

/// A 16-bit float, little-endian; values beyond those that it can hold become the largest. @return it as a float
float appendHalf(std::string& bytes, float value);

/// The options of the scene that the page shows: that of a target that moves is shown at rest. @throw as
/// optionsAtRest()
FractalOptions shownOptions(const FractalOptions& options);

/// @throw std::invalid_argument  the page has no shader for the scene's versor, such as a formula, a field or layers
void requireShown(const Scene& scene);

}  // namespace vdbtools::explore
