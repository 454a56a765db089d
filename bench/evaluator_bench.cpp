// SPDX-License-Identifier: Apache-2.0
// Root evaluations a second of the kernels, and of the reference beside them in the same run; steps a second of the
// maps of R^3.
#include "chosen_instruction_set.h"

#include "julia/cross_map.h"
#include "julia/embedding.h"
#include "julia/evaluator.h"
#include "julia/mandelbulb.h"
#include "julia/quaternion_batch.h"
#include "julia/random_roots.h"
#include "julia/rational_map.h"
#include "support/reference.h"

#include <benchmark/benchmark.h>

#include <memory>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace {

constexpr std::size_t kPoints = 512;  // a block of the fractal field

std::vector<julia::Point> points() {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-0.6, 0.6);
  std::vector<julia::Point> result(kPoints);
  for (julia::Point& x : result) x = {place(random), place(random), place(random)};
  return result;
}

julia::Rational versor(bool integer) {
  return {.top = julia::randomPolynomial({.seed = 1, .count = 10, .integerPowers = integer})};
}

void countRoots(benchmark::State& state, std::size_t roots) {
  state.counters["roots/s"] = benchmark::Counter(
      static_cast<double>(state.iterations()) * static_cast<double>(kPoints * roots), benchmark::Counter::kIsRate);
}

/// The kernel alone: structure of arrays in and out.
template <class Real>
void versors(benchmark::State& state) {
  const bench::ChosenInstructionSet set(state, state.range(1));
  if (!set) return;
  const julia::Rational rational = versor(state.range(0) != 0);
  const julia::RationalEvaluator<Real> evaluator(rational);
  julia::QuaternionBatch<Real> q, u;
  const std::vector<julia::Point> at = points();
  q.resize(at.size());
  for (std::size_t i = 0; i < at.size(); ++i) q.set(i, julia::Embedding{}.quaternion<Real>(at[i]));
  for (auto _ : state) {
    evaluator.versor(q, u);
    benchmark::DoNotOptimize(u.a.data());
  }
  countRoots(state, rational.top.roots.size());
}
BENCHMARK(versors<float>)->ArgNames({"integer", "set"})->ArgsProduct({{0, 1}, {0, 1, 2}});
BENCHMARK(versors<double>)->ArgNames({"integer", "set"})->ArgsProduct({{0, 1}, {0, 1, 2}});

void referenceOfRational(benchmark::State& state) {
  const julia::Rational rational = versor(state.range(0) != 0);
  const std::vector<julia::Point> at = points();
  for (auto _ : state)
    for (const julia::Point& x : at)
      benchmark::DoNotOptimize(julia::reference::evaluate<double>(rational.top, {x[0], x[1], x[2], 0}));
  countRoots(state, rational.top.roots.size());
}
BENCHMARK(referenceOfRational)->Name("reference")->ArgName("integer")->Arg(0)->Arg(1);

/// Whole orbits, ten steps at most.
void orbits(benchmark::State& state, std::shared_ptr<const julia::CartesianMap<double>> map) {
  const auto evaluator =
      julia::makeFieldEvaluator<double>(std::move(map), {}, {.maxIterations = 10, .escapeRadius = 2});
  const std::vector<julia::Point> at = points();
  std::vector<double> field(at.size());
  std::vector<int> steps(at.size());
  for (auto _ : state) {
    evaluator->evaluate(at, field, steps);
    benchmark::DoNotOptimize(field.data());
  }
  state.counters["steps/s"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * std::accumulate(steps.begin(), steps.end(), 0.),
                         benchmark::Counter::kIsRate);
}
void cross(benchmark::State& state, const julia::CrossOptions& options) {
  orbits(state, std::make_shared<julia::CrossMap<double>>(options));
}
void mandelbulb(benchmark::State& state, double power) {
  orbits(state, std::make_shared<julia::Mandelbulb<double>>(julia::MandelbulbOptions{.power = power}));
}
BENCHMARK_CAPTURE(cross, A, {.pair = julia::CrossPair::A});
BENCHMARK_CAPTURE(cross, C, {.pair = julia::CrossPair::C});
BENCHMARK_CAPTURE(cross, user, {.pair = julia::CrossPair::User, .f = "x*x, y*y, z*z", .g = "cos(x), cos(y), cos(z)"});
BENCHMARK_CAPTURE(mandelbulb, whole, 8);
BENCHMARK_CAPTURE(mandelbulb, real, 8.5);

}  // namespace
