// SPDX-License-Identifier: Apache-2.0
#include "scene/file_hashes.h"
#include "scene/scene_grain.h"
#include "vdbtools/maps/versor_options.h"
#include "vdbtools/picture/gradient.h"
#include "vdbtools/study/study.h"
#include "vdbtools/target/target_input.h"

#include "base/disjoint_sets.h"
#include "base/elementary.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <stdexcept>

namespace vdbtools {
namespace {

using Complex = std::complex<double>;
using openvdb::Vec3d;
using openvdb::Vec3I;

Vec3d vectorOf(const julia::Point& p) { return Vec3d(p.data()); }

/// Whether the directions around a point do not agree with each other.
std::vector<bool> singularPoints(const GrainDirections& grain) {
  const julia::SurfaceGraph& graph = grain.surface.graph;
  std::vector<Complex> sums(graph.size());
  std::vector<double> weights(graph.size());
  for (std::size_t e = 0; e < graph.edges().size(); ++e) {
    const auto [from, to] = graph.edges()[e];
    const double w = graph.weight(e);
    sums[to] += w * graph.transport(e) * grain.directions[from];
    sums[from] += w * std::conj(graph.transport(e)) * grain.directions[to];
    weights[from] += w;
    weights[to] += w;
  }
  constexpr double kAgreement = 0.6;
  std::vector<bool> singular(graph.size());
  for (std::size_t i = 0; i < graph.size(); ++i)
    singular[i] = weights[i] > 0 && std::sqrt(std::norm(sums[i])) < kAgreement * weights[i];
  return singular;
}

/// The share of the points where the phases' waves are as long as they should be, within a factor of 1.5.
double shareInStep(const std::vector<julia::SurfacePhase>& phases, const std::vector<double>& wavelength) {
  constexpr double kFactor = 1.5, kTurn = 6.28318530717958647693;
  std::size_t near = 0;
  for (std::size_t i = 0; i < phases.size(); ++i) {
    const double ratio = kTurn / vectorOf(phases[i].gradient).length() / wavelength[i];
    near += ratio > 1 / kFactor && ratio < kFactor;
  }
  return static_cast<double>(near) / static_cast<double>(phases.size());
}

/// Adds the parts of a drawing.
class Drawing {
 public:
  explicit Drawing(GrainStrokes& strokes) : mStrokes(strokes) {}

  void add(std::initializer_list<Vec3d> points, std::initializer_list<Vec3I> triangles, const Vec3d& colour,
           const Vec3d& direction) {
    const auto first = static_cast<std::uint32_t>(mStrokes.mesh.points.size());
    mStrokes.mesh.points.insert(mStrokes.mesh.points.end(), points);
    for (const Vec3I& t : triangles) mStrokes.mesh.triangles.emplace_back(t[0] + first, t[1] + first, t[2] + first);
    for (std::size_t i = 0; i < points.size(); ++i) addRow(colour, direction);
  }
  void add(const Mesh& mesh, const Vec3d& colour) {
    const auto first = static_cast<std::uint32_t>(mStrokes.mesh.points.size());
    mStrokes.mesh.points.insert(mStrokes.mesh.points.end(), mesh.points.begin(), mesh.points.end());
    for (const Vec3I& t : mesh.triangles)
      mStrokes.mesh.triangles.emplace_back(t[0] + first, t[1] + first, t[2] + first);
    for (std::size_t i = 0; i < mesh.points.size(); ++i) addRow(colour, Vec3d(0));
  }

 private:
  void addRow(const Vec3d& colour, const Vec3d& direction) {
    for (const Vec3d& part : {colour, direction})
      for (int axis = 0; axis < 3; ++axis) mStrokes.values.push_back(static_cast<float>(part[axis]));
  }

  GrainStrokes& mStrokes;
};

}  // namespace

GrainStrokes grainStrokes(const FractalOptions& options, Monitor& monitor) {
  openvdb::initialize();
  const std::vector<MapControl> controls = options.map->controls();
  const auto found = std::find_if(controls.begin(), controls.end(),
                                  [](const MapControl& control) { return control.kind == MapControl::Kind::Grain; });
  if (found == controls.end() || !options.target)
    throw std::invalid_argument("the fractal's texture follows no grain; give --grain, such as --grain along");
  SharedTarget shared(*options.target, openTarget, monitor);
  const PlacedTarget placed =
      placeShell(exponentSources(options, *options.map->shell(), hashesOf(options)), shared, monitor);
  const GrainDirections grain = grainDirectionsOf(*found->grain, found->control, shared, placed, monitor);
  const julia::SurfaceGraph& graph = grain.surface.graph;

  GrainStrokes strokes;
  strokes.points = graph.size();
  strokes.columns = {{"Cd", ColumnKind::LinearRgb}, {"grain", ColumnKind::Vector}};
  const auto [least, most] = std::minmax_element(grain.surface.thickness.begin(), grain.surface.thickness.end());
  strokes.thickness = {*least, *most};
  const double low = elementary::log(*least), range = std::max(elementary::log(*most) - low, 1e-9);
  const Gradient gradient;
  const std::vector<bool> singular = singularPoints(grain);
  const GrainPhases phases = grainPhases(grain.surface, grain.directions, grain.wavelength, monitor);
  strokes.inStep = {shareInStep(phases.along, grain.wavelength), shareInStep(phases.across, grain.wavelength)};
  Drawing drawing(strokes);
  if (const std::shared_ptr<const Mesh> mesh = shared.input().mesh()) drawing.add(*mesh, Vec3d(0.6));
  for (std::size_t i = 0; i < graph.size(); ++i) {
    // In spacings of the points.
    constexpr double kLength = 0.45, kWidth = 0.16, kLift = 0.15;
    const double size = graph.spacing(i);
    const Vec3d normal = vectorOf(graph.normal(i)), along = vectorOf(graph.vector(i, grain.directions[i]));
    const Vec3d aside = normal.cross(along), at = vectorOf(graph.position(i)) + normal * (kLift * size);
    const Vec3d colour = gradient.at((elementary::log(grain.surface.thickness[i]) - low) / range);
    const Vec3d tail = at - along * (kLength * size), side = aside * (kWidth * size);
    drawing.add({tail - side, tail + side, at + along * (kLength * size)}, {{0, 1, 2}}, colour, along);
  }
  DisjointSets<std::uint32_t> places(graph.size());
  for (const auto& [from, to] : graph.edges())
    if (singular[from] && singular[to]) places.join(from, to);
  for (std::uint32_t i = 0; i < graph.size(); ++i) {
    if (!singular[i] || places.find(i) != i) continue;
    ++strokes.singular;
    constexpr double kSize = 0.4;
    const double r = kSize * graph.spacing(i);
    const Vec3d at = vectorOf(graph.position(i));
    drawing.add({at + Vec3d(r, 0, 0), at - Vec3d(r, 0, 0), at + Vec3d(0, r, 0), at - Vec3d(0, r, 0),
                 at + Vec3d(0, 0, r), at - Vec3d(0, 0, r)},
                {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}},
                Vec3d(0.8, 0.02, 0.02), Vec3d(0));
  }
  return strokes;
}

}  // namespace vdbtools
