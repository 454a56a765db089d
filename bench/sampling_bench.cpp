// SPDX-License-Identifier: Apache-2.0
// Reads a second at scattered points: OpenVDB's sampler with a leaf-caching accessor against bricks; and of bricks at
// the nodes of blocks in their order.
#include "base/grid_sampler.h"

#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace {

constexpr std::size_t kBatchPoints = 512;  // a batch of the evaluator
constexpr std::size_t kBatches = 512;

/// The band of a sphere of 100 voxels radius, 15 voxels to each side: the shell of alpha = 40 at 200 voxels.
openvdb::FloatGrid::Ptr shell() { return openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(100, {}, 1, 15); }

using Points = std::array<std::vector<float>, 3>;

/// Points anywhere in the band, as iterates fall.
Points scattered() {
  std::mt19937 random(1);
  std::normal_distribution<float> direction;
  std::uniform_real_distribution<float> radius(86, 114);
  Points result;
  for (std::size_t i = 0; i < kBatchPoints * kBatches; ++i) {
    const openvdb::Vec3f d(direction(random), direction(random), direction(random));
    const openvdb::Vec3f p = d / d.length() * radius(random);
    for (int axis = 0; axis < 3; ++axis) result[static_cast<std::size_t>(axis)].push_back(p[axis]);
  }
  return result;
}

/// Blocks of 8^3 nodes of a lattice twice as fine as the grid, as the first reads of a field at 400 voxels go.
Points inOrder() {
  const auto grid = shell();
  Points result;
  for (auto leaf = grid->tree().cbeginLeaf(); leaf && result[0].size() < kBatchPoints * kBatches; ++leaf)
    for (std::size_t i = 0; i < kBatchPoints; ++i) {
      const std::size_t node[3] = {i >> 6, i >> 3 & 7, i & 7};
      for (int axis = 0; axis < 3; ++axis)
        result[static_cast<std::size_t>(axis)].push_back(static_cast<float>(leaf->origin()[axis]) +
                                                         0.5f * static_cast<float>(node[axis]));
    }
  return result;
}

void countReads(benchmark::State& state) {
  state.counters["reads/s"] = benchmark::Counter(
      static_cast<double>(state.iterations()) * static_cast<double>(kBatchPoints), benchmark::Counter::kIsRate);
}

void accessor(benchmark::State& state) {
  const auto grid = shell();
  const Points at = scattered();
  const auto reader = grid->getConstAccessor();
  std::size_t begin = 0;
  for (auto _ : state) {
    for (std::size_t i = begin; i < begin + kBatchPoints; ++i)
      benchmark::DoNotOptimize(
          openvdb::tools::BoxSampler::sample(reader, openvdb::Vec3d(at[0][i], at[1][i], at[2][i])));
    begin = (begin + kBatchPoints) % (kBatchPoints * kBatches);
  }
  countReads(state);
}
BENCHMARK(accessor);

void readBricks(benchmark::State& state, const Points& at, julia::Interpolation interpolation) {
  const auto grid = shell();
  const auto made = vdbtools::makeBricks(*grid, grid->evalActiveVoxelBoundingBox(), interpolation);
  julia::BrickPlacement placement;
  for (int axis = 0; axis < 3; ++axis) {
    const auto k = static_cast<std::size_t>(axis);
    placement.matrix[k][k] = 1;
    placement.offset[k] = -made.origin[axis];
    placement.low[k] = made.nodes.min()[axis] - made.origin[axis];
    placement.high[k] = made.nodes.max()[axis] - made.origin[axis];
  }
  const julia::BrickField<float> field(made.bricks, placement);
  std::vector<float> out(kBatchPoints);
  std::size_t begin = 0;
  for (auto _ : state) {
    const auto part = [&](std::size_t axis) { return std::span(at[axis]).subspan(begin, kBatchPoints); };
    field.sample(part(0), part(1), part(2), out);
    benchmark::DoNotOptimize(out.data());
    begin = (begin + kBatchPoints) % at[0].size();
  }
  countReads(state);
}

void bricks(benchmark::State& state) {
  readBricks(state, scattered(), state.range(0) ? julia::Interpolation::Quadratic : julia::Interpolation::Trilinear);
}
BENCHMARK(bricks)->ArgName("quadratic")->Arg(0)->Arg(1);

void bricksInOrder(benchmark::State& state) { readBricks(state, inOrder(), julia::Interpolation::Trilinear); }
BENCHMARK(bricksInOrder);

}  // namespace
