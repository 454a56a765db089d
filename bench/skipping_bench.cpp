// SPDX-License-Identifier: Apache-2.0
// The field with and without what spares evaluations: every node of the domain, every node of the shell's blocks, and
// the shell less what is proved. The evaluator is the same in all three.
#include "bench_scene.h"

#include <benchmark/benchmark.h>

#include <optional>

namespace {

enum Way { kEveryNode, kShell, kProofs };

struct Work {
  double reads = 0, roots = 0;
};

/// A step reads E once; all but an orbit's last one take the versor, too.
Work workOf(const vdbtools::FractalField& field, std::size_t roots) {
  Work work;
  for (auto leaf = field.iterations->tree().cbeginLeaf(); leaf; ++leaf)
    for (auto node = leaf->cbeginValueOn(); node; ++node)
      if (const double steps = static_cast<double>(*node); steps > 0) {
        work.reads += steps;
        work.roots += (steps - 1) * static_cast<double>(roots);
      }
  return work;
}

void field(benchmark::State& state) {
  const vdbtools::Scene& scene = bench::jobAt(state.range(0)).scene;
  const auto way = static_cast<Way>(state.range(1));
  vdbtools::Monitor monitor;
  const vdbtools::FractalFieldOptions lattice{.voxelSize = scene.voxelSize};
  std::optional<vdbtools::FieldPlan> plan;
  std::optional<vdbtools::FractalField> field;
  for (auto _ : state) {
    const double begin = bench::cpuSeconds();
    plan = way == kEveryNode ? planExhaustive(*scene.exponent(), lattice) : planShell(*scene.exponent(), lattice);
    state.counters["plan"] = bench::cpuSeconds() - begin;
    field = evaluateField(*plan, scene.source(), {.everyNode = way != kProofs}, monitor);
  }
  state.counters["domain"] = static_cast<double>(plan->domain.volume());
  state.counters["planned"] = 512.0 * static_cast<double>(plan->blocks->activeVoxelCount());
  state.counters["evaluated"] = static_cast<double>(field->evaluatedNodes);
  if (way == kEveryNode) return;
  field.reset();
  field = evaluateField(*plan, scene.source(), {.keepIterations = true, .everyNode = way != kProofs}, monitor);
  const Work work = workOf(*field, scene.field.map->roots()->top.roots.size());
  state.counters["reads"] = work.reads;
  state.counters["roots"] = work.roots;
}
BENCHMARK(field)
    ->ArgNames({"N", "way"})
    ->ArgsProduct({{50, 200, 400}, {kEveryNode, kShell, kProofs}})
    ->Iterations(1)
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
