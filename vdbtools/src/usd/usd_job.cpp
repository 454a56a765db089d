// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/usd/usd_job.h"

#include "base/srgb.h"

#include "usd/usd_package.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/frames.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/scene/file_axes.h"
#include "vdbtools/surface/extract_mesh.h"
#include "vdbtools/usd/usd_file.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
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

/// Refuses a file that records another unit than the options name.
void requireUnit(const UsdOptions& options, std::optional<LengthUnit> recorded, const fs::path& path) {
  agreedUnit(options.unit, recorded, path);
  if (recorded && options.metersPerUnit && *options.metersPerUnit != metresOf(*recorded))
    throw std::invalid_argument("'" + path.string() + "' says that its unit is " + nameOf(*recorded) +
                                ", which is not what --meters-per-unit says; leave that out");
}

/// @param unit  the unit of the first frame; set by it
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

/// The attributes of a mesh that become primvars: all but colours and velocities, for which USD has names of its own.
std::vector<UsdPrimvar> primvarsOf(const Mesh& mesh) {
  const auto has = [&](const std::string& name) {
    return std::any_of(mesh.attributes.begin(), mesh.attributes.end(),
                       [&](const VertexAttribute& attribute) { return attribute.name == name; });
  };
  std::set<std::string> used = {"red", "green", "blue"}, names = {"displayColor", "st"};
  std::vector<UsdPrimvar> primvars;
  const auto add = [&](std::string name, std::vector<std::string> parts) {
    used.insert(parts.begin(), parts.end());
    // A glTF's own attributes begin with an underscore.
    name = usdIdentifier(name.size() > 1 && name[0] == '_' ? name.substr(1) : name);
    while (!names.insert(name).second) name += '_';
    primvars.push_back({std::move(name), std::move(parts)});
  };
  for (const VertexAttribute& attribute : mesh.attributes) {
    const std::string& name = attribute.name;
    if (used.contains(name)) continue;
    const std::string stem = name.substr(0, name.size() - std::min<std::size_t>(name.size(), 2));
    const std::vector<std::string> vector = {stem + "_x", stem + "_y", stem + "_z"};
    if (std::all_of(vector.begin(), vector.end(), has) && name.starts_with(stem + "_") && !stem.empty()) {
      if (stem == "velocity" || stem == "VELOCITY")
        used.insert(vector.begin(), vector.end());
      else
        add(stem, vector);
    } else {
      add(name, {name});
    }
  }
  return primvars;
}

/// The meshes of a scene. Reads each of them as often as the scene asks for it, and keeps the last one.
class MeshReader {
 public:
  /// Reads all of them once. @param number  of the frame, if there are frames
  /// @param unit  the scene's unit, if it is known; set to the first mesh's unit if there is no VDB
  void add(const fs::path& path, std::optional<int> number, const UsdOptions& options, UsdScene& scene,
           std::optional<LengthUnit>& unit) {
    const std::map<std::string, std::string> comments = readMeshTexts(path);
    std::optional<UpAxis> recorded;
    if (comments.contains(kUpAxis)) recorded = recordedUpAxis(comments);
    if (mEntries.empty() && scene.frames.empty() && recorded) scene.up = *recorded;
    const std::optional<LengthUnit> ofMesh = recordedUnit(comments);
    if (scene.frames.empty()) {
      requireUnit(options, ofMesh, path);
      if (mEntries.empty()) unit = ofMesh;
    }
    if (!unit) unit = options.unit;
    const double scale = unit && ofMesh ? metresOf(*ofMesh) / metresOf(*unit) : 1;
    mEntries.push_back({.path = path, .recorded = recorded, .scale = scale});
    mEntries.back().triangles = read(mEntries.size() - 1, scene.up).triangles.size();
    mEntries.back().points = mMesh.points.size();
    const bool hasColours = std::count_if(mMesh.attributes.begin(), mMesh.attributes.end(), isColour) == 3;
    if (mEntries.size() > 1 && hasColours != mMeshes.hasColours)
      throw DataError("'" + path.string() + "' has " + (hasColours ? "" : "no ") +
                      "colours, unlike the first frame; make all frames in the same way");
    mMeshes.hasColours = hasColours;
    const bool hasVelocities = velocitiesOf(mMesh)[0] != nullptr;
    if (mEntries.size() > 1 && hasVelocities != mMeshes.hasVelocities)
      throw DataError("'" + path.string() + "' has " + (hasVelocities ? "" : "no ") +
                      "velocities, unlike the first frame; make all frames in the same way");
    mMeshes.hasVelocities = hasVelocities;
    mMeshes.hasUvs = (mEntries.size() == 1 || mMeshes.hasUvs) && !mMesh.cornerUvs.empty();
    const std::vector<UsdPrimvar> primvars = primvarsOf(mMesh);
    if (mEntries.size() == 1)
      mMeshes.primvars = primvars;
    else
      std::erase_if(mMeshes.primvars, [&](const UsdPrimvar& primvar) {
        return std::find(primvars.begin(), primvars.end(), primvar) == primvars.end();
      });
    mMeshes.hasNormals = true;
    mMeshes.frames.push_back(number);
    mMeshes.boxes.push_back(boundingBox(mMesh));
  }

  /// The meshes for the scene, whose up axis is now known. This object must outlive the scene.
  UsdMeshes meshes(UpAxis up) {
    UsdMeshes meshes = mMeshes;
    meshes.at = [this, up](std::size_t index) -> const Mesh& {
      if (index == mIndex) return mMesh;
      const Entry& entry = mEntries[index];
      if (read(index, up).triangles.size() != entry.triangles || mMesh.points.size() != entry.points)
        throw DataError("'" + entry.path.string() + "' has changed while it was read; try again");
      return mMesh;
    };
    return meshes;
  }

