// SPDX-License-Identifier: Apache-2.0
#include "slice_samples.h"

#include <openvdb/tools/Interpolation.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <span>

namespace cli {
namespace {

using vdbtools::Scene;
using vdbtools::SlicePlane;

/// Calls a function for one row of pixels after another, in threads.
template <class Row>
void forEachRow(const SlicePlane& plane, vdbtools::Monitor& progress, const Row& row) {
  progress.begin(vdbtools::PhaseKind::Slice, static_cast<std::uint64_t>(plane.height()));
  tbb::parallel_for(0, plane.height(), [&](int y) {
    if (progress.cancelled()) return;
    row(y);
    progress.advance(1);
  });
  progress.throwIfCancelled();
}

std::vector<julia::Point> pointsOfRow(const SlicePlane& plane, int y, const vdbtools::FractalSpace& space) {
  std::vector<julia::Point> points;
  for (int x = 0; x < plane.width(); ++x) points.push_back(space.toFractal(plane.position(x, y)));
  return points;
}

std::size_t rowStart(const SlicePlane& plane, int y) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(plane.width());
}

/// Evaluates numbers at points of a scene, in 32 bits. @param evaluate  (points, values, number of the first one)
template <class Evaluate>
std::vector<float> sampleNumbers(const SlicePlane& plane, const Scene& scene, vdbtools::Monitor& progress,
                                 const Evaluate& evaluate) {
  std::vector<float> numbers(rowStart(plane, plane.height()));
  forEachRow(plane, progress, [&](int y) {
    const std::vector<julia::Point> points = pointsOfRow(plane, y, scene.field.space);
    std::vector<double> values(points.size());
    const std::size_t start = rowStart(plane, y);
    evaluate(points, values, start);
    std::transform(values.begin(), values.end(), numbers.begin() + static_cast<std::ptrdiff_t>(start),
                   [](double value) { return static_cast<float>(value); });
  });
  return numbers;
}

}  // namespace

std::vector<float> sampleGrid(const SlicePlane& plane, const openvdb::FloatGrid& grid, vdbtools::Monitor& progress) {
  std::vector<float> values(rowStart(plane, plane.height()));
  forEachRow(plane, progress, [&](int y) {
    const auto accessor = grid.getConstAccessor();
    for (int x = 0; x < plane.width(); ++x)
      values[rowStart(plane, y) + static_cast<std::size_t>(x)] =
          openvdb::tools::BoxSampler::sample(accessor, grid.worldToIndex(plane.position(x, y)));
  });
  return values;
}

FieldSamples sampleField(const SlicePlane& plane, const Scene& scene, vdbtools::Monitor& progress) {
  FieldSamples samples;
  samples.iterations.resize(rowStart(plane, plane.height()));
  samples.field = sampleNumbers(
      plane, scene, progress, [&](std::span<const julia::Point> points, std::span<double> values, std::size_t start) {
        scene.field.evaluator->evaluate(points, values, std::span(samples.iterations).subspan(start, points.size()));
      });
  return samples;
}

/// The evaluator of the orbit's first step alone.
std::unique_ptr<julia::FieldEvaluator> firstStep(const Scene& scene) {
  julia::OrbitOptions orbit = scene.field.orbit;
  orbit.maxIterations = 1;
  return scene.evaluator(orbit);
}

/// ln |f|.
std::vector<float> sampleFirstStep(const SlicePlane& plane, const Scene& scene, vdbtools::Monitor& progress) {
  const auto step = firstStep(scene);
  return sampleNumbers(plane, scene, progress,
                       [&](std::span<const julia::Point> points, std::span<double> values, std::size_t) {
                         step->orbitTraps(points, values);
                       });
}

std::vector<openvdb::Vec3s> sampleVersor(const SlicePlane& plane, const Scene& scene, vdbtools::Monitor& progress) {
  std::vector<openvdb::Vec3s> values(rowStart(plane, plane.height()));
  forEachRow(plane, progress, [&](int y) {
    const std::vector<julia::Point> points = pointsOfRow(plane, y, scene.field.space);
    const std::vector<openvdb::Vec3s> versors = scene.source().versorVectors(points);
    std::copy(versors.begin(), versors.end(), values.begin() + static_cast<std::ptrdiff_t>(rowStart(plane, y)));
  });
  return values;
}

}  // namespace cli
