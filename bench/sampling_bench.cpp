// SPDX-License-Identifier: Apache-2.0
// Trilinear reads a second at scattered points: OpenVDB's sampler with a leaf-caching accessor against bricks.
#include "vdbtools/grid_sampler.h"

#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <benchmark/benchmark.h>

#include <cmath>
#include <random>
#include <vector>

namespace {

constexpr std::size_t kPoints = 512;  // a batch of the evaluator
constexpr std::size_t kBatches = 512;

/// The band of a sphere of 100 voxels radius, 15 voxels to each side: the shell of alpha = 40 at 200 voxels.
openvdb::FloatGrid::Ptr shell() { return openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(100, {}, 1, 15); }

/// Points anywhere in the band, as iterates fall.
std::vector<std::vector<float>> points() {
  std::mt19937 random(1);
  std::normal_distribution<float> direction;
  std::uniform_real_distribution<float> radius(86, 114);
  std::vector<std::vector<float>> result(3);
  for (std::size_t i = 0; i < kPoints * kBatches; ++i) {
    const openvdb::Vec3f d(direction(random), direction(random), direction(random));
    const openvdb::Vec3f p = d / d.length() * radius(random);
    for (int axis = 0; axis < 3; ++axis) result[static_cast<std::size_t>(axis)].push_back(p[axis]);
  }
  return result;
}

void countReads(benchmark::State& state) {
  state.counters["reads/s"] = benchmark::Counter(static_cast<double>(state.iterations()) * static_cast<double>(kPoints),
                                                 benchmark::Counter::kIsRate);
}

void accessor(benchmark::State& state) {
  const auto grid = shell();
  const auto at = points();
  const auto reader = grid->getConstAccessor();
  std::size_t begin = 0;
  for (auto _ : state) {
    for (std::size_t i = begin; i < begin + kPoints; ++i)
      benchmark::DoNotOptimize(
          openvdb::tools::BoxSampler::sample(reader, openvdb::Vec3d(at[0][i], at[1][i], at[2][i])));
    begin = (begin + kPoints) % (kPoints * kBatches);
  }
  countReads(state);
}
BENCHMARK(accessor);

void bricks(benchmark::State& state) {
  const auto grid = shell();
  const auto at = points();
  const auto made =
      vdbtools::makeBricks(*grid, grid->evalActiveVoxelBoundingBox(),
                           state.range(0) ? julia::Interpolation::Quadratic : julia::Interpolation::Trilinear);
  julia::BrickPlacement placement;
  for (int axis = 0; axis < 3; ++axis) {
    const auto k = static_cast<std::size_t>(axis);
    placement.matrix[k][k] = 1;
    placement.offset[k] = -made.origin[axis];
    placement.low[k] = made.nodes.min()[axis] - made.origin[axis];
    placement.high[k] = made.nodes.max()[axis] - made.origin[axis];
  }
  const julia::BrickField<float> field(made.bricks, placement);
  std::vector<float> out(kPoints);
  std::size_t begin = 0;
  for (auto _ : state) {
    const auto part = [&](std::size_t axis) { return std::span(at[axis]).subspan(begin, kPoints); };
    field.sample(part(0), part(1), part(2), out);
    benchmark::DoNotOptimize(out.data());
    begin = (begin + kPoints) % (kPoints * kBatches);
  }
  countReads(state);
}
BENCHMARK(bricks)->ArgName("quadratic")->Arg(0)->Arg(1);

}  // namespace
