// SPDX-License-Identifier: Apache-2.0
// The triangles of a glTF's default scene as one mesh.
#include "mesh_files/format_readers.h"
#include "mesh_files/gltf_file.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
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

/// The transform of a node: p -> A p + t. Columns of A, then t.
struct Placement {
  std::array<Vec3d, 4> columns{Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1), Vec3d(0)};

  Vec3d direction(const Vec3d& v) const { return v[0] * columns[0] + v[1] * columns[1] + v[2] * columns[2]; }
  Vec3d point(const Vec3d& p) const { return direction(p) + columns[3]; }
  bool mirrors() const { return columns[0].cross(columns[1]).dot(columns[2]) < 0; }

  Placement after(const Placement& inner) const {
    Placement result;
    for (std::size_t k = 0; k < 3; ++k) result.columns[k] = direction(inner.columns[k]);
    result.columns[3] = point(inner.columns[3]);
    return result;
  }
};

Placement placementOf(const GltfFile& file, const Json& node) {
  Placement result;
  if (const std::vector<double> m = file.numbers(node, "matrix", 16); !m.empty()) {
    for (std::size_t k = 0; k < 4; ++k) result.columns[k] = Vec3d(m[4 * k], m[4 * k + 1], m[4 * k + 2]);
    return result;
  }
  if (const std::vector<double> q = file.numbers(node, "rotation", 4); !q.empty()) {
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    result.columns[0] = Vec3d(1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w));
    result.columns[1] = Vec3d(2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w));
    result.columns[2] = Vec3d(2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y));
  }
  if (const std::vector<double> s = file.numbers(node, "scale", 3); !s.empty())
    for (std::size_t k = 0; k < 3; ++k) result.columns[k] *= s[k];
  if (const std::vector<double> t = file.numbers(node, "translation", 3); !t.empty())
    result.columns[3] = Vec3d(t[0], t[1], t[2]);
  return result;
}

/// The mesh to which primitives are added.
class JoinedMesh {
 public:
  /// @param fileSize  bytes
  JoinedMesh(const GltfFile& file, std::uint64_t fileSize)
      : mFile(file),
        mMost(std::min<std::uint64_t>(fileSize + kMostRepeated, std::numeric_limits<std::uint32_t>::max())) {}

  void add(const Json& primitive, const Placement& placement) {
    constexpr std::uint64_t kTriangles = 4, kStrip = 5, kFan = 6;
    const std::uint64_t mode = mFile.whole(primitive, "mode", kTriangles);
    if (mode != kTriangles && mode != kStrip && mode != kFan) return;  // points and lines
    if (const auto extensions = primitive.find("extensions");
        extensions != primitive.end() && extensions->is_object() && extensions->contains("KHR_draco_mesh_compression"))
      mFile.fail(
          "its geometry is compressed (KHR_draco_mesh_compression), which cannot be read; export it without "
          "compression");
    const auto attributes = primitive.find("attributes");
    if (attributes == primitive.end() || !attributes->is_object()) mFile.fail("a primitive has no attributes");
    if (!attributes->contains("POSITION")) return;
    const GltfArray positions = mFile.array(mFile.whole(*attributes, "POSITION"));
    if (positions.components() != 3) mFile.fail("positions are not vectors of three numbers");
    requireRoom(mMesh.points.size(), positions.count());
    const std::size_t first = mMesh.points.size();
    for (std::uint64_t i = 0; i < positions.count(); ++i) {
      const Vec3d p = placement.point({positions.value(i, 0), positions.value(i, 1), positions.value(i, 2)});
      if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2]))
        mFile.fail("point " + std::to_string(i) + " of a mesh has coordinates that are not finite");
      mMesh.points.push_back(p);
    }
    const std::vector<std::uint32_t> corners = cornersOf(primitive, positions.count());
    const std::size_t firstTriangle = mMesh.triangles.size();
    addTriangles(corners, mode == kStrip, mode == kFan, static_cast<std::uint32_t>(first), placement.mirrors());
    addAttributes(*attributes, first, positions.count());
    addUvs(*attributes, first, firstTriangle, positions.count());
  }

  Mesh finish() {
    for (VertexAttribute& attribute : mMesh.attributes)
      attribute.values.resize(mMesh.points.size(), gap(attribute.name));
    if (!mMesh.cornerUvs.empty()) mMesh.cornerUvs.resize(3 * mMesh.triangles.size(), openvdb::Vec2s(kNoNumber));
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

  const GltfFile& mFile;
  std::uint64_t mMost;  ///< points, and triangles
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

Mesh readGltf(const std::filesystem::path& path, std::string_view contents) {
  const GltfFile file(path, contents);
  JoinedMesh joined(file, contents.size());
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
    const Placement placement = outer.after(placementOf(file, node));
    if (node.contains("mesh")) {
      const std::uint64_t mesh = file.whole(node, "mesh");
      const Json& shape = file.element("meshes", mesh);
      const auto primitives = shape.find("primitives");
      if (primitives == shape.end() || !primitives->is_array())
        file.fail("mesh " + std::to_string(mesh) + " has no primitives");
      for (const Json& primitive : *primitives) {
        if (!primitive.is_object()) file.fail("a primitive is not an object");
        joined.add(primitive, placement);
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
