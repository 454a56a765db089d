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
  /// The most nodes of the volume along any axis, from 16 to 256, which every implementation of WebGL 2 can hold. A
  /// finer exponent is read at this many places.
  int side = 256;
};

struct SceneData {
  /// All lengths are in fractal space but for those of the entries "space" and "frame". What is infinite is null.
  nlohmann::json description;
  /// Of a map with an exponent, otherwise empty: its values as little-endian 16-bit floats, X fastest, then Y.
  std::string volume;
};

/// @throw std::invalid_argument  the map has no description (julia/map_description.h), or options out of their ranges
/// @throw Interrupted
SceneData sceneData(const Scene& scene, const SceneDataOptions& options, Monitor& monitor);

/// A 16-bit float, little-endian; values beyond those that it can hold become the largest. @return it as a float
float appendHalf(std::string& bytes, float value);

/// @throw std::invalid_argument  the page has no shader for the scene's versor: a formula, a field or layers, say
void requireShown(const Scene& scene);

}  // namespace vdbtools::explore
