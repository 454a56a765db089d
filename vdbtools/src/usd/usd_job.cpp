// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/usd/usd_job.h"
#include "vdbtools/mesh_files/mesh_reader.h"

#include "base/srgb.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/frame_name.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/scene/file_axes.h"
#include "vdbtools/surface/extract_mesh.h"
#include "vdbtools/usd/usd_file.h"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <vector>

namespace vdbtools {
namespace {

namespace fs = std::filesystem;

/// USD's token for the type of a grid's values; empty if there is none.
std::string dataTypeOf(const openvdb::GridBase& grid) {
  static const std::map<std::string, std::string> words = {
      {"float", "float"},  {"double", "double"}, {"int32", "int"},  {"int64", "int64"}, {"bool", "bool"},
      {"vec3s", "float3"}, {"vec3d", "double3"}, {"vec3i", "int3"}, {"mask", "mask"},   {"string", "string"}};
  const auto found = words.find(grid.valueType());
  return found == words.end() ? std::string() : found->second;
}

std::string classOf(const openvdb::GridBase& grid) {
  switch (grid.getGridClass()) {
    case openvdb::GRID_LEVEL_SET: return "levelSet";
    case openvdb::GRID_FOG_VOLUME: return "fogVolume";
    case openvdb::GRID_STAGGERED: return "staggered";
    default: return "unknown";
  }
}

openvdb::BBoxd boxOf(const VdbFile& file) {
  openvdb::BBoxd box;
  for (const auto& grid : file.grids) {
    const openvdb::CoordBBox active = grid->evalActiveVoxelBoundingBox();
    if (active.empty()) continue;
    // Extended to the faces of the voxels.
    const openvdb::BBoxd cells(active.min().asVec3d() - 0.5, active.max().asVec3d() + 0.5);
    box.expand(grid->transform().indexToWorld(cells));
  }
  return box.empty() ? openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(0)) : box;
}

fs::path relativeTo(const fs::path& scene, const fs::path& file) {
  const fs::path folder = fs::absolute(scene).lexically_normal().parent_path();
  return fs::absolute(file).lexically_normal().lexically_relative(folder);
}

/// Refuses a file that names another unit than the options do.
void requireUnit(const UsdOptions& options, std::optional<LengthUnit> recorded, const fs::path& path) {
  agreedUnit(options.unit, recorded, path);
  if (recorded && options.metersPerUnit && *options.metersPerUnit != metresOf(*recorded))
    throw std::invalid_argument("'" + path.string() + "' says that its unit is " + nameOf(*recorded) +
                                ", which is not what --meters-per-unit says; leave that out");
}

/// @param unit  of the first frame; becomes it
void addFrame(const fs::path& path, std::optional<int> number, const UsdOptions& options, UsdScene& scene,
              std::optional<LengthUnit>& unit) {
  const VdbFile file = readVdb(path);
  std::vector<UsdField> fields;
  for (const auto& grid : file.grids) fields.push_back({grid->getName(), dataTypeOf(*grid), classOf(*grid)});
  const UpAxis up = recordedUpAxis(file.metadata);
  const std::optional<LengthUnit> recorded = recordedUnit(file.metadata);
  requireUnit(options, recorded, path);
  if (scene.frames.empty()) {
    unit = recorded;
    scene.fields = std::move(fields);
    scene.up = up;
  } else if (fields != scene.fields) {
    throw DataError("'" + path.string() +
                    "' has other grids than the first frame; make all frames with the same --grids");
  } else if (up != scene.up) {
    throw DataError("'" + path.string() + "' has " + nameOf(up) +
                    " up, unlike the first frame; make all frames with the same --up");
  } else if (recorded != unit) {
    const auto said = [](std::optional<LengthUnit> one) { return one ? nameOf(*one) : "none"; };
    throw DataError("the unit of '" + path.string() + "' is " + said(recorded) + ", and that of the first frame is " +
                    said(unit) + "; make all frames with the same --units");
  }
  scene.frames.push_back({number, relativeTo(options.scene, path), boxOf(file)});
}

/// The mesh in the axes and the unit of the scene, with normals, and with colours as linear light.
Mesh meshFor(const fs::path& path, const UsdScene& scene, std::optional<UpAxis> recorded, double scale) {
  Mesh mesh = readMesh(path);
  const UpTurn turn(recorded.value_or(scene.up), scene.up);
  for (openvdb::Vec3d& point : mesh.points) point = turn(point) * scale;
  computeNormals(mesh);
  if (lowerExtension(path) != ".glb" && lowerExtension(path) != ".gltf")
    for (VertexAttribute& attribute : mesh.attributes)
      if (attribute.name == "red" || attribute.name == "green" || attribute.name == "blue")
        for (float& value : attribute.values) value = linearFromSrgb(std::clamp(value, 0.0F, 1.0F));
  return mesh;
}

}  // namespace

UsdCounts writeUsdScene(std::ostream& stream, const UsdOptions& options, Monitor& monitor) {
  UsdScene scene{.framesPerSecond = options.framesPerSecond};
  std::optional<LengthUnit> unit;
  if (!options.vdb.empty()) {
    const bool pattern = hasFramePattern(options.vdb);
    if (pattern != !options.frames.empty())
      throw std::invalid_argument(pattern ? "'" + options.vdb +
                                                "' is the name of a sequence; say which frames, as in "
                                                "--frames 1-48"
                                          : "'" + options.vdb +
                                                "' is one file; for frames give a name such as "
                                                "name.####.vdb");
    std::vector<int> frames = options.frames;
    if (frames.empty()) frames.push_back(0);
    std::sort(frames.begin(), frames.end());
    monitor.begin(PhaseKind::Reading, frames.size());
    for (const int frame : frames) {
      const std::optional<int> number = pattern ? std::optional(frame) : std::nullopt;
      addFrame(expandFrame(options.vdb, number), number, options, scene, unit);
      monitor.advance(1);
      monitor.throwIfCancelled();
    }
  }
  Mesh mesh;
  if (options.mesh) {
    const std::map<std::string, std::string> comments = readMeshComments(*options.mesh);
    std::optional<UpAxis> recorded;
    if (comments.contains(kUpAxis)) recorded = recordedUpAxis(comments);
    if (scene.frames.empty() && recorded) scene.up = *recorded;
    const std::optional<LengthUnit> ofMesh = recordedUnit(comments);
    if (scene.frames.empty()) {
      requireUnit(options, ofMesh, *options.mesh);
      unit = ofMesh;
    }
    if (!unit) unit = options.unit;
    const double scale = unit && ofMesh ? metresOf(*ofMesh) / metresOf(*unit) : 1;
    mesh = meshFor(*options.mesh, scene, recorded, scale);
    scene.mesh = &mesh;
  }
  if (!unit) unit = options.unit;
  scene.metersPerUnit = unit ? metresOf(*unit) : options.metersPerUnit.value_or(1);
  monitor.begin(PhaseKind::Writing, 0);
  writeUsda(stream, scene);
  monitor.throwIfCancelled();
  return {scene.frames.size(), scene.fields.size(), mesh.triangles.size()};
}

}  // namespace vdbtools
