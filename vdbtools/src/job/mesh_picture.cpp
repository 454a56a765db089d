// SPDX-License-Identifier: Apache-2.0
#include "job/mesh_picture.h"

#include "base/timed_part.h"
#include "field/block_layers.h"
#include "mesh_files/mesh_formats.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/mesh/mesh_sink.h"
#include "vdbtools/render/preview.h"
#include "vdbtools/scene/file_axes.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;

/// The mesh as if it were read from its PLY: the file rotates it, rounds its positions and colours, and welds nothing.
Mesh meshOfFile(const Scene& scene, const OutputOptions& output, Monitor& monitor) {
  requireMemoryForMesh(scene);
  const FractalPlan plan = planFractal(scene, {.mesh = true});
  Mesh mesh;
  std::vector<float> values;
  MeshCollector collector(mesh, &values);
  runFractal(scene, plan, &collector, monitor);
  MeshWriteOptions options = meshWriteOptions(meshFormat(".ply"), output, {});
  options.voxelSize = scene.voxelSize;
  options.box = meshBox(plan.nodes);
  std::ostringstream file;
  writeMesh(file, mesh, options, values);
  mesh = {};
  values = {};
  return readPly("mesh.ply", file.view());
}

/// Receives a mesh and discards it.
class NoMesh final : public MeshSink {
 public:
  void addPoints(const PointBatch&) override {}
  void addTriangles(std::span<const openvdb::Vec3I>, std::uint64_t) override {}
};

}  // namespace

void requireMeshView(const ViewOptions& view) {
  if (view.up) throw std::invalid_argument("--up X,Y,Z can be used with --preview field only; give y or z");
}

Image meshPicture(const Scene& scene, const ViewOptions& view, const Look& look, Monitor& monitor) {
  requireMeshView(view);
  const UpAxis up = view.upAxis.value_or(scene.options.output.axes.of(meshFormat(".ply")));
  const PreviewOptions picture{
      .width = view.width, .height = view.height, .samples = view.samples, .view = view.angles, .up = up, .look = look};
  return renderMeshPreview(meshOfFile(scene, scene.options.output, monitor), {.picture = picture}, monitor).beauty;
}

ShadedImage meshPicture(const Scene& scene, const PreviewOptions& picture, Monitor& monitor) {
  OutputOptions output = scene.options.output;
  output.axes.rule = UpRule::Keep;
  return renderMeshPreview(meshOfFile(scene, output, monitor), {.picture = picture, .colours = showsOwnColours(output)},
                           monitor);
}

bool showsOwnColours(const OutputOptions& output) {
  const std::optional<ColourChoice>& colour = output.attributes.colour;
  return !colour || colour->by != FieldColour::Clay;
}

double estimatedMeshSeconds(const Scene& scene, Monitor& monitor) {
  constexpr int kSamples = 8, kAround = 2;  // blocks of the plan, and the blocks around each that are made with it
  const FieldPlan plan = planScene(scene);
  const std::uint64_t blocks = plan.blocks->activeVoxelCount();
  QuietMonitor quiet(monitor);
  double seconds = 0;
  std::uint64_t made = 0, index = 0;
  const std::uint64_t step = std::max<std::uint64_t>(1, blocks / kSamples);
  // Active values are visited in an order in which neighbours are near each other.
  for (auto block = plan.blocks->cbeginValueOn(); block; ++block) {
    const std::uint64_t first = index, count = block.getVoxelCount();
    index += count;
    // The next multiple of the step, within this value.
    if ((first + step - 1) / step * step >= index) continue;
    monitor.throwIfCancelled();
    const Coord at = block.getCoord();
    const auto nodeOf = [&](int away, int within) {
      return Coord((at[0] + away) * kBlock + within, (at[1] + away) * kBlock + within,
                   (at[2] + away) * kBlock + within);
    };
    CoordBBox nodes(nodeOf(-kAround, 0), nodeOf(kAround, kBlock - 1));
    nodes.intersect(plan.window);
    const FieldPlan part = planScene(scene, nodes);
    made += part.blocks->activeVoxelCount();
    NoMesh none;
    const double start = cpuSeconds();
    try {
      streamMesh(part, scene.source(part), {.tolerance = scene.options.surface.tolerance, .border = Border::Open}, none,
                 quiet);
    } catch (const DataError&) {
      // The sample contains nothing but crumbs, which take time, too.
    }
    seconds += cpuSeconds() - start;
  }
  return made == 0 ? 0 : seconds * static_cast<double>(blocks) / static_cast<double>(made);
}

}  // namespace vdbtools
