// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/job/points_job.h"

#include "base/srgb.h"
#include "job/point_attributes.h"
#include "search/spaced_points.h"
#include "surface/true_surface.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/surface/extract_mesh.h"

#include <algorithm>
#include <array>

namespace vdbtools {
namespace {

SpacedPoints spread(const Mesh& mesh, const PointsOptions& options, const SpacedPointsOptions& how, Monitor& monitor) {
  if (options.count.has_value() == options.spacing.has_value())
    throw std::invalid_argument("points need either their number or their spacing");
  return options.count ? pointsByCount(mesh, *options.count, how, monitor)
                       : pointsBySpacing(mesh, *options.spacing, how, monitor);
}

OrientedPoints withoutColumns(const SpacedPoints& spaced) {
  OrientedPoints points;
  for (const PlacedPoint& point : spaced.points) {
    points.positions.push_back(point.position);
    points.normals.push_back(point.normal);
  }
  points.spacing = spaced.spacing;
  points.reach = spaced.reach;
  points.lost = spaced.lost;
  return points;
}

const VertexAttribute* attribute(const Mesh& mesh, const char* name) {
  const auto at = std::find_if(mesh.attributes.begin(), mesh.attributes.end(),
                               [&](const VertexAttribute& one) { return one.name == name; });
  return at == mesh.attributes.end() ? nullptr : &*at;
}

/// Carries the mesh's attributes over to points in its triangles.
void carryAttributes(const Mesh& mesh, const std::vector<PlacedPoint>& placed, OrientedPoints& points) {
  const std::array<const VertexAttribute*, 3> channels = {attribute(mesh, "red"), attribute(mesh, "green"),
                                                          attribute(mesh, "blue")};
  const bool coloured = std::find(channels.begin(), channels.end(), nullptr) == channels.end();
  std::vector<const VertexAttribute*> numbers;
  if (coloured) points.columns.push_back({"Cd", ColumnKind::LinearRgb});
  for (const VertexAttribute& one : mesh.attributes) {
    if (coloured && std::find(channels.begin(), channels.end(), &one) != channels.end()) continue;
    numbers.push_back(&one);
    points.columns.push_back({one.name, ColumnKind::Number});
  }
  for (const PlacedPoint& point : placed) {
    const openvdb::Vec3I& t = mesh.triangles[point.triangle];
    const auto mixed = [&](const VertexAttribute& one, auto decode) {
      double sum = 0;
      for (int c = 0; c < 3; ++c) sum += point.weights[c] * decode(static_cast<double>(one.values[t[c]]));
      return static_cast<float>(sum);
    };
    if (coloured)
      for (const VertexAttribute* channel : channels)
        points.values.push_back(mixed(*channel, [](double code) { return linearFromSrgb(code); }));
    for (const VertexAttribute* one : numbers) points.values.push_back(mixed(*one, [](double value) { return value; }));
  }
}

}  // namespace

OrientedPoints fractalPoints(const Scene& scene, const PointsOptions& options, Monitor& monitor) {
  const Mesh mesh = fractalMesh(scene, monitor);
  const FieldSource source = scene.source();
  const double tolerance = scene.options.surface.tolerance * scene.voxelSize;
  const SpacedPoints spaced =
      spread(mesh, options, {.seed = options.seed, .move = toTrueSurface(source, scene.voxelSize, tolerance)}, monitor);
  OrientedPoints points = withoutColumns(spaced);
  if (scene.options.output.attributes.empty()) return points;
  const PointAttributes attributes(scene);
  points.columns = attributes.columns();
  points.values.resize(points.positions.size() * attributes.rowLength());
  attributes.evaluate(points.positions, points.values, monitor);
  return points;
}

OrientedPoints meshPoints(Mesh mesh, const PointsOptions& options, Monitor& monitor) {
  computeNormals(mesh);
  const SpacedPoints spaced = spread(mesh, options, {.seed = options.seed, .keepsCreases = true}, monitor);
  OrientedPoints points = withoutColumns(spaced);
  carryAttributes(mesh, spaced.points, points);
  return points;
}

}  // namespace vdbtools