  std::size_t count() const { return mEntries.size(); }
  std::size_t triangles() const {
    std::size_t all = 0;
    for (const Entry& entry : mEntries) all += entry.triangles;
    return all;
  }

 private:
  struct Entry {
    fs::path path;
    std::optional<UpAxis> recorded;
    double scale = 1;  ///< from its unit to the scene's
    std::size_t triangles = 0, points = 0;
  };

  static bool isColour(const VertexAttribute& attribute) {
    return attribute.name == "red" || attribute.name == "green" || attribute.name == "blue";
  }

  /// The attributes velocity_x, velocity_y and velocity_z, or VELOCITY_x and so on, as in a GLB; three times nullptr if
  /// the mesh lacks one of them.
  static std::array<VertexAttribute*, 3> velocitiesOf(Mesh& mesh) {
    std::array<VertexAttribute*, 3> parts{};
    for (VertexAttribute& attribute : mesh.attributes)
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (const char* name : {"velocity_", "VELOCITY_"})
          if (attribute.name == std::string(name) + "xyz"[axis]) parts[axis] = &attribute;
    return parts[0] && parts[1] && parts[2] ? parts : std::array<VertexAttribute*, 3>{};
  }

  /// The mesh in the axes and the unit of the scene, with normals, and with colours as linear light.
  const Mesh& read(std::size_t index, UpAxis up) {
    const Entry& entry = mEntries[index];
    mMesh = Mesh();  // frees the previous one
    mMesh = readMesh(entry.path);
    const UpTurn turn(entry.recorded.value_or(up), up);
    for (openvdb::Vec3d& point : mMesh.points) point = turn(point) * entry.scale;
    if (const auto velocity = velocitiesOf(mMesh); velocity[0]) {
      for (std::size_t axis = 0; axis < 3; ++axis) velocity[axis]->name = std::string("velocity_") + "xyz"[axis];
      for (std::size_t i = 0; i < mMesh.points.size(); ++i) {
        const auto& [x, y, z] = velocity;
        const openvdb::Vec3s turned(turn(openvdb::Vec3d(x->values[i], y->values[i], z->values[i])) * entry.scale);
        x->values[i] = turned[0];
        y->values[i] = turned[1];
        z->values[i] = turned[2];
      }
    }
    computeNormals(mMesh);
    if (const FileFormat* const format = formatOfMesh(entry.path); !format || !format->linearLight)
      for (VertexAttribute& attribute : mMesh.attributes)
        if (isColour(attribute))
          for (float& value : attribute.values) value = linearFromSrgb(std::clamp(value, 0.0F, 1.0F));
    mIndex = index;
    return mMesh;
  }

  std::vector<Entry> mEntries;
  UsdMeshes mMeshes;
  Mesh mMesh;
  std::optional<std::size_t> mIndex;  ///< of mMesh
};

/// The frames in the order of time; a single one without a number if the name has no frame pattern.
std::vector<std::optional<int>> framesOfName(const std::string& name, const std::vector<int>& frames) {
  if (!hasFramePattern(name)) return {std::nullopt};
  if (frames.empty())
    throw std::invalid_argument("'" + name + "' is the name of a sequence; say which frames, as in --frames 1-48");
  return {frames.begin(), frames.end()};
}

}  // namespace

UsdCounts writeUsdScene(const UsdOutputs& outputs, const UsdOptions& options, Monitor& monitor) {
  UsdScene scene{.framesPerSecond = options.framesPerSecond};
  std::optional<LengthUnit> unit;
  std::vector<int> frames = options.frames;
  std::sort(frames.begin(), frames.end());
  if (!frames.empty()) scene.range = {frames.front(), frames.back()};
  std::vector<std::optional<int>> ofVdb, ofMesh;
  if (!options.vdb.empty()) ofVdb = framesOfName(options.vdb, frames);
  if (!options.mesh.empty()) ofMesh = framesOfName(options.mesh, frames);
  monitor.begin(PhaseKind::Reading, ofVdb.size() + ofMesh.size());
  const auto advance = [&] {
    monitor.advance(1);
    monitor.throwIfCancelled();
  };
  for (const std::optional<int>& number : ofVdb) {
    addFrame(number ? expandFrame(options.vdb, number) : options.vdb, number, options, scene, unit);
    advance();
  }
  MeshReader meshes;
  for (const std::optional<int>& number : ofMesh) {
    meshes.add(number ? expandFrame(options.mesh, number) : options.mesh, number, options, scene, unit);
    advance();
  }
  if (!unit) unit = options.unit;
  scene.metersPerUnit = unit ? metresOf(*unit) : options.metersPerUnit.value_or(1);
  if (meshes.count() > 0) {
    scene.mesh = meshes.meshes(scene.up);
    // The scene asks for the meshes again while it is written; this can be interrupted between two of them.
    scene.mesh->at = [&monitor, at = scene.mesh->at](std::size_t index) -> const Mesh& {
      monitor.throwIfCancelled();
      return at(index);
    };
  }
  monitor.begin(PhaseKind::Writing, 0);
  if (outputs.scene) writeUsda(*outputs.scene, scene);
  if (outputs.package)
    writeUsdPackage(*outputs.package, outputs.packageName, [&](std::ostream& stream) { writeUsda(stream, scene); });
  monitor.throwIfCancelled();
  return {scene.frames.size(), scene.fields.size(), meshes.count(), meshes.triangles()};
}

}  // namespace vdbtools
