// SPDX-License-Identifier: Apache-2.0
// The search of vertices on the edges of the job's own field: as it is done, and by plain bisection with the same
// evaluator.
#include "bench_scene.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <span>

namespace {

using vdbtools::LatticeEdge;

constexpr std::size_t kBatch = 1024;         // about what the job searches together: the edges of eight blocks
constexpr std::size_t kMostEdges = 1 << 17;  // batches are taken evenly from all

class CountingEvaluator final : public julia::FieldEvaluator {
 public:
  explicit CountingEvaluator(const julia::FieldEvaluator& evaluator) : mEvaluator(evaluator) {}
  void evaluate(std::span<const julia::Point> points, std::span<double> field,
                std::span<int> iterations) const override {
    mCount += points.size();
    mEvaluator.evaluate(points, field, iterations);
  }
  void versors(std::span<const julia::Point> points, std::span<julia::Quaternion<double>> versors) const override {
    mEvaluator.versors(points, versors);
  }
  void orbitTraps(std::span<const julia::Point> points, std::span<double> nearest) const override {
    mEvaluator.orbitTraps(points, nearest);
  }
  std::uint64_t count() const { return mCount; }

 private:
  const julia::FieldEvaluator& mEvaluator;
  mutable std::atomic<std::uint64_t> mCount{0};
};

std::vector<openvdb::Vec3d> bisectEdges(const std::vector<LatticeEdge>& edges, double voxelSize,
                                        const vdbtools::FieldSource& source, double tolerance) {
  std::vector<double> low(edges.size(), 0), field(edges.size());
  std::vector<julia::Point> points(edges.size());
  const auto worldAt = [&](std::size_t i, double t) {
    openvdb::Vec3d index = edges[i].begin.asVec3d();
    index[edges[i].axis] += t;
    return index * voxelSize;
  };
  double width = 1;
  for (; width > 2 * tolerance; width /= 2) {
    for (std::size_t i = 0; i < edges.size(); ++i) points[i] = source.space.toFractal(worldAt(i, low[i] + width / 2));
    source.evaluator.evaluate(points, field, {});
    for (std::size_t i = 0; i < edges.size(); ++i)
      if ((field[i] < 0) == (edges[i].from < 0)) low[i] += width / 2;
  }
  std::vector<openvdb::Vec3d> found(edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) found[i] = worldAt(i, low[i] + width / 2);
  return found;
}

template <auto search>
void edges(benchmark::State& state) {
  const bench::Job& job = bench::jobAt(state.range(0));
  const double tolerance = std::pow(10, -static_cast<double>(state.range(1)));
  const std::size_t batches = (job.edges.size() + kBatch - 1) / kBatch;
  const std::size_t stride = std::max<std::size_t>(1, batches * kBatch / kMostEdges);
  const CountingEvaluator evaluator(*job.scene.field.evaluator);
  const vdbtools::FieldSource source{evaluator, job.scene.field.space};
  std::vector<LatticeEdge> batch;
  std::size_t searched = 0;
  for (auto _ : state)
    for (std::size_t first = 0; first < job.edges.size(); first += stride * kBatch) {
      const auto begin = job.edges.begin() + static_cast<std::ptrdiff_t>(first);
      batch.assign(begin, begin + static_cast<std::ptrdiff_t>(std::min(kBatch, job.edges.size() - first)));
      benchmark::DoNotOptimize(search(batch, job.scene.voxelSize, source, tolerance));
      searched += batch.size();
    }
  if (evaluator.count() == 0) state.SkipWithError("no edge was searched");
  state.counters["edges"] = static_cast<double>(job.edges.size());
  state.counters["evaluations"] = static_cast<double>(evaluator.count()) / static_cast<double>(searched);
  state.counters["each"] =
      benchmark::Counter(static_cast<double>(searched), benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
// The tolerance is 10^-digits of a voxel.
BENCHMARK(edges<vdbtools::searchEdges>)
    ->Name("edges/itp")
    ->ArgNames({"N", "digits"})
    ->ArgsProduct({{50, 200}, {3, 6}})
    ->Unit(benchmark::kMillisecond);
BENCHMARK(edges<bisectEdges>)
    ->Name("edges/bisection")
    ->ArgNames({"N", "digits"})
    ->ArgsProduct({{50, 200}, {3, 6}})
    ->Unit(benchmark::kMillisecond);

}  // namespace
