// SPDX-License-Identifier: Apache-2.0
// One energy and its gradient, what the optimiser of [Kim15] asks for some hundred times a pass: 50^3 cells and 108
// roots, the size at which the released program was measured.
#include "chosen_instruction_set.h"

#include "julia/fit/shape_energy.h"

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstddef>
#include <random>
#include <string>
#include <vector>

namespace {

constexpr int kResolution = 50;
constexpr int kRoots = 108;
constexpr double kSide = 1.2;  // of the cube about a target whose longest side is 1

/// A ball's cells, their places and weights.
struct Cells {
  std::vector<julia::Point> places;
  std::vector<double> weights;
};

Cells ballCells() {
  Cells result;
  std::vector<julia::FitCell> cells;
  constexpr double kCell = kSide / kResolution;
  const auto middle = [](int i) { return (i + 0.5) * kCell - kSide / 2; };
  for (int x = 0; x < kResolution; ++x)
    for (int y = 0; y < kResolution; ++y)
      for (int z = 0; z < kResolution; ++z) {
        const julia::Point at{middle(x), middle(y), middle(z)};
        cells.push_back({at, static_cast<float>(std::hypot(at[0], at[1], at[2]) - 0.5)});
        result.places.push_back(at);
      }
  result.weights = julia::cellWeights(cells, julia::CellWeights::InverseDistance, kCell);
  return result;
}

/// Roots on both sides by turns.
julia::Rational rational() {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-0.5, 0.5), power(0.5, 3);
  julia::Rational result;
  for (int i = 0; i < kRoots; ++i) {
    julia::Polynomial& side = i % 2 ? result.bottom : result.top;
    side.roots.push_back({{place(random), place(random), place(random), 0}, power(random)});
  }
  return result;
}

void energy(benchmark::State& state) {
  const bench::ChosenInstructionSet set(state, state.range(1));
  if (!set) return;
  const Cells cells = ballCells();
  const julia::Rational map = rational();
  julia::ShapeEnergyOptions options;
  if (state.range(0) == 0) options.memoryLimit = 0;
  const julia::ShapeEnergy energy(cells.places, cells.weights, map, options);
  julia::RationalGradient gradient;
  for (auto _ : state) benchmark::DoNotOptimize(energy.evaluate(map, &gradient));
}
BENCHMARK(energy)
    ->ArgNames({"stored", "set"})
    ->ArgsProduct({{1, 0}, {0, 1, 2}})
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
