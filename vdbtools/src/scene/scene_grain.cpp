// SPDX-License-Identifier: Apache-2.0
#include "scene/scene_grain.h"

#include "base/elementary.h"
#include "control/control_lattice.h"
#include "search/surface_search.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/maps/direction_grids.h"
#include "vdbtools/recipe/option_value.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::FloatGrid;
using openvdb::Vec3d;

/// Vectors of a mesh at the points nearest to those asked for.
/// @param vectorAt  the vector at a point of the surface
GrainVectors vectorsOnMesh(const std::shared_ptr<const Mesh>& mesh,
                           std::function<Vec3d(const SurfacePoint& point)> vectorAt) {
  const auto search = std::make_shared<const SurfaceSearch>(mesh->points, mesh->triangles);
  return [search, vectorAt = std::move(vectorAt)](std::span<const Vec3d> points, std::span<Vec3d> vectors) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const std::optional<SurfacePoint> nearest = search->nearest(points[i]);
      vectors[i] = nearest ? vectorAt(*nearest) : Vec3d(0);
    }
  };
}

std::shared_ptr<const Mesh> requireMesh(const ControlContext& context, const GrainSettings& settings) {
  if (context.mesh) return context.mesh;
  throw DataError("--grain " + settings.text +
                  " needs the target's mesh, and the target is a VDB; give the mesh, or another grain");
}

GrainVectors attributeVectors(const GrainSettings& settings, const ControlContext& context) {
  const std::shared_ptr<const Mesh> mesh = requireMesh(context, settings);
  const std::array<const VertexAttribute*, 3> parts =
      requireVector(*mesh, settings.attribute, "--grain " + settings.text);
  return vectorsOnMesh(mesh, [mesh, parts](const SurfacePoint& point) {
    const openvdb::Vec3I& t = mesh->triangles[point.triangle];
    Vec3d vector(0);
    for (int axis = 0; axis < 3; ++axis)
      vector[axis] = interpolated(point.weights, [&](int corner) {
        return static_cast<double>(parts[static_cast<std::size_t>(axis)]->values[t[corner]]);
      });
    return vector;
  });
}

/// The direction in which a texture coordinate grows.
GrainVectors uvVectors(const GrainSettings& settings, const ControlContext& context) {
  const std::shared_ptr<const Mesh> mesh = requireMesh(context, settings);
  requireUvs(*mesh);
  return vectorsOnMesh(mesh, [mesh, which = *settings.uv](const SurfacePoint& point) {
    const openvdb::Vec3I& t = mesh->triangles[point.triangle];
    const openvdb::Vec2s* uv = &mesh->cornerUvs[3 * std::size_t{point.triangle}];
    const Vec3d a = mesh->points[t[1]] - mesh->points[t[0]], b = mesh->points[t[2]] - mesh->points[t[0]];
    const auto rise = [&](int corner) {
      return static_cast<double>(uv[corner][which]) - static_cast<double>(uv[0][which]);
    };
    // The gradient g in the triangle's plane: g.a and g.b are the rises along its edges.
    const Vec3d normal = a.cross(b);
    Vec3d gradient = rise(1) * b.cross(normal) + rise(2) * normal.cross(a);
    if (!gradient.normalize(0)) return Vec3d(0);
    return gradient;
  });
}

GrainVectors fieldVectors(const GrainSettings& settings, const ControlContext& context) {
  const DirectionGrids read = readDirectionGrids(settings.file->path, settings.grids, "--grain");
  if (read.components.size() != 3)
    throw DataError("--grain " + settings.text + " names " + std::to_string(read.components.size()) +
                    " grids; it must be a grid of vectors, or three grids of floats");
  const DirectionGrids filled = filledAbout(read, context.targetBox, "--grain");
  std::vector<Control> parts;
  for (const FloatGrid::Ptr& grid : filled.components) parts.push_back(clampedControl(grid, filled.nodes));
  return [parts](std::span<const Vec3d> points, std::span<Vec3d> vectors) {
    std::vector<double> values(points.size());
    for (int axis = 0; axis < 3; ++axis) {
      parts[static_cast<std::size_t>(axis)].sample(points, values);
      for (std::size_t i = 0; i < points.size(); ++i) vectors[i][axis] = values[i];
    }
  };
}

