// SPDX-License-Identifier: Apache-2.0
// What it costs to ask for the sign of F over balls, beside the evaluation of as many points in the same shell.
#include "base/grid_sampler.h"

#include "julia/brick_field.h"
#include "julia/evaluator.h"
#include "julia/random_roots.h"
#include "julia/shape_modulus.h"

#include <openvdb/tools/LevelSetSphere.h>

#include <benchmark/benchmark.h>

#include <cmath>
#include <memory>
#include <random>
#include <vector>

namespace {

constexpr std::size_t kBalls = 512;
constexpr double kVoxels = 200;  // along a unit of space

struct Setting {
  std::shared_ptr<const julia::BrickField<float>> field;
  std::unique_ptr<julia::FieldEvaluator> evaluator;
  std::vector<julia::Point> centres;  ///< where E is from -3 to 3
};

/// A ball of radius 3/8 at @a alpha, ten roots.
Setting setting(double alpha, bool integers) {
  const double width = 4 / alpha * kVoxels;
  const auto grid = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(
      0.375f * float(kVoxels), {}, 1, static_cast<float>(std::min(width, 0.37 * kVoxels)));
  for (auto value = grid->beginValueAll(); value; ++value) value.setValue(static_cast<float>(*value * alpha / kVoxels));
  openvdb::CoordBBox nodes(openvdb::Coord(-int(width) - 80), openvdb::Coord(int(width) + 80));
  const auto made = vdbtools::makeBricks(*grid, nodes, julia::Interpolation::Trilinear);
  julia::BrickPlacement placement;
  for (int axis = 0; axis < 3; ++axis) {
    const auto k = static_cast<std::size_t>(axis);
    placement.matrix[k][k] = kVoxels;
    placement.offset[k] = -made.origin[axis];
    placement.low[k] = made.nodes.min()[axis] - made.origin[axis];
    placement.high[k] = made.nodes.max()[axis] - made.origin[axis];
  }
  Setting result;
  result.field = std::make_shared<julia::BrickField<float>>(made.bricks, placement);
  const julia::Rational versor{.top = julia::randomPolynomial({.integerPowers = integers})};
  result.evaluator = julia::makeFieldEvaluator<float>(
      std::make_shared<julia::ShapeModulus<float>>(result.field, versor, julia::DropAxis::K), {}, {});
  std::mt19937 random(1);
  std::normal_distribution<double> direction;
  std::uniform_real_distribution<double> exponent(-3, 3);
  for (std::size_t i = 0; i < kBalls; ++i) {
    const openvdb::Vec3d d = openvdb::Vec3d(direction(random), direction(random), direction(random));
    const openvdb::Vec3d x = d * (std::max(0.01, 0.375 + exponent(random) / alpha) / d.length());
    result.centres.push_back({x[0], x[1], x[2]});
  }
  return result;
}

void countEach(benchmark::State& state) {
  state.counters["each"] = benchmark::Counter(static_cast<double>(state.iterations()) * static_cast<double>(kBalls),
                                              benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

/// @param state  alpha, whether powers are whole, the radius in thousandths
void decide(benchmark::State& state) {
  const Setting at = setting(static_cast<double>(state.range(0)), state.range(1) != 0);
  std::vector<julia::Decision> decisions(kBalls);
  at.evaluator->decide({at.centres.data(), 1}, 0, {decisions.data(), 1});  // makes the pyramid
  for (auto _ : state) {
    at.evaluator->decide(at.centres, static_cast<double>(state.range(2)) / 1000, decisions);
    benchmark::DoNotOptimize(decisions.data());
  }
  countEach(state);
}
BENCHMARK(decide)->ArgNames({"alpha", "integer", "radius"})->ArgsProduct({{6, 40}, {0, 1}, {2, 8}});

void evaluate(benchmark::State& state) {
  const Setting at = setting(static_cast<double>(state.range(0)), state.range(1) != 0);
  std::vector<double> field(kBalls);
  for (auto _ : state) {
    at.evaluator->evaluate(at.centres, field, {});
    benchmark::DoNotOptimize(field.data());
  }
  countEach(state);
}
BENCHMARK(evaluate)->ArgNames({"alpha", "integer"})->ArgsProduct({{6, 40}, {0, 1}});

/// The bricks' extremes alone, which the first ball waits for.
void pyramid(benchmark::State& state) {
  for (auto _ : state) {
    state.PauseTiming();
    const Setting at = setting(static_cast<double>(state.range(0)), false);
    state.ResumeTiming();
    benchmark::DoNotOptimize(at.field->range({0, 0, 0}, 0));
  }
}
BENCHMARK(pyramid)->ArgName("alpha")->Arg(40)->Iterations(5)->Unit(benchmark::kMillisecond);

}  // namespace
