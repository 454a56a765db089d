// SPDX-License-Identifier: Apache-2.0
#include "render/field_shading.h"

#include "base/srgb.h"
#include "render/view.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace vdbtools {
namespace {

using openvdb::Vec3d;

// Phong's model, in linear RGB.
constexpr double kAmbient = 0.10, kKey = 1.00, kHead = 0.14;
constexpr double kShine = 0.22, kSharpness = 36;

/// The saturation of the colours of directions: less than that of [ZB25], where full saturation hides the shape.
constexpr double kSaturation = 0.85;

/// Differences along 13 axes: through the faces, edges and corners of a cube. Where F goes from one bound to the other
/// within a step, as it does on rough sets, three axes give only 26 different normals and smooth faces become facets.
constexpr int kAxes = 13, kNeighbours = 2 * kAxes;

const std::array<Vec3d, kAxes>& axes() {
  static const std::array<Vec3d, kAxes> all = [] {
    std::array<Vec3d, kAxes> result;
    // One of each pair of opposite nodes of a 3^3 lattice: those before its middle.
    for (int i = 0; i < kAxes; ++i)
      result[static_cast<std::size_t>(i)] = Vec3d(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1).unit();
    return result;
  }();
  return all;
}

Vec3d linearColour(const Vec3d& v) { return {linearFromSrgb(v[0]), linearFromSrgb(v[1]), linearFromSrgb(v[2])}; }

/// The components of a direction, from -1 to 1, as sRGB.
Vec3d directionColour(const Vec3d& direction) {
  Vec3d rgb;
  for (int i = 0; i < 3; ++i) rgb[i] = std::clamp(0.5 + 0.5 * kSaturation * direction[i], 0.0, 1.0);
  return linearColour(rgb);
}

/// From dark blue through green to yellow, even in lightness: five colours of viridis.
Vec3d ramp(double v) {
  static const std::array<Vec3d, 5> kStops = {Vec3d(0.267, 0.005, 0.329), Vec3d(0.230, 0.322, 0.546),
                                              Vec3d(0.128, 0.567, 0.551), Vec3d(0.369, 0.789, 0.383),
                                              Vec3d(0.993, 0.906, 0.144)};
  const double at = std::clamp(v, 0.0, 1.0) * (kStops.size() - 1);
  const std::size_t i = std::min(kStops.size() - 2, static_cast<std::size_t>(at));
  const double part = at - static_cast<double>(i);
  return linearColour((1 - part) * kStops[i] + part * kStops[i + 1]);
}

/// A field that grows outwards from the surface like a distance. F itself is a sawtooth there: it falls back wherever
/// orbits escape one step earlier, and for a map that squares, each such step doubles the distance. This field is
/// linear in F across the surface and bounded inside, where F of long orbits is noise. [ZB25] instead lets escaped
/// orbits continue to infinity.
class Potential {
 public:
  Potential(double escapeRadius, int iterations) : mTooth(std::log(escapeRadius)), mIterations(iterations) {}

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
  double iterations = 0;  ///< the mean of the points outside
};

Neighbourhood look(std::span<const double> field, std::span<const int> iterations, double escapeRadius) {
  Neighbourhood result;
  int last = 0, outside = 0;
  for (std::size_t i = 0; i < kNeighbours; ++i) {
    if (field[i] < 0) continue;
    last = std::max(last, iterations[i]);
    result.iterations += iterations[i];
    ++outside;
  }
  result.iterations /= std::max(1, outside);
  const Potential potential(escapeRadius, last);
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    const std::size_t ahead = 2 * axis, behind = ahead + 1;
    const double rise = potential(field[ahead], iterations[ahead]) - potential(field[behind], iterations[behind]);
    result.gradient += rise * axes()[axis];
  }
  return result;
}

std::vector<Neighbourhood> neighbourhoods(const julia::FieldEvaluator& evaluator, double escapeRadius,
                                          std::span<const FieldHit> hits) {
  std::vector<julia::Point> points;
  points.reserve(kNeighbours * hits.size());
  for (const FieldHit& hit : hits) {
    for (const Vec3d& axis : axes()) {
      for (const double step : {hit.step, -hit.step}) {
        const Vec3d x = hit.inside + step * axis;
        points.push_back({x[0], x[1], x[2]});
      }
    }
  }
  std::vector<double> field(points.size());
  std::vector<int> iterations(points.size());
  evaluator.evaluate(points, field, iterations);
  std::vector<Neighbourhood> result;
  for (std::size_t i = 0; i < points.size(); i += kNeighbours)
    result.push_back(
        look(std::span(field).subspan(i, kNeighbours), std::span(iterations).subspan(i, kNeighbours), escapeRadius));
  return result;
}

std::vector<Vec3d> colours(const julia::FieldEvaluator& evaluator, const FieldRenderOptions& options,
                           std::span<const FieldHit> hits, const std::vector<Neighbourhood>& around) {
  std::vector<Vec3d> result(hits.size(), kClay);
  std::vector<julia::Point> points;
  for (const FieldHit& hit : hits) points.push_back({hit.inside[0], hit.inside[1], hit.inside[2]});
  switch (options.colour) {
    case FieldColour::Clay: break;
    case FieldColour::Iterations:
      for (std::size_t i = 0; i < hits.size(); ++i)
        result[i] = ramp(around[i].iterations / options.orbit.maxIterations);
      break;
    case FieldColour::Trap: {
      std::vector<double> nearest(hits.size());
      evaluator.orbitTraps(points, nearest);
      for (std::size_t i = 0; i < hits.size(); ++i) result[i] = ramp(std::exp(nearest[i]));
      break;
    }
    case FieldColour::Direction:
    case FieldColour::Versor: {
      std::vector<julia::Quaternion<double>> versors(hits.size());
      evaluator.versors(points, versors);
      for (std::size_t i = 0; i < hits.size(); ++i) {
        const julia::Quaternion<double>& u = versors[i];
        const julia::Point inSpace = julia::Embedding{.dropped = options.dropAxis}.point(u);
        result[i] =
            directionColour(options.colour == FieldColour::Versor ? Vec3d(u.b, u.c, u.d) : Vec3d(inSpace.data()));
      }
      break;
    }
  }
  return result;
}

}  // namespace

void shadeHits(const julia::FieldEvaluator& evaluator, const FieldRenderOptions& options, const FieldLights& lights,
               std::span<const FieldHit> hits, std::span<ShadedHit> shaded) {
  const std::vector<Neighbourhood> around = neighbourhoods(evaluator, options.orbit.escapeRadius, hits);
  const std::vector<Vec3d> albedo = colours(evaluator, options, hits, around);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    Vec3d normal = hits[i].normal.value_or(around[i].gradient);
    if (!normal.normalize()) normal = -hits[i].view;
    double diffuse = kAmbient, shine = 0;
    const auto add = [&](const Vec3d& light, double strength) {
      const double facing = normal.dot(light);
      if (facing <= 0) return;
      diffuse += strength * facing;
      const Vec3d mirrored = 2 * facing * normal - light;
      shine += strength * std::pow(std::max(0.0, -mirrored.dot(hits[i].view)), kSharpness);
    };
    add(lights.key, kKey);
    add(lights.head, kHead);
    shaded[i] = {normal, diffuse * albedo[i] + Vec3d(kShine * shine)};
  }
}

}  // namespace vdbtools