/// How far from the surface the shell reaches, as a multiple of the local thickness.
double reachOf(const PlacedTarget& target) {
  constexpr double kMargin = 0.1, kWhole = 1;
  if (!target.shell || !target.shell->made || !target.shell->made->options.detail) return kWhole;
  const DetailOptions& detail = *target.shell->made->options.detail;
  return std::max(detail.detail.range().second, detail.outward.range().second) + kMargin;
}

/// Everything but the target that the grids depend on. What files contain may change.
std::string keyOf(const GrainSettings& settings, const ControlSetting& frequency, const PlacedTarget& target) {
  const FractalSpace& space = target.placed.unmoved;
  std::string key;
  for (const std::string& text : {settings.text, settings.turn->text(), frequency->text()}) key += text + '\n';
  std::vector<NamedFile> files = settings.turn->files();
  for (NamedFile& file : frequency->files()) files.push_back(std::move(file));
  if (settings.file) files.push_back(*settings.file);
  for (const NamedFile& file : files) key += sha256OfFile(file.path) + '\n';
  return key + numbersText({settings.scale, slopeOf(target.shell), reachOf(target), space.scale, space.centre[0],
                            space.centre[1], space.centre[2]});
}

}  // namespace

GrainDirections grainDirectionsOf(const GrainSettings& settings, const ControlSetting& frequency, SharedTarget& shared,
                                  const PlacedTarget& target, Monitor& monitor) {
  const bool needsTarget = settings.turn->needsTarget() || frequency->needsTarget();
  const ControlContext context = controlContext(needsTarget, shared, target.placed, monitor);
  GrainOptions options{.kind = settings.kind, .towards = settings.towards};
  if (settings.uv)
    options.given = uvVectors(settings, context);
  else if (settings.file)
    options.given = fieldVectors(settings, context);
  else if (!settings.attribute.empty())
    options.given = attributeVectors(settings, context);
  options.turn = settings.turn->bind(context);
  const Control perThickness = frequency->bind(context);

  LocalThickness thickness = shared.survey(monitor).thickness(monitor, slopeOf(target.shell));
  monitor.begin(PhaseKind::Grain, 0);
  GrainSurface surface = grainSurface(*shared.survey(monitor).phi(), thickness, monitor);
  std::vector<std::complex<double>> directions = grainDirections(surface, options, monitor);

  // Without an octave, a frequency of 2 makes the lattice's waves as long as the local thickness, 2 tau.
  constexpr double kUsual = 2;
  GrainScale scale;
  if (const std::optional<double> constant = perThickness.constant())
    while (*constant / (settings.scale * std::ldexp(1., scale.octave)) > kUsual) ++scale.octave;
  std::vector<Vec3d> points(surface.graph.size());
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = Vec3d(surface.graph.position(i).data());
  std::vector<double> frequencies(points.size()), wavelength(points.size());
  perThickness.sample(points, frequencies);
  // Shorter waves than these are not resolved.
  constexpr double kVoxels = 3.2, kSpacings = 4;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!(frequencies[i] > 0 && std::isfinite(frequencies[i])))
      throw std::invalid_argument("--frequency is " + shortText(frequencies[i]) +
                                  " at a place of the target; it must be above 0 everywhere");
    const double thick = 2 * surface.thickness[i];
    const double wanted = thick * kUsual * settings.scale * std::ldexp(1., scale.octave) / frequencies[i];
    wavelength[i] = std::max({wanted, kVoxels * surface.voxel, kSpacings * surface.graph.spacing(i)});
    scale.wavelength = std::max(scale.wavelength, wavelength[i]);
  }
  return {std::move(surface), std::move(thickness), std::move(directions), std::move(wavelength), scale};
}

GrainGrids grainOf(const GrainSettings& settings, const ControlSetting& frequency, SharedTarget& shared,
                   const PlacedTarget& target, Monitor& monitor) {
  const std::string key = keyOf(settings, frequency, target);
  for (const auto& [known, grids] : shared.grains)
    if (known == key) return grids;
  const GrainDirections grain = grainDirectionsOf(settings, frequency, shared, target, monitor);
  const GrainPhases phases = grainPhases(grain.surface, grain.directions, grain.wavelength, monitor);
  GrainGrids grids = grainGrids(grain.surface, phases, grain.wavelength, reachOf(target), grain.thickness, monitor);
  setGrainScale(*grids.depth, grain.scale);
  constexpr std::size_t kMost = 4;
  if (shared.grains.size() == kMost) shared.grains.erase(shared.grains.begin());
  shared.grains.emplace_back(key, grids);
  return grids;
}

}  // namespace vdbtools
