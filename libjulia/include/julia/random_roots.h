// SPDX-License-Identifier: Apache-2.0
/// @file random_roots.h
/// Random polynomials for the versor ([SK23] 3.3.2): roots scattered in or near the target, with random powers. The
/// same seed gives the same roots on every machine and at any time.
#pragma once

#include "julia/embedding.h"
#include "julia/rational.h"

#include <cstdint>
#include <functional>

namespace julia {

enum class RootPlacement {
  Box,      ///< evenly in the target's bounding box
  Inside,   ///< evenly inside the target
  Surface,  ///< evenly within a given distance of the target's surface
  Cluster,  ///< normally distributed about a point
};

struct RandomRootsOptions {
  std::uint64_t seed = 1;
  int count = 10;
  double minPower = 2, maxPower = 11;
  bool integerPowers = false;
  RootPlacement placement = RootPlacement::Box;
  Point boxMin{-0.5, -0.5, -0.5}, boxMax{0.5, 0.5, 0.5};  ///< units of the map's space
  double surfaceDistance = 0.05;                          ///< Surface: the largest distance, units of the map's space
  Point clusterCentre{0, 0, 0};                           ///< Cluster
  double clusterRadius = 0.1;                             ///< Cluster: the standard deviation
  Embedding embedding;                                    ///< roots lie in the slice
  /// The target's signed distance in the map's space; Inside and Surface need it.
  std::function<double(const Point&)> distance;
};

/// Returns a polynomial of options.count roots.
/// @throw std::invalid_argument  a number out of its domain, a placement without the distance that it needs, or a
///                               target so thin that no point was found in it
Polynomial randomPolynomial(const RandomRootsOptions& options);

}  // namespace julia
