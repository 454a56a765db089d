// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/study/study.h"

#include "base/elementary.h"
#include "base/in_parallel.h"
#include "base/students_t.h"
#include "study/study_circles.h"

#include "vdbtools/base/monitor.h"
#include "vdbtools/base/text.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/mesh/mesh_sink.h"

#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace vdbtools {
namespace {

using julia::FieldEvaluator;
using julia::Point;

// Options of the job `fractal` for other maps and for checks. Those of its outputs have no effect here, and all others
// have the same meaning.
constexpr const char* kNoOptions[] = {"map", "texture", "rational", "c", "exhaustive"};

constexpr std::size_t kVersorsAtOnce = 64;  ///< evaluated before the threads meet again

std::size_t chunksOf(std::size_t count, std::size_t size) { return (count + size - 1) / size; }

/// Runs body(i, begin, end) over the chunks of 0 to @a count, each of @a size, in threads.
template <class Body>
void inChunks(std::size_t count, std::size_t size, const Monitor& monitor, const Body& body) {
  inParallel(chunksOf(count, size), 1, monitor, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i != last && !monitor.cancelled(); ++i)
      body(i, i * size, std::min(count, (i + 1) * size));
  });
}

/// Counts, for each of the points pointAt(0) to pointAt(count - 1), the number of sets that contain it.
template <class PointAt>
std::vector<int> countInside(std::size_t count, const PointAt& pointAt, const Scene& scene, int versors,
                             Monitor& monitor) {
  const VersorSeeds seeds(scene);
  const std::uint64_t firstSeed = seeds.first();
  std::vector<int> inside(count);

  // |q_1| is e^E, which does not depend on the versor, so what the first step decides holds for all versors.
  const std::unique_ptr<FieldEvaluator> first = seeds.evaluator(firstSeed);
  const std::size_t batch = first->preferredBatch();
  std::vector<std::vector<std::size_t>> openOfChunk(chunksOf(count, batch));
  monitor.begin(PhaseKind::FirstVersor, count);
  inChunks(count, batch, monitor, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    std::vector<Point> points;
    for (std::size_t i = begin; i != end; ++i) points.push_back(pointAt(i));
    std::vector<double> field(points.size());
    std::vector<int> iterations(points.size());
    first->evaluate(points, field, iterations);
    for (std::size_t k = 0; k < points.size(); ++k) {
      const bool isOpen = iterations[k] > 1;
      if (field[k] < 0) inside[begin + k] = isOpen ? 1 : versors;
      if (isOpen) openOfChunk[chunk].push_back(begin + k);
    }
    monitor.advance(points.size());
  });
  std::vector<std::size_t> open;
  for (const std::vector<std::size_t>& some : openOfChunk) open.insert(open.end(), some.begin(), some.end());

  const auto others = static_cast<std::size_t>(versors - 1);
  monitor.begin(PhaseKind::Versors, others * open.size());
  for (std::size_t done = 0; done < others; done += kVersorsAtOnce) {
    std::vector<std::unique_ptr<FieldEvaluator>> evaluators;
    for (std::size_t k = done; k < std::min(others, done + kVersorsAtOnce); ++k)
      evaluators.push_back(seeds.evaluator(firstSeed + 1 + k));
    inChunks(open.size(), batch, monitor, [&](std::size_t, std::size_t begin, std::size_t end) {
      std::vector<Point> points;
      for (std::size_t i = begin; i != end; ++i) points.push_back(pointAt(open[i]));
      std::vector<double> field(points.size());
      for (const auto& evaluator : evaluators) {
        if (monitor.cancelled()) return;
        evaluator->evaluate(points, field, {});
        for (std::size_t k = 0; k < points.size(); ++k) inside[open[begin + k]] += field[k] < 0 ? 1 : 0;
        monitor.advance(points.size());
      }
    });
  }
  return inside;
}

/// Where E lies in the open shell interval, as a range of phi.
std::optional<std::pair<double, double>> undecidedRange(const Scene& scene) {
  if (!scene.exponent() || scene.field.orbit.maxIterations == 1)
    return std::nullopt;  // the sign of E decides everything
  const ExponentGridOptions& of = scene.shellOptions();
  const std::optional<double> alpha = of.alpha.constant(), beta = of.beta.constant();
  if (of.detail || !alpha || !beta || of.mask.constant() != 1.0) return std::nullopt;
  const julia::ShellInterval& shell = scene.exponent()->shell;
  return std::pair{scene.field.space.scale * (shell.lower / *alpha + *beta),
                   scene.field.space.scale * (shell.upper / *alpha + *beta)};
}

}  // namespace

