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

/// The direction in which a surface extends most.
Vec3d longAxis(const julia::SurfaceGraph& graph) {
  Vec3d middle(0);
  double area = 0;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const double part = graph.spacing(i) * graph.spacing(i);
    middle += part * Vec3d(graph.position(i).data());
    area += part;
  }
  middle /= area;
  openvdb::Mat3d spread = openvdb::Mat3d::zero();
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const Vec3d off = Vec3d(graph.position(i).data()) - middle;
    const double part = graph.spacing(i) * graph.spacing(i) / area;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column) spread[row][column] += part * off[row] * off[column];
  }
  // Squared again and again, its rows turn to the axis; the largest of them is it.
  for (int times = 0; times < 12; ++times) {
    double size = 0;
    for (int row = 0; row < 3; ++row) size += spread[row][row];
    if (!(size > 0)) return Vec3d(0, 1, 0);
    spread *= 1 / size;
    spread = spread * spread;
  }
  Vec3d axis = spread.row(0);
  for (int row = 1; row < 3; ++row)
    if (spread.row(row).lengthSqr() > axis.lengthSqr()) axis = spread.row(row);
  return axis.normalize(0) ? axis : Vec3d(0, 1, 0);
}

/// A line along the sum of the squares of two tangents, which are lines of these weights.
DirectionWish meanLine(const Complex& one, double weight, const Complex& other, double otherWeight) {
  const Complex square = weight * one * one + otherWeight * other * other;
  const double half = elementary::atan2(square.imag(), square.real()) / 2;
  return {{elementary::cos(half), elementary::sin(half)}, std::sqrt(std::norm(square)), false};
}

/// Along limbs: the direction of least bending says along which line, and the slope of the thickness to which end. On
/// round bodies, where neither says much, the axis of the whole target decides.
std::vector<DirectionWish> wishesAlong(const GrainSurface& surface) {
  constexpr int kRounds = 6;        // over which bending is averaged
  constexpr double kBending = 0.5;  // the weight of a limb's bending
  constexpr double kAxis = 0.1;     // the weight of the axis where it lies in the surface
  constexpr double kSigned = 0.3;   // the slope of the thickness from which on it says to which end
  const std::vector<julia::Bending> bending = julia::bendings(surface.graph, kRounds);
  std::vector<double> logs;
  for (const double tau : surface.thickness) logs.push_back(elementary::log(tau));
  const std::vector<Complex> slopes = julia::gradients(surface.graph, logs);
  const Vec3d axis = longAxis(surface.graph);
  std::vector<DirectionWish> wishes(surface.graph.size());
  for (std::size_t i = 0; i < wishes.size(); ++i) {
    const double tau = surface.thickness[i];
    const double bend = std::min(1., bending[i].difference * tau);
    const Complex axial = surface.graph.tangent(i, Point{axis[0], axis[1], axis[2]});
    wishes[i] = meanLine(bending[i].least, kBending * bend * bend, axial, kAxis);
    const double thinner = -tau * (wishes[i].towards * std::conj(slopes[i])).real();
    if (thinner < 0) wishes[i].towards = -wishes[i].towards;
    wishes[i].signs = std::abs(thinner) > kSigned;
    wishes[i].lean = std::min(1., std::abs(thinner));
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
