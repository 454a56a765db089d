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
  // Along x, from points near the origin, which are inside, to points far outside, halved down to one edge.
  constexpr std::size_t kEdges = std::size_t{1} << 14;
  constexpr int kFar = 2048;
  std::mt19937 random(3);
  std::vector<julia::Point> lines(kEdges);
  for (julia::Point& x : lines)
    for (double& c : x) c = kVoxel * (static_cast<double>(random() % 300) - 150);
  std::vector<int> inside(kEdges, 0), outside(kEdges, kFar);
  std::vector<double> values(kEdges), ends(kEdges);
  const auto evaluateAt = [&](const auto& index, std::vector<double>& to) {
    for (std::size_t i = 0; i < kEdges; ++i) lines[i][0] = kVoxel * index(i);
    field->evaluate(lines, to, {});
  };
  for (int length = kFar; length > 1; length /= 2) {
    const auto middle = [&](std::size_t i) { return (inside[i] + outside[i]) / 2; };
    evaluateAt(middle, values);
    for (std::size_t i = 0; i < kEdges; ++i) (values[i] < 0 ? inside : outside)[i] = middle(i);
  }
  evaluateAt([&](std::size_t i) { return outside[i]; }, ends);
  evaluateAt([&](std::size_t i) { return inside[i]; }, values);
  std::vector<julia::CrossedEdge> edges;
  for (std::size_t i = 0; i < kEdges; ++i) {
    if (!(values[i] < 0) || ends[i] < 0) return state.SkipWithError("a line does not cross the surface");
    edges.push_back(
        {lines[i], 0, static_cast<double>(inside[i]), julia::storedField(values[i]), julia::storedField(ends[i])});
  }
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
