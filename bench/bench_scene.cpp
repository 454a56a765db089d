// SPDX-License-Identifier: Apache-2.0
#include "bench_scene.h"

#include "vdbtools/base/grids.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/sdf_job.h"
#include "vdbtools/mesh_files/mesh_writer.h"

#include "julia/instruction_set.h"

#include <benchmark/benchmark.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>
#include <string>
#include <utility>

namespace bench {
namespace {

using openvdb::Vec3d;
using openvdb::Vec3I;

constexpr int kSdfVoxels = 200;
constexpr double kBand = 24;  // voxels: alpha = 40 reads within ln(20) / 40 of the surface, and a few nodes around

const char* givenTarget() { return std::getenv("JULIAVDB_BENCH_MESH"); }

/// What the numbers depend on, for whoever prints them.
[[maybe_unused]] const bool kContext = [] {
  benchmark::AddCustomContext("target", givenTarget() ? std::filesystem::path(givenTarget()).filename().string()
                                                      : "a lumpy ball with two horns");
  benchmark::AddCustomContext("compiler", JULIAVDB_BENCH_COMPILER);
  benchmark::AddCustomContext("build", JULIAVDB_BENCH_BUILD);
  benchmark::AddCustomContext("instructions", std::string(julia::nameOf(julia::instructionSet())));
  return true;
}();

/// How far the surface is from the origin in a direction: lumps of two sizes, and horns, which make parts thin.
double radius(const Vec3d& d) {
  const double lumps = std::sin(5 * d[0] + 1) * std::sin(4 * d[1]) + 0.7 * std::sin(6 * d[2] + 2);
  const double fine = std::sin(23 * d[0]) * std::sin(19 * d[1]) * std::sin(21 * d[2]);
  double horns = 0;
  for (const Vec3d& at : {Vec3d(0.36, 0.8, 0.48), Vec3d(-0.48, 0.8, 0.36)}) horns += std::exp((d.dot(at) - 1) / 0.015);
  return 0.3 * (1 + 0.15 * lumps + 0.04 * fine + 0.8 * horns);
}

/// Rings about the y axis.
vdbtools::Mesh makeMesh() {
  constexpr unsigned kRings = 150, kSegments = 240;
  vdbtools::Mesh mesh;
  const auto add = [&](double polar, double azimuth) {
    const Vec3d d(std::sin(polar) * std::cos(azimuth), std::cos(polar), std::sin(polar) * std::sin(azimuth));
    mesh.points.push_back(d * radius(d));
  };
  add(0, 0);
  for (unsigned ring = 1; ring < kRings; ++ring)
    for (unsigned segment = 0; segment < kSegments; ++segment)
      add(std::numbers::pi * ring / kRings, 2 * std::numbers::pi * segment / kSegments);
  add(std::numbers::pi, 0);
  const auto point = [](unsigned ring, unsigned segment) {
    if (ring == 0) return 0u;
    if (ring == kRings) return 1 + (kRings - 1) * kSegments;
    return 1 + (ring - 1) * kSegments + segment % kSegments;
  };
  for (unsigned ring = 0; ring < kRings; ++ring)
    for (unsigned segment = 0; segment < kSegments; ++segment) {
      const unsigned a = point(ring, segment), b = point(ring, segment + 1);
      const unsigned c = point(ring + 1, segment), d = point(ring + 1, segment + 1);
      if (a != b) mesh.triangles.push_back(Vec3I(a, b, c));
      if (c != d) mesh.triangles.push_back(Vec3I(b, d, c));
    }
  return mesh;
}

/// A file for as long as the program runs: reading it is a part of the job.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& extension)
      : mPath(std::filesystem::temp_directory_path() / ("juliavdb_bench_" + std::to_string(getpid()) + extension)) {}
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(mPath, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  const std::filesystem::path& path() const { return mPath; }

 private:
  std::filesystem::path mPath;
};

std::filesystem::path meshFile() {
  if (givenTarget()) return givenTarget();
  static const TemporaryFile file(".ply");
  [[maybe_unused]] static const bool written = [] {
    std::ofstream stream(file.path(), std::ios::binary);
    vdbtools::writeMesh(stream, makeMesh(), {});
    return true;
  }();
  return file.path();
}

std::filesystem::path distanceFile() {
  const std::filesystem::path mesh = meshFile();
  if (vdbtools::isVdbPath(mesh)) return mesh;
  static const TemporaryFile file(".vdb");
  [[maybe_unused]] static const bool written = [&] {
    openvdb::initialize();
    vdbtools::Monitor monitor;
    const vdbtools::SdfResult sdf =
        runSdf({.input = mesh, .voxels = {.resolution = kSdfVoxels}, .band = kBand}, monitor);
    std::ofstream stream(file.path(), std::ios::binary);
    stream << vdbtools::encodeVdb({sdf.grid}, {.metadata = sdf.metadata});
    return true;
  }();
  return file.path();
}

std::vector<vdbtools::LatticeEdge> crossingEdges(const vdbtools::FractalField& field) {
  std::vector<vdbtools::LatticeEdge> edges;
  const auto values = field.field->getConstAccessor();
  for (auto leaf = field.field->tree().cbeginLeaf(); leaf; ++leaf)
    for (auto node = leaf->cbeginValueAll(); node; ++node)
      for (int axis = 0; axis < 3; ++axis) {
        const openvdb::Coord begin = node.getCoord();
        openvdb::Coord end = begin;
        ++end[axis];
        if (!field.domain.isInside(begin) || !field.domain.isInside(end)) continue;
        const float from = *node, to = values.getValue(end);
        if ((from < 0) != (to < 0)) edges.push_back({begin, axis, from, to});
      }
  return edges;
}

}  // namespace

vdbtools::FractalOptions jobOptions(Input input, std::int64_t voxels) {
  const vdbtools::Recipe recipe{{"input", (input == Input::Mesh ? meshFile() : distanceFile()).string()},
                                {"resolution", std::to_string(voxels)},
                                {"sdf-resolution", std::to_string(kSdfVoxels)},
                                {"alpha", "40"},
                                {"crumbs", "keep"},  // the reference has no other way
                                {"texture-roots", "10"},
                                {"texture-powers", "2:11"},
                                {"texture-integer", "true"},
                                {"iterations", "3"}};
  return vdbtools::parseFractalOptions(vdbtools::completeRecipe(recipe, vdbtools::fractalOptionTable()));
}

const Job& jobAt(std::int64_t voxels) {
  static std::unique_ptr<Job> job;
  static std::int64_t last = 0;
  if (last == voxels) return *job;
  job.reset();
  vdbtools::Monitor monitor;
  job = std::make_unique<Job>(Job{.scene = makeScene(jobOptions(Input::Distances, voxels), monitor)});
  job->plan = planScene(job->scene);
  job->field = evaluateField(job->plan, job->scene.source(), {}, monitor);
  job->edges = crossingEdges(job->field);
  last = voxels;
  return *job;
}

double cpuSeconds() {
  std::timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace bench
