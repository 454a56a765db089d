// SPDX-License-Identifier: Apache-2.0
// The triangles of a glTF's default scene as one mesh.
#include "mesh_files/gltf_file.h"
#include "mesh_files/gltf_pose.h"
#include "mesh_files/mesh_formats.h"
#include "mesh_files/usable_points.h"
#include "vdbtools/base/text.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

using Json = nlohmann::json;
using openvdb::Vec3d;
using openvdb::Vec3I;

/// The maximum number of points and triangles in excess of those for which the file has bytes. Parts that are instanced
/// several times count each time, and a small file must not become a mesh that fills the memory.
constexpr std::uint64_t kMostRepeated = 10'000'000;

constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";

bool isInstanced(const Json& node) {
  const auto extensions = node.find("extensions");
  return extensions != node.end() && extensions->is_object() && extensions->contains(kInstancing);
}

/// Where a node shows its mesh, relative to the node: once, or as often as the extension EXT_mesh_gpu_instancing says.
std::vector<Placement> instancesOf(const GltfFile& file, const Json& node) {
  if (!isInstanced(node)) return {Placement()};
  const Json& instancing = node["extensions"][kInstancing];
  const auto attributes = instancing.is_object() ? instancing.find("attributes") : instancing.end();
  if (!instancing.is_object() || attributes == instancing.end() || !attributes->is_object())
    file.fail(std::string(kInstancing) + " has no attributes");
  std::uint64_t count = 0;
  const auto read = [&](const char* name, int components) -> std::optional<GltfArray> {
    if (!attributes->contains(name)) return std::nullopt;
    const GltfArray array = file.array(file.whole(*attributes, name));
    if (array.components() != components || (count != 0 && array.count() != count) || array.count() > kMostRepeated)
      file.fail(std::string("'") + name + "' of " + kInstancing +
                " does not fit the other attributes of the instances");
    count = array.count();
    return array;
  };
  const auto translation = read("TRANSLATION", 3), rotation = read("ROTATION", 4), scale = read("SCALE", 3);
  std::vector<Placement> placements(count);
  const auto numbers = [](const std::optional<GltfArray>& array, std::uint64_t i) {
    std::vector<double> result;
    for (int k = 0; array && k < array->components(); ++k) result.push_back(array->value(i, k));
    return result;
  };
  for (std::uint64_t i = 0; i < count; ++i)
    placements[i] = placed(numbers(translation, i), numbers(rotation, i), numbers(scale, i));
  return placements;
}

/// The mesh to which primitives are added.
class JoinedMesh {
 public:
  /// @param fileSize  bytes
  JoinedMesh(const std::filesystem::path& path, const GltfFile& file, std::uint64_t fileSize)
      : mPath(path),
        mFile(file),
        mMost(std::min<std::uint64_t>(fileSize + kMostRepeated, std::numeric_limits<std::uint32_t>::max())) {}

  /// @param weights, joints  as in GltfShape
  void add(const Json& primitive, const Placement& placement, const std::vector<double>& weights,
           const std::vector<Placement>& joints) {
    constexpr std::uint64_t kTriangles = 4, kStrip = 5, kFan = 6;
    const std::uint64_t mode = mFile.whole(primitive, "mode", kTriangles);
    if (mode != kTriangles && mode != kStrip && mode != kFan) return;  // points and lines
    const auto attributes = primitive.find("attributes");
    if (attributes == primitive.end() || !attributes->is_object()) mFile.fail("a primitive has no attributes");
    if (!attributes->contains("POSITION")) return;
    const GltfShape shape(mFile, primitive, weights, joints, placement);
    requireRoom(mMesh.points.size(), shape.count());
    mMorphed += shape.count() * shape.morphs();
    requireRoom(mMorphed / kMostMorphsOfPoint, 0);
    const std::size_t first = mMesh.points.size();
    for (std::uint64_t i = 0; i < shape.count(); ++i) mMesh.points.push_back(shape.point(i));
    const std::vector<std::uint32_t> corners = cornersOf(primitive, shape.count());
    const std::size_t firstTriangle = mMesh.triangles.size();
    addTriangles(corners, mode == kStrip, mode == kFan, static_cast<std::uint32_t>(first), shape.mirrors());
    for (std::size_t t = firstTriangle; t < mMesh.triangles.size(); ++t)
      for (int k = 0; k < 3; ++k)
        if (const std::uint32_t corner = mMesh.triangles[t][k]; !mMesh.points[corner].isFinite())
          mFile.fail("point " + std::to_string(corner - first) + " of a mesh has coordinates that are not finite");
    addAttributes(*attributes, first, shape.count());
    addUvs(*attributes, first, firstTriangle, shape.count());
  }

