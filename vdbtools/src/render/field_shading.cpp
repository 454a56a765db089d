// SPDX-License-Identifier: Apache-2.0
#include "render/field_shading.h"

#include "base/elementary.h"
#include "render/neighbourhood.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace vdbtools {
namespace {

using openvdb::Vec3d;

/// A field that grows outwards from the surface like a distance. F itself is a sawtooth there: it falls back wherever
/// orbits escape one step earlier, and for a map that squares, each such step doubles the distance. This field is
/// linear in F across the surface and bounded inside, where F of long orbits is noise. [ZB25] instead continues escaped
/// orbits to infinity.
class Potential {
 public:
  Potential(double escapeRadius, int iterations) : mTooth(elementary::log(escapeRadius)), mIterations(iterations) {}

  double operator()(double field, int iterations) const {
    constexpr int kMostDoublings = 60;
    const double level = std::clamp(field / mTooth, -1.0, 1.0);
    if (level < 0) return level;
    return std::ldexp(1 + level, std::min(mIterations - iterations, kMostDoublings)) - 1;
  }

 private:
  double mTooth;
  int mIterations;
};

struct Neighbourhood {
  Vec3d gradient{0};
  double iterations = 0;  ///< mean over the points outside
};

Neighbourhood look(std::span<const double> field, std::span<const int> iterations, double escapeRadius) {
  Neighbourhood result{.iterations = meanIterationsOutside(field, iterations)};
  int last = 0;
  for (std::size_t i = 0; i < kNeighbours; ++i)
    if (!(field[i] < 0)) last = std::max(last, iterations[i]);
  const Potential potential(escapeRadius, last);
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    const std::size_t ahead = 2 * axis, behind = ahead + 1;
    const double rise = potential(field[ahead], iterations[ahead]) - potential(field[behind], iterations[behind]);
    result.gradient += rise * neighbourAxes()[axis];
  }
  return result;
}

std::vector<Neighbourhood> neighbourhoods(double escapeRadius, std::span<const double> field,
                                          std::span<const int> iterations) {
  std::vector<Neighbourhood> result;
  for (std::size_t i = 0; i < field.size(); i += kNeighbours)
    result.push_back(look(field.subspan(i, kNeighbours), iterations.subspan(i, kNeighbours), escapeRadius));
  return result;
}

std::vector<Vec3d> colours(const julia::FieldEvaluator& evaluator, const FieldRenderOptions& options,
                           std::span<const FieldHit> hits, const std::vector<Neighbourhood>& around) {
  std::vector<julia::Point> points;
  for (const FieldHit& hit : hits) points.push_back({hit.inside[0], hit.inside[1], hit.inside[2]});
  std::vector<double> iterations;
  for (const Neighbourhood& neighbourhood : around) iterations.push_back(neighbourhood.iterations);
  return fieldColours(options.colour, evaluator,
                      {.maxIterations = options.orbit.maxIterations, .dropAxis = options.dropAxis}, points, iterations);
}

}  // namespace

FieldAround fieldAround(const julia::FieldEvaluator& evaluator, std::span<const FieldHit> hits) {
  std::vector<julia::Point> centres;
  std::vector<double> distances;
  for (const FieldHit& hit : hits) {
    centres.push_back({hit.inside[0], hit.inside[1], hit.inside[2]});
    distances.push_back(hit.step);
  }
  FieldAround around{std::vector<double>(kNeighbours * hits.size()), std::vector<int>(kNeighbours * hits.size())};
  evaluator.evaluateAround(centres, distances, neighbourDirections(), around.field, around.iterations);
  return around;
}

std::vector<FieldPoint> fieldPoints(const julia::FieldEvaluator& evaluator, const FieldRenderOptions& options,
                                    std::span<const FieldHit> hits, std::span<const double> field,
                                    std::span<const int> iterations) {
  const std::vector<Neighbourhood> around = neighbourhoods(options.orbit.escapeRadius, field, iterations);
  std::vector<Vec3d> albedo;
  if (options.colour.by != FieldColour::Clay) albedo = colours(evaluator, options, hits, around);
  std::vector<FieldPoint> result(hits.size());
  for (std::size_t i = 0; i < hits.size(); ++i) {
    Vec3d normal = hits[i].normal.value_or(around[i].gradient);
    if (!normal.normalize()) normal = -hits[i].view;
    result[i].normal = normal;
    if (!albedo.empty()) result[i].albedo = albedo[i];
  }
  return result;
}

}  // namespace vdbtools
