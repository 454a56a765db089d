// SPDX-License-Identifier: Apache-2.0
#include "job/scene_colouring.h"

#include "target/clamped_control.h"
#include "target/solid_input.h"

#include <cmath>
#include <stdexcept>
#include <utility>

namespace vdbtools {
namespace {

/// World units.
std::pair<double, double> depthRange(const Scene& scene) {
  constexpr double kShare = 0.05;  // of the target's longest side
  const double usual = kShare * longestSide(scene.target->box);
  if (!scene.exponent) return {-usual, usual};
  const ExponentGrid& exponent = *scene.exponent;
  // E = alpha (phi - beta), and the surface lies where E is within the interval of the shell.
  const double scale = exponent.space.scale, alpha = exponent.alphaRange.first;
  const double low = scale * (exponent.shell.lower / alpha + exponent.betaRange.first);
  const double high = scale * (exponent.shell.upper / alpha + exponent.betaRange.second);
  if (!(alpha > 0) || !std::isfinite(low) || !(high > low)) return {-usual, usual};
  return {low, high};
}

}  // namespace

FieldColouring sceneColouring(const Scene& scene, const ColourChoice& choice) {
  FieldColouring colouring = colouringOf(choice);
  if (choice.by != FieldColour::Depth) return colouring;
  if (!scene.target)
    throw std::invalid_argument("colours by depth need a target; give a mesh or a VDB, or choose other colours");
  const auto [low, high] = depthRange(scene);
  colouring.depth =
      DepthColouring{.distance = distanceControl(*scene.target), .space = scene.space, .low = low, .high = high};
  return colouring;
}

}  // namespace vdbtools
