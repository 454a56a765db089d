// SPDX-License-Identifier: Apache-2.0
/// @file bench_scene.h
/// The job that the benchmarks share: a target of some 70 000 triangles, alpha = 40, ten roots of integer powers 2 to
/// 11, three iterations, distances on 200 voxels. The target is a lumpy ball with two horns that is made here, or the
/// mesh or VDB that JULIAVDB_BENCH_MESH names.
#pragma once

#include "surface/edge_search.h"

#include "vdbtools/job/fractal_job.h"

#include <cstdint>
#include <vector>

namespace bench {

/// What the job begins with. The distances are known as far as the job reads them, as in the fields that the released
/// program of [SK23] begins with.
enum class Input { Mesh, Distances };

/// The job's options at @a voxels along the target's longest side.
vdbtools::FractalOptions jobOptions(Input input, std::int64_t voxels);

/// Everything from the distances up to the search of the edges.
struct Job {
  vdbtools::Scene scene;
  vdbtools::FieldPlan plan;
  vdbtools::FractalField field;
  std::vector<vdbtools::LatticeEdge> edges;  ///< all that cross the surface, by blocks
};

/// Made once; only the last one is kept.
const Job& jobAt(std::int64_t voxels);

/// CPU time of the process, all threads, seconds.
double cpuSeconds();

}  // namespace bench
