// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/job/fractal_job.h"

#include "mesh_files/mesh_file.h"

#include <algorithm>
#include <list>
#include <stdexcept>
#include <utility>

namespace vdbtools {
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
                const FractalFiles& files) {
  if (!result.check.failure.empty())
    throw std::logic_error("the level set fails OpenVDB's check: " + result.check.failure);
  const VdbWriteOptions options = vdbWriteOptions(scene.options.output, metadata);
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
  if (files.wantGrids()) writeGrids(scene, metadata, result, files);
  result.levels = meshes.finish();
  monitor.throwIfCancelled();
  return result;
}

void writeMadeFractal(const Scene& scene, const Recipe& recipe, const FractalResult& made, const Mesh& mesh,
                      std::span<const float> values, const FractalFiles& files, Monitor& monitor) {
  monitor.begin(PhaseKind::Writing, 0);
  const std::map<std::string, std::string> metadata = sceneMetadata(scene, recipe);
  if (files.wantGrids()) requireVdbVoxel(scene.voxelSize);
  MeshFiles meshes;
  addMeshFiles(meshes, scene, meshBox(planScene(scene)), metadata, files);
  if (files.wantGrids()) writeGrids(scene, metadata, made, files);
  meshes.addPoints({mesh.points, mesh.normals, values});
  meshes.addTriangles(mesh.triangles, 0);
  meshes.finish();
  monitor.throwIfCancelled();
}

}  // namespace vdbtools