OptionTable studyOptionTable() {
  // The study's specs are taken from the whole table, which owns them.
  const OptionTable fractal = fractalOptionTable();
  std::vector<OptionSpec> options;
  // Includes all options on which others depend.
  const Recipe base = completeRecipe({{"follow", "true"}, {"box", "0,0,0,1,1,1"}}, fractal);
  const auto isOfOutputs = [&](const std::string& name) {
    return fractal.idle(name, {base, {Product::Recipe}}).empty() &&
           !fractal.idle(name, {base, {Product::Slice}}).empty();
  };
  for (const OptionSpec* spec : fractal.optionsOf({}))
    if (std::find(std::begin(kNoOptions), std::end(kNoOptions), spec->name) == std::end(kNoOptions) &&
        !isOfOutputs(spec->name))
      options.push_back(*spec);
  return OptionTable(std::move(options));
}

Study runStudy(const Scene& scene, const SlicePlane& plane, const StudyOptions& options, Monitor& monitor) {
  if (options.versors < 1 || options.versors > kMostVersors)
    throw std::invalid_argument("the number of versors is " + std::to_string(options.versors) + "; it must be 1 to " +
                                std::to_string(kMostVersors));
  const auto others = static_cast<std::uint64_t>(options.versors - 1);
  const std::uint64_t first = VersorSeeds(scene).first();
  if (first > std::numeric_limits<std::uint64_t>::max() - others)
    throw std::invalid_argument("the first seed is " + std::to_string(first) + "; " + std::to_string(options.versors) +
                                " seeds do not fit above it");
  Study study;
  study.versors = options.versors;
  study.undecided = undecidedRange(scene);
  const openvdb::FloatGrid& phi = *scene.target->distances.phi;
  study.originInside = openvdb::tools::BoxSampler::sample(phi.tree(), phi.worldToIndex(scene.field.space.centre)) < 0;
  const StudyCircles circles(plane, scene.field.space.centre);
  if (options.circles) study.circles = circles.measure(scene, monitor);

  const auto width = static_cast<std::size_t>(plane.width());
  const std::size_t pixels = width * static_cast<std::size_t>(plane.height());
  const auto pointAt = [&](std::size_t i) {
    return scene.field.space.toFractal(
        i < pixels ? plane.position(static_cast<int>(i % width), static_cast<int>(i / width))
                   : circles.position((i - pixels) / StudyCircles::kAngles, (i - pixels) % StudyCircles::kAngles));
  };
  study.inside =
      countInside(pixels + study.circles.size() * StudyCircles::kAngles, pointAt, scene, options.versors, monitor);
  for (std::size_t i = 0; i < study.circles.size(); ++i) {
    double sum = 0;
    for (std::size_t k = 0; k < StudyCircles::kAngles; ++k) sum += study.inside[pixels + i * StudyCircles::kAngles + k];
    study.circles[i].membership = sum / (static_cast<double>(StudyCircles::kAngles) * options.versors);
  }
  study.inside.resize(pixels);
  return study;
}

Image studyImage(const SlicePlane& plane, const Study& study) { return countSlice(plane, study.inside, study.versors); }

std::string studyCsv(const Study& study) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(9);
  text << "radius,mean,least,greatest,sphere_mean,membership\n";
  for (const StudyCircle& circle : study.circles)
    text << circle.radius << ',' << circle.mean << ',' << circle.least << ',' << circle.greatest << ','
         << circle.sphereMean << ',' << circle.membership << '\n';
  return text.str();
}

Plot studyPlot(const Study& study) {
  constexpr Colour kBlack{0.02F, 0.02F, 0.02F}, kSand{0.85F, 0.7F, 0.45F};
  PlotSeries mean{"mean", {}, kBlack}, least{"least, greatest", {}, kBlue};
  PlotSeries greatest{"", {}, least.colour};
  for (const StudyCircle& circle : study.circles) {
    mean.points.emplace_back(circle.radius, circle.mean);
    least.points.emplace_back(circle.radius, circle.least);
    greatest.points.emplace_back(circle.radius, circle.greatest);
  }
  Plot plot{.series = {least, greatest, mean},
            .title = "Distance over circles about the origin",
            .xLabel = "radius of the circle",
            .yLabel = "distance phi"};
  if (study.undecided) plot.band = PlotBand{"undecided", study.undecided->first, study.undecided->second, kSand};
  return plot;
}

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
