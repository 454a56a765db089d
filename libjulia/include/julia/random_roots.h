// SPDX-License-Identifier: Apache-2.0
/// @file random_roots.h
/// Random polynomials for the versor ([SK23] 3.3.2): roots strewn in or near the target, with random powers. The same
/// seed gives the same roots everywhere; nothing is taken from a clock.
#pragma once

#include "julia/embedding.h"
#include "julia/rational.h"

#include <cstdint>
#include <functional>

namespace julia {

enum class RootPlacement {
  Box,      ///< evenly in the target's bounding box
  Inside,   ///< evenly inside the target
  Surface,  ///< evenly within a distance of the target's surface
  Cluster,  ///< normally distributed about a point
};

struct RandomRootsOptions {
  std::uint64_t seed = 1;
  int count = 10;
  double minPower = 2, maxPower = 11;
  bool integerPowers = false;
  RootPlacement placement = RootPlacement::Box;
  Point boxMin{-0.5, -0.5, -0.5}, boxMax{0.5, 0.5, 0.5};  ///< units of the map's space
  double surfaceDistance = 0.05;                          ///< Surface: at most this far, units of the map's space
  Point clusterCentre{0, 0, 0};                           ///< Cluster
  double clusterRadius = 0.1;                             ///< Cluster: the standard deviation
  Embedding embedding;                                    ///< roots lie in the slice
  /// The target's signed distance in the map's space; Inside and Surface need it.
  std::function<double(const Point&)> distance;
};

/// @throw std::invalid_argument  a number out of its domain, a placement without its distance, or a target so thin
///                               that no point was found in it
Polynomial randomPolynomial(const RandomRootsOptions& options);

}  // namespace julia
