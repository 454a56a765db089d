// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/job/fractal_job.h"

#include "base/elementary.h"
#include "field/block_layers.h"
#include "job/output_grids.h"
#include "job/point_attributes.h"
#include "mesh_files/mesh_file.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/decimation/adaptive_mesh.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/file_formats.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh/mesh_sink.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/scene/fractal_options.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>
#include <fstream>
#include <list>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

namespace vdbtools {

using openvdb::FloatGrid;

namespace {

/// Suggests what to try if the set is empty.
std::string wayOut(const Scene& scene) {
  if (scene.options.lattice.box)
    return scene.exponent() ? "another box, or less detail" : "another box, or other constants";
  if (!scene.exponent()) return "other constants, or another box";
  return scene.shellOptions().detail ? "less detail, a larger outward reach, or smaller voxels"
                                     : "a larger beta, a larger alpha, or smaller voxels";
}

/// Prepares a mesh on its way to a sink: adds attributes to its points, and reduces the triangles of flat regions.
class MeshOutput {
 public:
  MeshOutput(const Scene& scene, const PointAttributes* attributes, MeshSink& sink, const Monitor& monitor)
      : mSink(&sink) {
    if (attributes) mSink = &mAttributed.emplace(*attributes, *mSink, monitor);
    const double adaptivity = scene.options.surface.adaptivity;
    if (adaptivity > 0) mSink = &mAdaptive.emplace(*mSink, adaptivity * scene.voxelSize);
  }

  MeshSink& sink() { return *mSink; }

  /// @param counts  set to the numbers of points and triangles that have reached the sink, if the mesh was adapted
  void finish(MeshCounts& counts, Monitor& monitor) {
    if (!mAdaptive) return;
    mAdaptive->finish(monitor);
    counts.points = mAdaptive->pointsAfter();
    counts.triangles = mAdaptive->trianglesAfter();
  }

