// SPDX-License-Identifier: Apache-2.0
#include "base/elementary.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/grain/grain.h"

#include <algorithm>
#include <cmath>

namespace vdbtools {
namespace {

using Complex = std::complex<double>;
using julia::DirectionWish;
using julia::Point;
using openvdb::Vec3d;

Complex unitTangent(const Complex& z) {
  const double size = std::sqrt(std::norm(z));
  return size > 0 && std::isfinite(size) ? z / size : Complex(0);
}

/// Along limbs: the direction of least bending says along which line, and the slope of the thickness to which end.
std::vector<DirectionWish> wishesAlong(const GrainSurface& surface) {
  constexpr int kRounds = 4;        // over which bending is averaged
  constexpr double kBending = 0.3;  // the weight of a limb's bending
  constexpr double kSlope = 0.1;    // the weight of a thickness that changes by itself over its own length
  const std::vector<julia::Bending> bending = julia::bendings(surface.graph, kRounds);
  std::vector<double> logs;
  for (const double tau : surface.thickness) logs.push_back(elementary::log(tau));
  const std::vector<Complex> slopes = julia::gradients(surface.graph, logs);
  std::vector<DirectionWish> wishes(surface.graph.size());
  for (std::size_t i = 0; i < wishes.size(); ++i) {
    const double tau = surface.thickness[i];
    const double bend = std::min(1., bending[i].difference * tau);
    const Complex thinner = -slopes[i] * tau;
    const double slope = std::min(1., std::sqrt(std::norm(thinner)));
    // The sign of the slope, as far as it lies along the limb.
    Complex least = bending[i].least;
    const double agreement = (least * std::conj(unitTangent(thinner))).real();
    if (agreement < 0) least = -least;
    const double signedWeight = kSlope * slope * agreement * agreement;
    wishes[i] = {least, kBending * bend * bend, false};
    if (signedWeight > wishes[i].weight)
      wishes[i] = {unitTangent(thinner), signedWeight, true};
    else if (slope * std::abs(agreement) > 0.3)
      wishes[i].signs = true;
  }
  return wishes;
}

std::vector<DirectionWish> wishesForCurvature(const GrainSurface& surface) {
  constexpr double kWeight = 1;
  const std::vector<julia::Bending> bending = julia::bendings(surface.graph, 1);
  std::vector<DirectionWish> wishes(surface.graph.size());
  for (std::size_t i = 0; i < wishes.size(); ++i)
    wishes[i] = {bending[i].least, kWeight * std::min(1., bending[i].difference * surface.thickness[i]), false};
  return wishes;
}

std::vector<DirectionWish> wishesFor(const GrainSurface& surface, const GrainOptions& options) {
  constexpr double kWeight = 2;
  const julia::SurfaceGraph& graph = surface.graph;
  std::vector<Vec3d> points(graph.size()), vectors(graph.size(), options.towards);
  for (std::size_t i = 0; i < graph.size(); ++i) points[i] = Vec3d(graph.position(i).data());
  if (options.kind == GrainKind::Given) options.given(points, vectors);
  std::vector<DirectionWish> wishes(graph.size());
  bool any = false;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const double length = vectors[i].length();
    if (!(length > 0) || !std::isfinite(length)) continue;
    const Complex tangent = graph.tangent(i, Point{vectors[i][0], vectors[i][1], vectors[i][2]}) / length;
    wishes[i] = {unitTangent(tangent), kWeight * std::norm(tangent), true};
    any = any || wishes[i].weight > 0;
  }
  if (!any) throw DataError("the vectors for the grain have nowhere a part along the target's surface");
  return wishes;
}

}  // namespace

std::vector<Complex> grainDirections(const GrainSurface& surface, const GrainOptions& options, Monitor& monitor) {
  const julia::SurfaceGraph& graph = surface.graph;
  const bool isAlong = options.kind == GrainKind::Along || options.kind == GrainKind::Around;
  const std::vector<DirectionWish> wishes = isAlong                                ? wishesAlong(surface)
                                            : options.kind == GrainKind::Curvature ? wishesForCurvature(surface)
                                                                                   : wishesFor(surface, options);
  std::vector<Complex> field = julia::smoothDirections(graph, wishes, [&] { return monitor.cancelled(); });
  monitor.throwIfCancelled();
  std::vector<Vec3d> points(graph.size());
  for (std::size_t i = 0; i < graph.size(); ++i) points[i] = Vec3d(graph.position(i).data());
  std::vector<double> turns(graph.size());
  options.turn.sample(points, turns);
  constexpr double kRadians = 0.017453292519943295;
  for (std::size_t i = 0; i < field.size(); ++i) {
    if (!std::isfinite(turns[i])) throw DataError("--grain-turn is not finite at a place of the target");
    if (options.kind == GrainKind::Around) field[i] *= Complex(0, 1);
    if (turns[i] != 0) field[i] *= Complex(elementary::cos(turns[i] * kRadians), elementary::sin(turns[i] * kRadians));
  }
  return field;
}

}  // namespace vdbtools
