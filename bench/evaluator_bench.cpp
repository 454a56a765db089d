// SPDX-License-Identifier: Apache-2.0
// Root evaluations a second of the plain evaluator, and of the reference beside it in the same run.
#include "julia/evaluator.h"
#include "julia/random_roots.h"
#include "julia/rational_map.h"
#include "julia/reference.h"

#include <benchmark/benchmark.h>

#include <random>
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

template <class Real>
void versors(benchmark::State& state) {
  const julia::Rational rational = versor(state.range(0) != 0);
  const auto evaluator = julia::makeFieldEvaluator<Real>(std::make_shared<julia::RationalMap<Real>>(rational), {}, {});
  const std::vector<julia::Point> at = points();
  std::vector<julia::Quaternion<double>> out(at.size());
  for (auto _ : state) {
    evaluator->versors(at, out);
    benchmark::DoNotOptimize(out.data());
  }
  countRoots(state, rational.top.roots.size());
}
BENCHMARK(versors<float>)->ArgName("integer")->Arg(0)->Arg(1);
BENCHMARK(versors<double>)->ArgName("integer")->Arg(0)->Arg(1);

void reference(benchmark::State& state) {
  const julia::Rational rational = versor(state.range(0) != 0);
  const std::vector<julia::Point> at = points();
  for (auto _ : state)
    for (const julia::Point& x : at)
      benchmark::DoNotOptimize(julia::reference::evaluate<double>(rational.top, {x[0], x[1], x[2], 0}));
  countRoots(state, rational.top.roots.size());
}
BENCHMARK(reference)->ArgName("integer")->Arg(0)->Arg(1);

}  // namespace