 private:
  MeshSink* mSink;
  std::optional<AttributedSink> mAttributed;
  std::optional<AdaptiveMeshSink> mAdaptive;
};

/// @param triangles  number of triangles in the mesh
void requireSurface(const Scene& scene, const FractalResult& result, std::uint64_t triangles) {
  if (triangles > 0) return;
  if (result.crumbs) requireMoreThanCrumbs(*result.crumbs);
  throw DataError("the fractal is empty here: the field changes sign nowhere in the region; try " + wayOut(scene),
                  scene.exponent() ? Remedy::LargerBeta : Remedy::None);
}

/// Calls @a make with a sink for the mesh, and measures the solid in the mesh.
/// @param output  receives the mesh; nullptr: no mesh is requested
template <class Make>
void meshInto(const Scene& scene, const FractalPlan& plan, MeshOutput* output, FractalResult& result,
              const Make& make) {
  SolidMeter meter(output ? &output->sink() : nullptr);
  result.mesh = make(ExtractMeshOptions{.tolerance = scene.options.surface.tolerance, .border = plan.border}, meter);
  if (plan.border == Border::Cap || !scene.options.lattice.box) result.solid = meter.measure();
}

/// A lower bound of the number of lattice lines along an axis that meet the set, averaged over the three axes; 0 if
/// nothing is known.
double leastShadow(const Scene& scene) {
  // A box may cut the set off.
  if (!scene.exponent() || scene.options.lattice.box) return 0;
  double nodes = 0;
  const FloatGrid& exponent = *scene.exponent()->grid;
  for (auto value = exponent.cbeginValueAll(); value; ++value)
    if (*value <= scene.exponent()->shellOfNodes.lower) nodes += static_cast<double>(value.getVoxelCount());
  const double volume = nodes * std::abs(exponent.transform().voxelSize().product());
  // The part that is surely inside has a volume V, and V^2 is at most the product of its three shadows (Loomis and
  // Whitney), whose sum is therefore at least 3 V^(2/3). V is counted in nodes, and those at the surface represent some
  // volume outside.
  constexpr double kSure = 0.8;
  return kSure * elementary::cbrt(volume * volume) / (scene.voxelSize * scene.voxelSize);
}

/// @throw MemoryError  the band of the level set will not fit
void requireMemoryForLevelSet(const Scene& scene) {
  // A column of blocks that the set meets has a block of the band where a line enters and one where it leaves.
  const double blocks = 2 * leastShadow(scene) / (kBlock * kBlock);
  requireMemory(
      kBytesOfFloatLeaf * blocks, MemoryUse::Field,
      "a level set of more than " + std::to_string(static_cast<std::uint64_t>(blocks)) + " blocks of 8^3 nodes");
}

/// Makes the mesh, the level set, or both, layer by layer.
void makeStreamed(const Scene& scene, const FractalPlan& plan, const PointAttributes* attributes, MeshOutput* output,
                  FractalResult& result, Monitor& monitor) {
  if (!plan.grids.empty()) requireMemoryForLevelSet(scene);
  const FieldSource source = scene.source(plan.nodes);
  FloatGrid::Ptr surface;
  meshInto(scene, plan, output, result, [&](const ExtractMeshOptions& options, MeshSink& sink) {
    if (plan.grids.empty()) return streamMesh(plan.nodes, source, options, sink, monitor);
    StreamedSurface streamed = streamSurface(plan.nodes, source, options.tolerance, output != nullptr, sink, monitor);
    surface = streamed.levelSet;
    return streamed.mesh;
  });
  result.evaluatedNodes = result.mesh.evaluatedNodes;
  result.crumbs = result.mesh.crumbs;
  requireSurface(scene, result, result.mesh.triangles);
  if (output) output->finish(result.mesh, monitor);
  if (!surface) return;
  result.check = checkSurface(*surface);
  result.grids = outputGrids(plan.grids, {.surface = surface, .source = &source, .attributes = attributes}, monitor);
  if (!output) result.mesh = {};
}

/// Makes the level set, and the mesh from which its distances are measured.
/// @param output  receives that mesh; nullptr: no mesh is requested
FloatGrid::Ptr makeLevelSet(const Scene& scene, const FractalPlan& plan, const FractalField& field, MeshOutput* output,
                            FractalResult& result, Monitor& monitor) {
  CappedMesh capped = extractCappedMesh(field, scene.source(plan.nodes), scene.options.surface.tolerance, monitor);
  requireSurface(scene, result, capped.mesh.triangles.size());
  FloatGrid::Ptr surface = levelSet(field, capped.mesh, monitor);
  result.solid = measureSolid(capped.mesh);
  result.check = checkSurface(*surface);
  if (!output) return surface;
  Mesh mesh = plan.border == Border::Cap ? std::move(capped.mesh) : withoutCaps(std::move(capped));
  requireSurface(scene, result, mesh.triangles.size());
  computeNormals(mesh);
  output->sink().addPoints({mesh.points, mesh.normals});
  output->sink().addTriangles(mesh.triangles, 0);
  result.mesh = {mesh.points.size(), mesh.triangles.size()};
  return surface;
}

/// @param output  receives the mesh; nullptr: no mesh is requested
void makeInMemory(const Scene& scene, const FractalPlan& plan, const PointAttributes* attributes, MeshOutput* output,
                  FractalResult& result, Monitor& monitor) {
  const EvaluateFieldOptions evaluate = plan.grids.evaluation();
  const FieldSource source = scene.source(plan.nodes);
  const std::optional<FollowOptions>& follow = scene.options.lattice.follow;
  FractalField field = follow ? followSurface(plan.nodes, source, evaluate, *follow, result.follow.emplace(), monitor)
                              : evaluateField(plan.nodes, source, evaluate, monitor);
  result.evaluatedNodes = field.evaluatedNodes;
  result.crumbs = field.crumbs;
  if (dropsIslands(scene.options)) result.islands = dropIslands(field, scene.options.surface.islands, monitor);
  FloatGrid::Ptr surface;
  if (plan.grids.needsLevelSet()) {
    surface = makeLevelSet(scene, plan, field, output, result, monitor);
  } else if (output) {
    meshInto(scene, plan, output, result, [&](const ExtractMeshOptions& options, MeshSink& sink) {
      return extractMesh(field, source, options, sink, monitor);
    });
    requireSurface(scene, result, result.mesh.triangles);
  }
  if (output) output->finish(result.mesh, monitor);
  result.grids = outputGrids(
      plan.grids, {.surface = surface, .field = &field, .source = &source, .attributes = attributes}, monitor);
}

}  // namespace

void requireMoreThanCrumbs(const CrumbReport& dropped) {
  if (dropped.crumbs == 0) return;
  throw DataError("the fractal has nothing but crumbs here: " + std::to_string(dropped.crumbs) +
                      (dropped.crumbs == 1 ? " piece" : " pieces") + " of at most " + std::to_string(kCrumb) +
                      " voxels along each axis; use smaller voxels, or keep them",
                  Remedy::KeepCrumbs);
}

FractalPlan planFractal(const Scene& scene, const FractalProducts& wanted) {
  FractalPlan plan{.nodes = planScene(scene), .mesh = wanted.mesh};
  if (wanted.grids) plan.grids = planGrids(scene.options.output);
  plan.border = scene.options.surface.cap || !plan.nodes.bounded ? Border::Cap : Border::Open;
  // Distances are those to the mesh with its caps.
  const bool needsField = plan.grids.has(OutputGrid::LogModulus) || plan.grids.has(OutputGrid::Iterations) ||
                          (!plan.grids.empty() && plan.border == Border::Open);
  if (needsField || dropsIslands(scene.options) || scene.options.lattice.follow) plan.way = FractalPlan::Way::InMemory;
  return plan;
}

FractalResult runFractal(const Scene& scene, const FractalPlan& plan, MeshSink* sink, Monitor& monitor) {
  if (plan.mesh != (sink != nullptr)) throw std::invalid_argument("a mesh needs a sink, and a sink a mesh");
  FractalResult result;
  std::optional<PointAttributes> attributes;
  if (!scene.options.output.attributes.empty()) attributes.emplace(scene, plan.nodes.origin);
  const PointAttributes* const wanted = attributes ? &*attributes : nullptr;
  const openvdb::Vec3d offset = latticeOffset(scene.options, scene.voxelSize) + plan.nodes.origin;
  std::optional<MovedMeshSink> moved;
  if (sink && offset != openvdb::Vec3d(0)) sink = &moved.emplace(offset, *sink);
  std::optional<MeshOutput> output;
  if (sink) output.emplace(scene, wanted, *sink, monitor);
  if (plan.way == FractalPlan::Way::InMemory) {
    makeInMemory(scene, plan, wanted, output ? &*output : nullptr, result, monitor);
  } else if (output || !plan.grids.empty()) {
    makeStreamed(scene, plan, wanted, output ? &*output : nullptr, result, monitor);
  }
  moveGrids(result.grids, offset);
  return result;
}

void requireMemoryForMesh(const Scene& scene) {
  // The mesh is adapted, and flat regions may need few triangles.
  if (scene.options.surface.adaptivity > 0) return;
  // Each line of a shadow crosses the surface twice, along each of the three axes, and a point lies at each crossing.
  const double points = 2 * 3 * leastShadow(scene);
  // A closed surface has two triangles for each point.
  constexpr double kBytes = sizeof(openvdb::Vec3d) + sizeof(openvdb::Vec3s) + 2 * sizeof(openvdb::Vec3I);
  requireMemory(points * kBytes, MemoryUse::Field,
                "a mesh of more than " + std::to_string(static_cast<std::uint64_t>(points)) + " points");
}

Mesh fractalMesh(const Scene& scene, Monitor& monitor) {
  requireMemoryForMesh(scene);
  Mesh mesh;
  MeshCollector collector(mesh);
  runFractal(scene, planFractal(scene, {.mesh = true}), &collector, monitor);
  return mesh;
}

namespace {

/// Passes one mesh to several files.
class MeshFiles final : public MeshSink {
 public:
  void add(AtomicFile& file, const MeshWriteOptions& options) { mFiles.emplace_back(file, options); }

