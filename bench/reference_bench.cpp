// SPDX-License-Identifier: Apache-2.0
// What the same surface costs without any of this library's means, as the released program of [SK23] makes it: F at
// every node of the domain by the reference, one point at a time in doubles, E read through an accessor; then bisection
// along each crossing edge. That takes minutes, so a random sample is evaluated and its CPU time scaled up. Neither
// the target's distance field nor the triangles are in it.
#include "bench_scene.h"

#include "support/reference.h"

#include <openvdb/tools/Interpolation.h>

#include <benchmark/benchmark.h>

#include <cmath>
#include <random>
#include <vector>

namespace {

namespace reference = julia::reference;
using Quaternion = julia::Quaternion<double>;

constexpr std::size_t kBlocks = 400;  // whole blocks of nodes, so that reads find E in the caches as a sweep would
constexpr std::size_t kEdges = 4000;
constexpr int kToleranceEvaluations = 9;  // bisection to the job's tolerance, 1/1000 voxel
constexpr int kReleasedEvaluations = 30;  // the released program goes on until |F| < 1e-8: 26 to 33 of them

class Reference {
 public:
  explicit Reference(const vdbtools::Scene& scene)
      : mScene(scene),
        mValues(scene.exponent()->grid->getConstAccessor()),
        mMap(reference::shapeModulus<double>([this](const Quaternion& q) { return exponent(q); },
                                             *scene.field.map->roots())) {}
  Reference(const Reference&) = delete;
  Reference& operator=(const Reference&) = delete;

  /// @param index  of the lattice
  bool isInside(const openvdb::Vec3d& index) const {
    const julia::Point x = mScene.field.space.toFractal(index * mScene.voxelSize);
    const julia::OrbitOptions& orbit = mScene.field.orbit;
    const double slice = mScene.options.map->embedding().slice;
    return reference::orbit<double>(mMap, {x[0], x[1], x[2], slice}, orbit.maxIterations, orbit.escapeRadius)
               .logModulus < 0;
  }

 private:
  double exponent(const Quaternion& q) const {
    const openvdb::Vec3d world = mScene.field.space.toWorld({q.a, q.b, q.c});
    return static_cast<double>(
        openvdb::tools::BoxSampler::sample(mValues, mScene.exponent()->grid->worldToIndex(world)));
  }

  const vdbtools::Scene& mScene;
  openvdb::FloatGrid::ConstAccessor mValues;
  reference::MapFunction<double> mMap;
};

struct Sample {
  double seconds = 0, count = 0, otherSigns = 0;
  double squares = 0;  ///< of the seconds of each block
};

/// Each block that holds nodes of the domain is as likely as any other, and so is each node.
Sample sampleNodes(const bench::Job& job, const Reference& reference, std::mt19937_64& random) {
  const openvdb::CoordBBox& domain = job.plan.domain;
  const auto between = [&](int low, int high) {
    return low + static_cast<int>(random() % static_cast<std::uint64_t>(high - low + 1));
  };
  Sample sample;
  std::vector<bool> inside;
  const auto values = job.field.field->getConstAccessor();
  for (std::size_t i = 0; i < kBlocks; ++i) {
    openvdb::Coord block;
    for (int axis = 0; axis < 3; ++axis) block[axis] = between(domain.min()[axis] >> 3, domain.max()[axis] >> 3) * 8;
    openvdb::CoordBBox nodes(block, block.offsetBy(7));
    nodes.intersect(domain);
    inside.clear();
    const double begin = bench::cpuSeconds();
    for (auto node = nodes.begin(); node; ++node) inside.push_back(reference.isInside((*node).asVec3d()));
    const double seconds = bench::cpuSeconds() - begin;
    sample.seconds += seconds;
    sample.squares += seconds * seconds;
    sample.count += static_cast<double>(inside.size());
    std::size_t k = 0;
    for (auto node = nodes.begin(); node; ++node) sample.otherSigns += inside[k++] != (values.getValue(*node) < 0);
  }
  return sample;
}

Sample sampleEdges(const bench::Job& job, const Reference& reference, std::mt19937_64& random) {
  Sample sample;
  std::vector<vdbtools::LatticeEdge> edges(kEdges);
  for (vdbtools::LatticeEdge& edge : edges) edge = job.edges[random() % job.edges.size()];
  const double begin = bench::cpuSeconds();
  for (const vdbtools::LatticeEdge& edge : edges) {
    double low = 0, width = 1;
    for (int i = 0; i < kToleranceEvaluations; ++i) {
      width /= 2;
      openvdb::Vec3d index = edge.begin.asVec3d();
      index[edge.axis] += low + width;
      if (reference.isInside(index) == (edge.from < 0)) low += width;
    }
    benchmark::DoNotOptimize(low);
  }
  sample.seconds = bench::cpuSeconds() - begin;
  sample.count = static_cast<double>(kEdges);
  return sample;
}

void referenceJob(benchmark::State& state) {
  const bench::Job& job = bench::jobAt(state.range(0));
  const Reference reference(job.scene);
  std::mt19937_64 random(1);
  Sample nodes, edges;
  for (auto _ : state) {
    nodes = sampleNodes(job, reference, random);
    edges = sampleEdges(job, reference, random);
  }
  const double edgeSeconds = edges.seconds / edges.count * static_cast<double>(job.edges.size());
  state.counters["sample"] = nodes.count;
  state.counters["otherSigns"] = nodes.otherSigns;
  state.counters["nodes"] = nodes.seconds / nodes.count * static_cast<double>(job.plan.domain.volume());
  // The standard error of the blocks' mean, as a share. Blocks that the domain cuts are smaller, so it is a little
  // less.
  const double spread = kBlocks * nodes.squares / (nodes.seconds * nodes.seconds) - 1;
  state.counters["nodesError"] = std::sqrt(spread / kBlocks);
  state.counters["edges"] = edgeSeconds;
  state.counters["releasedEdges"] = edgeSeconds * kReleasedEvaluations / kToleranceEvaluations;
}
BENCHMARK(referenceJob)
    ->ArgName("N")
    ->Arg(50)
    ->Arg(100)
    ->Arg(200)
    ->Arg(400)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
