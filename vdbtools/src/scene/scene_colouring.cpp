// SPDX-License-Identifier: Apache-2.0
#include "scene/scene_colouring.h"

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/control/control.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

// What colours are spread over is the set at rest, so that a moving set keeps its colours.

const ExponentGrid* exponentAtRest(const Scene& scene) { return scene.rest ? &scene.rest->exponent : scene.exponent(); }
const Target& distancesAtRest(const Scene& scene) {
  return scene.rest ? scene.rest->distances : scene.target.value().distances;
}

/// World units.
std::pair<double, double> depthRange(const Scene& scene) {
  constexpr double kShare = 0.05;  // of the target's longest side
  const double usual = kShare * longestSide(distancesAtRest(scene).box);
  if (!exponentAtRest(scene)) return {-usual, usual};
  const ExponentGrid& exponent = *exponentAtRest(scene);
  // v = alpha (phi - beta), and the surface lies where E is within the interval of the shell.
  const double scale = exponent.space.scale, alpha = exponent.alphaRange.first;
  auto [leastBeta, mostBeta] = exponent.betaRange;
  // In a shell of detail, beta is largest where alpha is smallest.
  if (exponent.scale) leastBeta = mostBeta = std::abs(leastBeta) > std::abs(mostBeta) ? leastBeta : mostBeta;
  const double low = scale * (exponent.shellOfNodes.lower / alpha + leastBeta);
  const double high = scale * (exponent.shellOfNodes.upper / alpha + mostBeta);
  if (!(alpha > 0) || !std::isfinite(low) || !(high > low)) return {-usual, usual};
  return {low, high};
}

/// A box that contains all or nearly all of the set, world units; for a map whose region is unknown, the scene's box.
openvdb::BBoxd wholeSet(const Scene& scene) {
  if (scene.target) {
    openvdb::BBoxd box = distancesAtRest(scene).box;
    box.expand(std::max(0.0, depthRange(scene).second));
    return box;
  }
  const FractalSpace& space = scene.placed.space;
  if (const std::optional<double> radius = scene.options.map->radius())
    return {space.toWorld({-*radius, -*radius, -*radius}), space.toWorld({*radius, *radius, *radius})};
  return scene.region();
}

/// The points where lines along the axes meet the surface, on its inner side; fractal space. @param lines  per side of
/// the box
std::vector<julia::Point> placesOnSurface(const julia::FieldEvaluator& evaluator, const FractalSpace& space,
                                          const openvdb::BBoxd& box, std::size_t lines) {
  constexpr std::size_t kSteps = 128;
  constexpr int kHalvings = 20;
  constexpr double kAside = 0.382;  // of the distance between lines, so that they miss planes of symmetry
  std::vector<std::vector<julia::Point>> found(3 * lines * lines);
  tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t line) {
    const int axis = static_cast<int>(line / (lines * lines));
    const auto share = [&](std::size_t number) { return (static_cast<double>(number) + kAside) / lines; };
    openvdb::Vec3d part;
    part[(axis + 1) % 3] = share(line / lines % lines);
    part[(axis + 2) % 3] = share(line % lines);
    std::vector<julia::Point> points;
    for (std::size_t step = 0; step <= kSteps; ++step) {
      part[axis] = static_cast<double>(step) / kSteps;
      points.push_back(space.toFractal(box.min() + part * box.extents()));
    }
    std::vector<double> field(points.size());
    evaluator.evaluate(points, field, {});
    std::vector<julia::Point>& inside = found[line];
    std::vector<julia::Point> outside;
    for (std::size_t step = 0; step < kSteps; ++step) {
      if ((field[step] < 0) == (field[step + 1] < 0)) continue;
      const bool first = field[step] < 0;
      inside.push_back(points[first ? step : step + 1]);
      outside.push_back(points[first ? step + 1 : step]);
    }
    std::vector<julia::Point> middle(inside.size());
    field.resize(inside.size());
    for (int halving = 0; halving < kHalvings && !inside.empty(); ++halving) {
      for (std::size_t i = 0; i < middle.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) middle[i][k] = 0.5 * (inside[i][k] + outside[i][k]);
      evaluator.evaluate(middle, field, {});
      for (std::size_t i = 0; i < middle.size(); ++i) (field[i] < 0 ? inside : outside)[i] = middle[i];
    }
  });
  std::vector<julia::Point> all;
  for (const std::vector<julia::Point>& points : found) all.insert(all.end(), points.begin(), points.end());
  return all;
}

/// The range of the colours' numbers on the surface, without the few smallest and largest ones.
std::optional<GradientRange> occurringRange(const Scene& scene, FieldColouring colouring) {
  constexpr std::size_t kFewest = 16, kEnough = 512, kMostLines = 64;
  constexpr double kLeftOut = 0.02,
                   kNear = 1.0 / 512;  // at each end; of the longest side, as pictures have their steps
  // Uses doubles, and the space before the lattice's shift, because the voxels must not affect the result.
  const FractalSpace& space = scene.placed.space;
  const auto evaluator = scene.field.map->evaluator(Arithmetic::Double, scene.field.orbit);
  const openvdb::BBoxd box = wholeSet(scene);
  std::vector<julia::Point> points;
  for (std::size_t lines = 16; points.size() < kEnough && lines <= kMostLines; lines *= 2)
    points = placesOnSurface(*evaluator, space, box, lines);
  if (colouring.depth) {
    colouring.depth->space = space;
    colouring.depth->distance = distanceControl(distancesAtRest(scene));
  }
  std::vector<double> iterations;
  if (colouring.by == FieldColour::Iterations)
    iterations = meanIterations(*evaluator, points, kNear * longestSide(box) / space.scale);
  std::vector<double> numbers = colourNumbers(colouring, *evaluator, points, iterations);
  std::erase_if(numbers, [](double number) { return !std::isfinite(number); });
  if (numbers.size() < kFewest) return std::nullopt;
  std::sort(numbers.begin(), numbers.end());
  const auto leftOut = static_cast<std::size_t>(kLeftOut * static_cast<double>(numbers.size()));
  const GradientRange range{numbers[leftOut], numbers[numbers.size() - 1 - leftOut]};
  return range.low < range.high ? std::optional(range) : std::nullopt;
}

}  // namespace

FieldColouring sceneColouring(const Scene& scene, const ColourChoice& choice) {
  FieldColouring colouring = colouringOf(choice);
  const bool spreads =
      choice.by == FieldColour::Trap || choice.by == FieldColour::Iterations || choice.by == FieldColour::Depth;
  const auto spread = [&] {
    if (spreads && !colouring.range) colouring.range = occurringRange(scene, colouring);
    return colouring;
  };
  if (choice.by != FieldColour::Depth) return spread();
  if (!scene.target)
    throw std::invalid_argument("colours by depth need a target; give a mesh or a VDB, or choose other colours");
  const auto [low, high] = depthRange(scene);
  colouring.depth = DepthColouring{
      .distance = distanceControl(scene.target->distances), .space = scene.field.space, .low = low, .high = high};
  return spread();
}

}  // namespace vdbtools
