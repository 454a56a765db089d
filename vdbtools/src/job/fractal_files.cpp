// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/job/fractal_files.h"

#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/mesh/mesh_file.h"

#include <list>
#include <stdexcept>

namespace vdbtools {
namespace {

/// One mesh into several files.
class MeshFiles final : public MeshSink {
 public:
  void add(AtomicFile& file, const MeshWriteOptions& options) { mFiles.emplace_back(file, options); }

  void addPoints(std::span<const openvdb::Vec3d> points, std::span<const openvdb::Vec3s> normals) override {
    for (MeshFile& file : mFiles) file.addPoints(points, normals);
  }
  void addTriangles(std::span<const openvdb::Vec3I> triangles, std::uint64_t firstPoint) override {
    for (MeshFile& file : mFiles) file.addTriangles(triangles, firstPoint);
  }
  void finish() {
    for (MeshFile& file : mFiles) file.finish();
  }

 private:
  std::list<MeshFile> mFiles;
};

}  // namespace

FractalResult writeFractal(const Scene& scene, const Recipe& recipe, const FractalFiles& files, Monitor& monitor) {
  if (!files.vdb && files.meshes.empty()) throw std::invalid_argument("no file was given for the fractal");
  const FieldPlan plan = planScene(scene);
  const std::map<std::string, std::string> metadata = sceneMetadata(scene, recipe);
  MeshFiles meshes;
  for (const FractalMeshFile& mesh : files.meshes)
    meshes.add(*mesh.file,
               {.format = mesh.format, .voxelSize = scene.voxelSize, .box = meshBox(plan), .comments = metadata});
  FractalResult result =
      runFractal(scene, plan, files.vdb != nullptr, files.meshes.empty() ? nullptr : &meshes, monitor);
  monitor.begin("writing", 0);
  if (files.vdb) {
    if (!result.check.failure.empty())
      throw std::logic_error("the level set fails OpenVDB's check: " + result.check.failure);
    files.vdb->stream() << encodeVdb(result.grids, {.half = scene.options.output.half, .metadata = metadata});
  }
  meshes.finish();
  monitor.throwIfCancelled();
  return result;
}

}  // namespace vdbtools
