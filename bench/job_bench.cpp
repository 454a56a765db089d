// SPDX-License-Identifier: Apache-2.0
// The whole exact job, from the file of the target's mesh or distances to the last triangle, and its phases one by one.
#include "bench_scene.h"

#include "vdbtools/mesh/mesh_sink.h"

#include <benchmark/benchmark.h>

#include <optional>

namespace {

/// Drops the mesh: writing it is not what is measured.
class NoSink final : public vdbtools::MeshSink {
 public:
  void addPoints(const vdbtools::PointBatch&) override {}
  void addTriangles(std::span<const openvdb::Vec3I>, std::uint64_t) override {}
};

void once(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgName("N")->Iterations(1)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);
}

void sizes(benchmark::internal::Benchmark* benchmark) {
  once(benchmark);
  benchmark->Arg(50)->Arg(100)->Arg(200)->Arg(400)->Arg(800);
}

template <bench::Input input>
void job(benchmark::State& state) {
  vdbtools::Monitor monitor;
  std::optional<vdbtools::FractalPlan> plan;
  vdbtools::FractalResult result;
  bench::jobOptions(input, state.range(0));  // makes the file, if it is not there yet
  for (auto _ : state) {
    const vdbtools::Scene scene = makeScene(bench::jobOptions(input, state.range(0)), monitor);
    plan = planFractal(scene, {.mesh = true});
    NoSink sink;
    result = runFractal(scene, *plan, &sink, monitor);
  }
  state.counters["domain"] = static_cast<double>(plan->nodes.domain.volume());
  state.counters["planned"] = 512.0 * static_cast<double>(plan->nodes.blocks->activeVoxelCount());
  state.counters["evaluated"] = static_cast<double>(result.evaluatedNodes);
  state.counters["triangles"] = static_cast<double>(result.mesh.triangles);
}
BENCHMARK(job<bench::Input::Distances>)->Name("job")->Apply(sizes);
BENCHMARK(job<bench::Input::Mesh>)->Name("jobFromMesh")->Apply(once)->Arg(50)->Arg(400);

/// CPU seconds of each. The job works through field and surface in layers; here one is done before the other.
void phases(benchmark::State& state) {
  vdbtools::Monitor monitor;
  bench::jobOptions(bench::Input::Distances, state.range(0));
  for (auto _ : state) {
    double last = bench::cpuSeconds();
    const auto phase = [&](const char* name) {
      const double now = bench::cpuSeconds();
      state.counters[name] = now - last;
      last = now;
    };
    const vdbtools::Scene scene = makeScene(bench::jobOptions(bench::Input::Distances, state.range(0)), monitor);
    phase("scene");
    const vdbtools::FieldPlan plan = planScene(scene);
    phase("plan");
    const vdbtools::FractalField field = evaluateField(plan, scene.source(), {}, monitor);
    phase("field");
    NoSink sink;
    extractMesh(field, scene.source(), {.tolerance = scene.options.surface.tolerance, .border = vdbtools::Border::Cap},
                sink, monitor);
    phase("surface");
  }
}
BENCHMARK(phases)->Apply(sizes);

}  // namespace
