// SPDX-License-Identifier: Apache-2.0
#include "julia/random_roots.h"

#include "number_text.h"
#include "random_numbers.h"
#include "require.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace julia {
namespace {

// A target that fills less of its box than the inverse of this counts as empty.
constexpr int kMostTries = 10'000'000;
constexpr int kMostRoots = 1'000'000;
constexpr double kMostRandomPower = 1e6;
// The largest component of a root that a rational accepts; see requireFinite(const Rational&).
constexpr double kFarthest = 1e9;

void requireValid(const RandomRootsOptions& options) {
  require(options.count >= 1 && options.count <= kMostRoots,
          "the number of roots is " + std::to_string(options.count) + "; it must be 1 to 1000000");
  require(std::abs(options.minPower) <= kMostRandomPower && std::abs(options.maxPower) <= kMostRandomPower &&
              options.minPower <= options.maxPower,
          "the powers run from " + textOf(options.minPower) + " to " + textOf(options.maxPower) +
              "; give the smaller first, both within 1e6");
  require(!options.integerPowers || std::ceil(options.minPower) <= std::floor(options.maxPower),
          "there is no integer power between " + textOf(options.minPower) + " and " + textOf(options.maxPower));
  const auto isNear = [](double x) { return std::abs(x) <= kFarthest; };
  for (int axis = 0; axis < 3; ++axis) {
    require(
        isNear(options.boxMin[axis]) && isNear(options.boxMax[axis]) && options.boxMin[axis] <= options.boxMax[axis],
        "the box for the roots is empty, or not between -1e9 and 1e9");
    require(isNear(options.clusterCentre[axis]), "the centre of the cluster is not between -1e9 and 1e9");
  }
  require(isNear(options.embedding.slice),
          "slice is " + textOf(options.embedding.slice) + "; it must be between -1e9 and 1e9");
  const bool needsDistance = options.placement == RootPlacement::Inside || options.placement == RootPlacement::Surface;
  require(!needsDistance || options.distance != nullptr,
          "roots inside a target or near its surface need the target; give one, or place them in the box");
  require(options.placement != RootPlacement::Surface ||
              (options.surfaceDistance > 0 && std::isfinite(options.surfaceDistance)),
          "the distance of roots from the surface is " + textOf(options.surfaceDistance) + "; it must be above 0");
  require(options.placement != RootPlacement::Cluster ||
              (options.clusterRadius > 0 && std::isfinite(options.clusterRadius)),
          "the radius of the cluster is " + textOf(options.clusterRadius) + "; it must be above 0");
}

Point inBox(Random& random, const RandomRootsOptions& options, double margin) {
  Point x;
  for (int axis = 0; axis < 3; ++axis)
    x[axis] = random.between(options.boxMin[axis] - margin, options.boxMax[axis] + margin);
  return x;
}

template <class Accept>
Point rejectionSample(Random& random, const RandomRootsOptions& options, double margin, Accept accept) {
  for (int i = 0; i < kMostTries; ++i) {
    const Point x = inBox(random, options, margin);
    if (accept(options.distance(x))) return x;
  }
  throw std::invalid_argument("no place for a root was found in the target after " + std::to_string(kMostTries) +
                              " tries; place roots in its box, or allow a larger distance");
}

Point place(Random& random, const RandomRootsOptions& options) {
  switch (options.placement) {
    case RootPlacement::Inside: return rejectionSample(random, options, 0, [](double phi) { return phi < 0; });
    case RootPlacement::Surface:
      return rejectionSample(random, options, options.surfaceDistance,
                             [&](double phi) { return std::abs(phi) <= options.surfaceDistance; });
    case RootPlacement::Cluster: {
      Point x = options.clusterCentre;
      for (double& coordinate : x) coordinate += options.clusterRadius * random.normal();
      return x;
    }
    case RootPlacement::Box: break;
  }
  return inBox(random, options, 0);
}

}  // namespace

Polynomial randomPolynomial(const RandomRootsOptions& options) {
  requireValid(options);
  Random random(options.seed);
  Polynomial polynomial;
  for (int i = 0; i < options.count; ++i) {
    Root root;
    root.position = options.embedding.quaternion<double>(place(random, options));
    if (options.integerPowers) {
      const double low = std::ceil(options.minPower), high = std::floor(options.maxPower);
      root.power = std::min(high, low + std::floor(random.unit() * (high - low + 1)));
    } else {
      root.power = random.between(options.minPower, options.maxPower);
    }
    polynomial.roots.push_back(root);
  }
  return polynomial;
}

}  // namespace julia
