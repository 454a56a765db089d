// SPDX-License-Identifier: Apache-2.0
// Points and edges a second on a device of OpenCL, and on one core of the processor beside it: rational maps of 10 and
// of 400 roots. The device is the first graphics processor, or else the first device that can be used.
#include "julia/device/device.h"
#include "julia/random_roots.h"
#include "julia/rational_map.h"

#include <benchmark/benchmark.h>

#include <cstddef>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace {

constexpr std::size_t kPointsAtOnce = std::size_t{1} << 16;  // what a device's evaluator asks for
constexpr double kVoxel = 1. / 512;

std::shared_ptr<const julia::Device> firstDevice() {
  static const auto device = [] {
    std::string refusal;
    std::shared_ptr<const julia::Device> found;
    for (const auto& one : julia::openDevices({}, refusal))
      if (one->info().refusal.empty() && (!found || (one->info().isGpu && !found->info().isGpu))) found = one;
    return found;
  }();
  return device;
}

/// The field of a rational map of so many roots, on the device or not. Says in the state why there is none.
template <class Real>
std::unique_ptr<julia::FieldEvaluator> fieldOf(benchmark::State& state) {
  const auto roots = static_cast<int>(state.range(0));
  const bool onDevice = state.range(1) != 0;
  const julia::Rational rational{.top = julia::randomPolynomial({.seed = 1, .count = roots, .integerPowers = true})};
  auto host = julia::makeFieldEvaluator<Real>(std::make_shared<const julia::RationalMap<Real>>(rational), {},
                                              {.maxIterations = 4});
  if (!onDevice) return host;
  if (!firstDevice()) {
    state.SkipWithError("no device of OpenCL can be used");
    return nullptr;
  }
  std::string reason;
  auto there = firstDevice()->evaluator(std::move(host), reason);
  if (!reason.empty()) {
    state.SkipWithError(reason.c_str());
    return nullptr;
  }
  state.SetLabel(firstDevice()->info().name);
  return there;
}

void count(benchmark::State& state, const char* what, std::size_t each) {
  state.counters[what] = benchmark::Counter(static_cast<double>(state.iterations()) * static_cast<double>(each),
                                            benchmark::Counter::kIsRate);
}

template <class Real>
void devicePoints(benchmark::State& state) {
  const auto field = fieldOf<Real>(state);
  if (!field) return;
  std::mt19937 random(2);
  std::vector<julia::Point> points(kPointsAtOnce);
  for (julia::Point& x : points)
    for (double& c : x) c = 1.2 * (static_cast<double>(random()) / 0x1p32 - 0.5);
  std::vector<double> values(points.size());
  for (auto _ : state) {
    field->evaluate(points, values, {});
    benchmark::DoNotOptimize(values.data());
  }
  count(state, "points/s", points.size());
}

/// Edges that cross the surface, searched to a thousandth of a voxel.
template <class Real>
void deviceEdges(benchmark::State& state) {
  const auto field = fieldOf<Real>(state);
  if (!field) return;
  const julia::SearchLattice lattice{.voxelSize = kVoxel};
  std::mt19937 random(3);
  std::vector<julia::CrossedEdge> edges;
  constexpr std::size_t kEdges = std::size_t{1} << 14, kTries = 1000;
  for (std::size_t round = 0; edges.size() < kEdges && round < kTries; ++round) {
    std::vector<julia::Point> ends;
    for (std::size_t i = 0; i < kPointsAtOnce / 2; ++i) {
      julia::Point x;
      for (double& c : x) c = kVoxel * (static_cast<double>(random() % 600) - 300);
      ends.push_back(x);
      x[0] += kVoxel;
      ends.push_back(x);
    }
    std::vector<double> values(ends.size());
    field->evaluate(ends, values, {});
    for (std::size_t i = 0; i < ends.size() && edges.size() < kEdges; i += 2)
      if ((values[i] < 0) != (values[i + 1] < 0))
        edges.push_back(
            {ends[i], 0, ends[i][0] / kVoxel, julia::storedField(values[i]), julia::storedField(values[i + 1])});
  }
  if (edges.size() < kEdges) return state.SkipWithError("the surface crosses too few edges");
  std::vector<double> found(edges.size());
  for (auto _ : state) {
    field->findCrossings(edges, lattice, found);
    benchmark::DoNotOptimize(found.data());
  }
  count(state, "edges/s", edges.size());
}

BENCHMARK(devicePoints<float>)->ArgNames({"roots", "device"})->ArgsProduct({{10, 400}, {0, 1}})->UseRealTime();
BENCHMARK(devicePoints<double>)->ArgNames({"roots", "device"})->ArgsProduct({{10, 400}, {0, 1}})->UseRealTime();
BENCHMARK(deviceEdges<float>)->ArgNames({"roots", "device"})->ArgsProduct({{10, 400}, {0, 1}})->UseRealTime();
BENCHMARK(deviceEdges<double>)->ArgNames({"roots", "device"})->ArgsProduct({{10, 400}, {0, 1}})->UseRealTime();

}  // namespace