  void addPoints(const PointBatch& batch) override {
    for (MeshFile& file : mFiles) file.addPoints(batch);
  }
  void addTriangles(std::span<const openvdb::Vec3I> triangles, std::uint64_t firstPoint) override {
    for (MeshFile& file : mFiles) file.addTriangles(triangles, firstPoint);
  }
  /// @return the levels of detail of the file that has most of them
  std::vector<MeshLevel> finish() {
    std::vector<MeshLevel> levels;
    for (MeshFile& file : mFiles) {
      file.finish();
      if (file.levels().size() > levels.size()) levels = file.levels();
    }
    return levels;
  }

 private:
  std::list<MeshFile> mFiles;
};

void writeGrids(const Scene& scene, const std::map<std::string, std::string>& metadata, const FractalResult& result,
                const FractalFiles& files, std::vector<ClampedGrid>* clamped) {
  if (!result.check.failure.empty())
    throw std::logic_error("the level set fails OpenVDB's check: " + result.check.failure);
  VdbWriteOptions options = vdbWriteOptions(scene.options.output, metadata);
  options.clamped = clamped;
  for (const FractalFile& wanted : files.files) {
    if (!wanted.format->writesGrids) continue;
    std::vector<NvdbWritten> written =
        vdbtools::writeGrids(wanted.file->stream(), *wanted.format, result.grids, options, files.nvdb);
    if (files.nvdbReport && wanted.format->nvdbBits) *files.nvdbReport = std::move(written);
  }
}

/// Adds to @a meshes the mesh files of @a files, for a mesh that lies in @a box.
void addMeshFiles(MeshFiles& meshes, const Scene& scene, const openvdb::BBoxd& box,
                  const std::map<std::string, std::string>& metadata, const FractalFiles& files) {
  if (files.files.empty()) throw std::invalid_argument("no file was given for the fractal");
  for (const FractalFile& mesh : files.files) {
    if (!mesh.format->writesMesh) continue;
    MeshWriteOptions options = meshWriteOptions(*mesh.format, scene.options.output, metadata);
    options.voxelSize = scene.voxelSize;
    options.box = box;
    meshes.add(*mesh.file, options);
  }
}

bool anyIs(const FractalFiles& files, bool FileFormat::*fact) {
  return std::any_of(files.files.begin(), files.files.end(),
                     [&](const FractalFile& file) { return file.format->*fact; });
}

}  // namespace

bool FractalFiles::wantGrids() const { return anyIs(*this, &FileFormat::writesGrids); }

bool FractalFiles::wantMesh() const { return anyIs(*this, &FileFormat::writesMesh); }

VdbWriteOptions vdbWriteOptions(const OutputOptions& output, std::map<std::string, std::string> metadata) {
  VdbWriteOptions options = vdbWriteOptions(output.axes, std::move(metadata));
  options.half = output.half;
  options.names = output.gridNames;
  options.metadata.merge(distanceGridMetadata(output.gridNames, "surface"));
  return options;
}

MeshWriteOptions meshWriteOptions(const FileFormat& format, const OutputOptions& output,
                                  std::map<std::string, std::string> metadata) {
  MeshWriteOptions options = meshWriteOptions(format, output.axes, std::move(metadata));
  options.columns = meshColumns(output.attributes);
  options.levels = output.levels;
  return options;
}

FractalResult writeFractal(const Scene& scene, const Recipe& recipe, const FractalFiles& files, Monitor& monitor) {
  const FractalPlan plan = planFractal(scene, {.grids = files.wantGrids(), .mesh = files.wantMesh()});
  const std::map<std::string, std::string> metadata = sceneMetadata(scene, recipe);
  if (files.wantGrids()) requireVdbVoxel(scene.voxelSize);
  MeshFiles meshes;
  addMeshFiles(meshes, scene, meshBox(plan.nodes), metadata, files);
  FractalResult result = runFractal(scene, plan, plan.mesh ? &meshes : nullptr, monitor);
  monitor.begin(PhaseKind::Writing, 0);
  if (files.wantGrids()) writeGrids(scene, metadata, result, files, &result.clamped);
  result.levels = meshes.finish();
  monitor.throwIfCancelled();
  return result;
}

std::vector<ClampedGrid> writeMadeFractal(const Scene& scene, const Recipe& recipe, const FractalResult& made,
                                          const Mesh& mesh, std::span<const float> values, const FractalFiles& files,
                                          Monitor& monitor) {
  monitor.begin(PhaseKind::Writing, 0);
  const std::map<std::string, std::string> metadata = sceneMetadata(scene, recipe);
  if (files.wantGrids()) requireVdbVoxel(scene.voxelSize);
  MeshFiles meshes;
  addMeshFiles(meshes, scene, meshBox(planScene(scene)), metadata, files);
  std::vector<ClampedGrid> clamped;
  if (files.wantGrids()) writeGrids(scene, metadata, made, files, &clamped);
  meshes.addPoints({mesh.points, mesh.normals, values});
  meshes.addTriangles(mesh.triangles, 0);
  meshes.finish();
  monitor.throwIfCancelled();
  return clamped;
}

namespace {

/// Whether a file ends with a complete line. A line that was cut off may still be valid, such as a number without its
/// last digits.
bool endsWithItsLine(const std::filesystem::path& path) {
  std::ifstream file = openToRead(path);
  file.seekg(-1, std::ios::end);
  return file.get() == '\n';
}

}  // namespace

bool holdsFractal(const std::filesystem::path& path, const Recipe& recipe) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;
  const auto isTheRecipe = [&](const std::map<std::string, std::string>& metadata) {
    const std::map<std::string, std::string> expected = recipeToMetadata(recipe, "fractal");
    const bool hasAll = std::all_of(expected.begin(), expected.end(), [&](const auto& entry) {
      const auto found = metadata.find(entry.first);
      return found != metadata.end() && found->second == entry.second;
    });
    return hasAll && recipeFromMetadata(metadata, fractalOptionTable()) == recipe;
  };
  try {
    const FileFormat* const format = findFormat(path.native());
    if (!format || !format->recipe || (format->endsUnmarked && !endsWithItsLine(path))) return false;
    // The recipe stands at the beginning: it tells most other files before the rest is read.
    if (!isTheRecipe(readFileTexts(path))) return false;
    return format->readsGrids ? !readVdb(path).grids.empty() : !readMesh(path).triangles.empty();
  } catch (const std::exception&) {
    return false;  // broken, or not made by this program
  }
}

}  // namespace vdbtools