  Mesh finish() {
    for (VertexAttribute& attribute : mMesh.attributes)
      attribute.values.resize(mMesh.points.size(), gap(attribute.name));
    if (!mMesh.cornerUvs.empty()) mMesh.cornerUvs.resize(3 * mMesh.triangles.size(), openvdb::Vec2s(kNoNumber));
    leaveOutUnusable(mPath, mMesh);
    return std::move(mMesh);
  }

 private:
  void requireRoom(std::uint64_t has, std::uint64_t more) const {
    if (has > mMost || more > mMost - has)
      mFile.fail("the scene shows its meshes so often that they are too large together; export it without instances");
  }

  std::vector<std::uint32_t> cornersOf(const Json& primitive, std::uint64_t points) const {
    std::vector<std::uint32_t> corners;
    if (!primitive.contains("indices")) {
      requireRoom(mMesh.triangles.size(), points);
      corners.resize(points);
      for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = static_cast<std::uint32_t>(i);
      return corners;
    }
    const GltfArray indices = mFile.array(mFile.whole(primitive, "indices"));
    if (indices.components() != 1 || !indices.isUnsigned()) mFile.fail("indices are not whole numbers");
    requireRoom(mMesh.triangles.size(), indices.count());
    corners.resize(indices.count());
    for (std::size_t i = 0; i < corners.size(); ++i) {
      corners[i] = indices.index(i);
      if (corners[i] >= points)
        mFile.fail("a triangle uses point " + std::to_string(corners[i]) + " of " + std::to_string(points));
    }
    return corners;
  }

  void addTriangles(const std::vector<std::uint32_t>& corners, bool strip, bool fan, std::uint32_t first,
                    bool mirrored) {
    const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
      Vec3I triangle(first + corners[a], first + corners[b], first + corners[c]);
      if (mirrored) std::swap(triangle[1], triangle[2]);
      mMesh.triangles.push_back(triangle);
    };
    if (!strip && !fan) {
      for (std::size_t i = 0; i + 2 < corners.size(); i += 3) add(i, i + 1, i + 2);
      return;
    }
    for (std::size_t i = 0; i + 2 < corners.size(); ++i) {
      if (fan) add(0, i + 1, i + 2);
      if (strip) add(i, i + 1 + i % 2, i + 2 - i % 2);
    }
  }

  /// The value of a point for which the scene gives none: white, or NaN.
  static float gap(const std::string& name) {
    return name == "red" || name == "green" || name == "blue" || name == "alpha" ? 1 : kNoNumber;
  }

  std::vector<float>& attribute(const std::string& name) {
    for (VertexAttribute& attribute : mMesh.attributes)
      if (attribute.name == name) return attribute.values;
    return mMesh.attributes.emplace_back(VertexAttribute{name, {}}).values;
  }

  void addAttributes(const Json& attributes, std::size_t first, std::uint64_t points) {
    for (const auto& [key, value] : attributes.items()) {
      const bool colour = key == "COLOR_0";
      if (!colour && (!key.starts_with('_') || key.size() == 1)) continue;
      const GltfArray array = mFile.array(mFile.whole(attributes, key.c_str()));
      if (array.count() != points) mFile.fail("'" + key + "' has not as many elements as there are points");
      for (int k = 0; k < array.components(); ++k) {
        constexpr const char *kChannels[] = {"red", "green", "blue", "alpha"}, *kAxes[] = {"_x", "_y", "_z", "_w"};
        const std::string name = colour                    ? kChannels[k]
                                 : array.components() == 1 ? key.substr(1)
                                                           : key.substr(1) + kAxes[k];
        std::vector<float>& values = attribute(name);
        values.resize(first, gap(name));
        for (std::uint64_t i = 0; i < points; ++i) values.push_back(static_cast<float>(array.value(i, k)));
      }
    }
  }

  void addUvs(const Json& attributes, std::size_t first, std::size_t firstTriangle, std::uint64_t points) {
    if (!attributes.contains("TEXCOORD_0")) return;
    const GltfArray array = mFile.array(mFile.whole(attributes, "TEXCOORD_0"));
    if (array.components() != 2 || array.count() != points)
      mFile.fail("texture coordinates are not two numbers for each point");
    mMesh.cornerUvs.resize(3 * firstTriangle, openvdb::Vec2s(kNoNumber));
    for (std::size_t t = firstTriangle; t < mMesh.triangles.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        const std::uint64_t point = mMesh.triangles[t][k] - first;
        // In glTF the origin is the upper left corner of a picture, and here the lower left one.
        mMesh.cornerUvs.emplace_back(static_cast<float>(array.value(point, 0)),
                                     1 - static_cast<float>(array.value(point, 1)));
      }
  }

  /// On average over all points, of those in use.
  static constexpr std::uint64_t kMostMorphsOfPoint = 16;

  const std::filesystem::path& mPath;
  const GltfFile& mFile;
  std::uint64_t mMost;         ///< points, and triangles
  std::uint64_t mMorphed = 0;  ///< points times the morph targets that move them
  Mesh mMesh;
};

