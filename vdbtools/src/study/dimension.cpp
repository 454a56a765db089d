// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/study/study.h"

#include "base/elementary.h"
#include "base/students_t.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/base/text.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/mesh/mesh_sink.h"

#include <cmath>
#include <stdexcept>

namespace vdbtools {
namespace {

class NoMesh final : public MeshSink {
 public:
  void addPoints(const PointBatch&) override {}
  void addTriangles(std::span<const openvdb::Vec3I>, std::uint64_t) override {}
};

}  // namespace

std::vector<GrowthRow> measureGrowth(FractalOptions options, std::span<const int> resolutions, Monitor& monitor) {
  SceneMaker scenes;
  std::vector<GrowthRow> rows;
  for (const int resolution : resolutions) {
    NumberedMonitor numbered(monitor, "resolution", rows.size() + 1, resolutions.size());
    options.lattice.automatic = false;
    options.lattice.voxels = {.resolution = resolution};
    const Scene scene = scenes.make(options, numbered);
    NoMesh sink;
    const FractalResult result = runFractal(scene, planFractal(scene, {.mesh = true}), &sink, numbered);
    monitor.throwIfCancelled();
    rows.push_back({resolution, result.mesh.triangles, result.mesh.points, result.evaluatedNodes});
  }
  return rows;
}

PowerLaw fitPowerLaw(std::span<const std::pair<double, double>> points) {
  const auto count = static_cast<double>(points.size());
  if (points.size() < 3)
    throw std::invalid_argument("a power law was to be fitted to " + std::to_string(points.size()) +
                                " points; its error needs at least three");
  std::vector<std::pair<double, double>> logs;
  double meanX = 0, meanY = 0;
  for (const auto& [x, y] : points) {
    if (!(x > 0 && y > 0))
      throw std::invalid_argument("a power law was to be fitted to " + shortText(x) + ", " + shortText(y) +
                                  "; both must be above 0");
    logs.emplace_back(elementary::log(x), elementary::log(y));
    meanX += logs.back().first / count;
    meanY += logs.back().second / count;
  }
  double xx = 0, xy = 0;
  for (const auto& [x, y] : logs) {
    xx += (x - meanX) * (x - meanX);
    xy += (x - meanX) * (y - meanY);
  }
  if (!(xx > 0)) throw std::invalid_argument("a power law was to be fitted to points at one place; give others");
  PowerLaw law;
  law.exponent = xy / xx;
  law.factor = elementary::exp(meanY - law.exponent * meanX);
  double residuals = 0;
  for (const auto& [x, y] : logs) {
    const double residual = y - meanY - law.exponent * (x - meanX);
    residuals += residual * residual;
  }
  law.standardError = std::sqrt(residuals / (count - 2) / xx);
  const double reach = law.standardError * studentsT95(static_cast<int>(points.size()) - 2);
  law.interval = {law.exponent - reach, law.exponent + reach};
  return law;
}

PowerLaw growthLaw(std::span<const GrowthRow> rows) {
  std::vector<std::pair<double, double>> points;
  for (const GrowthRow& row : rows) points.emplace_back(row.resolution, static_cast<double>(row.triangles));
  return fitPowerLaw(points);
}

}  // namespace vdbtools