/// The roots of the default scene; in a file without scenes, the nodes that are not children of another.
std::vector<std::uint64_t> rootsOf(const GltfFile& file) {
  std::vector<std::uint64_t> roots;
  const auto add = [&](const Json& list) {
    if (!list.is_array()) file.fail("a list of nodes is none");
    for (const Json& node : list) roots.push_back(file.whole(Json{{"node", node}}, "node"));
  };
  if (file.sizeOf("scenes") > 0) {
    const Json& scene = file.element("scenes", file.whole(file.json(), "scene", 0));
    if (scene.contains("nodes")) add(scene["nodes"]);
    return roots;
  }
  std::vector<bool> isChild(file.sizeOf("nodes"));
  for (std::uint64_t i = 0; i < isChild.size(); ++i)
    if (const Json& node = file.element("nodes", i); node.contains("children")) {
      add(node["children"]);
      for (const std::uint64_t child : std::exchange(roots, {}))
        if (child < isChild.size()) isChild[child] = true;
    }
  for (std::uint64_t i = 0; i < isChild.size(); ++i)
    if (!isChild[i]) roots.push_back(i);
  return roots;
}

}  // namespace

bool beginsAsGlb(std::string_view head, std::uintmax_t) { return head.starts_with("glTF"); }

bool beginsAsGltf(std::string_view head, std::uintmax_t) {
  const std::string_view text = withoutByteOrderMark(head);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first != std::string_view::npos && text[first] == '{';
}

Mesh readGltf(const std::filesystem::path& path, std::string_view contents, const std::optional<MeshMoment>& moment) {
  const GltfFile file(path, contents);
  const GltfPose pose(file, moment);
  JoinedMesh joined(path, file, contents.size());
  std::vector<std::pair<std::uint64_t, Placement>> open;
  for (const std::uint64_t root : rootsOf(file)) open.emplace_back(root, Placement());
  std::reverse(open.begin(), open.end());
  std::vector<bool> seen(file.sizeOf("nodes"));
  while (!open.empty()) {
    const auto [index, outer] = open.back();
    open.pop_back();
    const Json& node = file.element("nodes", index);
    if (seen[index]) file.fail("node " + std::to_string(index) + " occurs twice in the tree of nodes");
    seen[index] = true;
    const Placement placement = outer.after(pose.local(index));
    if (node.contains("mesh")) {
      const std::uint64_t mesh = file.whole(node, "mesh");
      const Json& shape = file.element("meshes", mesh);
      const auto primitives = shape.find("primitives");
      if (primitives == shape.end() || !primitives->is_array())
        file.fail("mesh " + std::to_string(mesh) + " has no primitives");
      const std::vector<Placement> instances = instancesOf(file, node);
      std::vector<Placement> joints;
      if (node.contains("skin")) {
        joints = pose.jointsOf(file.whole(node, "skin"));
        if (isInstanced(node)) file.fail("node " + std::to_string(index) + " has a skin and instances");
      }
      const std::vector<double> weights = pose.morphWeights(index);
      for (const Placement& instance : instances)
        for (const Json& primitive : *primitives) {
          if (!primitive.is_object()) file.fail("a primitive is not an object");
          joined.add(primitive, placement.after(instance), weights, joints);
        }
    }
    if (!node.contains("children")) continue;
    const Json& children = node["children"];
    if (!children.is_array()) file.fail("a list of nodes is none");
    for (auto child = children.rbegin(); child != children.rend(); ++child)
      open.emplace_back(file.whole(Json{{"node", *child}}, "node"), placement);
  }
  return joined.finish();
}

}  // namespace vdbtools
