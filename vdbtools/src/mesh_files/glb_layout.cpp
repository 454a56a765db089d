// SPDX-License-Identifier: Apache-2.0
#include "mesh_files/glb_layout.h"

#include "mesh_files/glb_format.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace vdbtools {
namespace {

using OrderedJson = nlohmann::ordered_json;

// Codes of glTF.
constexpr int kVertices = 34962, kIndices = 34963, kTriangles = 4;
constexpr std::uint64_t kLongestFile = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t kLongestVertex = 252;  ///< bytes: the longest byteStride

constexpr std::size_t kVectorSize = 3 * sizeof(float), kTriangleSize = 3 * sizeof(std::uint32_t);

std::uint64_t vertexBytes(const GlbContent& content, const MeshWriteOptions& options) {
  return content.points * glbVertexSize(options, content.normals);
}

std::uint64_t binaryBytes(const GlbContent& content, const MeshWriteOptions& options) {
  std::uint64_t triangles = content.triangles;
  for (const MeshLevel& level : content.levels) triangles += level.triangles;
  return vertexBytes(content, options) + triangles * kTriangleSize;
}

OrderedJson asArray(const openvdb::Vec3d& v) { return {v[0], v[1], v[2]}; }

const char* typeOf(ColumnKind kind) {
  switch (kind) {
    case ColumnKind::Number: return "SCALAR";
    case ColumnKind::TextureCoordinate: return "VEC2";
    case ColumnKind::Vector:
    case ColumnKind::WorldVector:
    case ColumnKind::LinearRgb: return "VEC3";
  }
  throw std::logic_error("a kind of column that does not exist");
}

/// Adds accessors of the vertices, and returns the attributes of a mesh that refer to them.
OrderedJson addVertexAccessors(const GlbContent& content, const MeshWriteOptions& options, OrderedJson& accessors) {
  OrderedJson attributes = OrderedJson::object();
  std::size_t offset = 0;
  const auto add = [&](const std::string& name, const char* type, std::size_t bytes) -> OrderedJson& {
    attributes[name] = accessors.size();
    accessors.push_back({{"bufferView", 0},
                         {"byteOffset", offset},
                         {"componentType", glb::kFloat},
                         {"count", content.points},
                         {"type", type}});
    offset += bytes;
    return accessors.back();
  };
  OrderedJson& positions = add("POSITION", "VEC3", kVectorSize);
  positions["min"] = asArray(openvdb::Vec3d(content.low));
  positions["max"] = asArray(openvdb::Vec3d(content.high));
  if (content.normals) add("NORMAL", "VEC3", kVectorSize);
  int colours = 0, coordinates = 0;
  for (const VertexColumn& column : options.columns) {
    std::string name = column.kind == ColumnKind::LinearRgb           ? "COLOR_" + std::to_string(colours++)
                       : column.kind == ColumnKind::TextureCoordinate ? "TEXCOORD_" + std::to_string(coordinates++)
                                                                      : '_' + column.name;
    if (column.kind == ColumnKind::WorldVector)
      for (char& c : name) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    add(name, typeOf(column.kind), componentsOf(column.kind) * sizeof(float));
  }
  return attributes;
}

/// Adds the mesh and its levels: accessors, meshes and nodes.
void addMeshes(const GlbContent& content, const MeshWriteOptions& options, OrderedJson& json) {
  OrderedJson accessors = OrderedJson::array();
  const OrderedJson attributes = addVertexAccessors(content, options, accessors);
  OrderedJson meshes = OrderedJson::array(), nodes = OrderedJson::array(), coarser = OrderedJson::array();
  std::uint64_t offset = 0;
  const auto add = [&](std::uint64_t triangles, double error) {
    const std::string name = content.levels.empty() ? "fractal" : "LOD" + std::to_string(nodes.size());
    OrderedJson node{{"name", name}, {"mesh", meshes.size()}};
    if (content.centre != openvdb::Vec3d(0)) node["translation"] = asArray(content.centre);
    if (!nodes.empty()) {
      node["extras"] = {{"error", error}};
      coarser.push_back(nodes.size());
    }
    nodes.push_back(std::move(node));
    meshes.push_back(
        {{"name", name},
         {"primitives",
          OrderedJson::array(
              {{{"attributes", attributes}, {"indices", accessors.size()}, {"material", 0}, {"mode", kTriangles}}})}});
    accessors.push_back({{"bufferView", 1},
                         {"byteOffset", offset},
                         {"componentType", glb::kUnsignedInt},
                         {"count", 3 * triangles},
                         {"type", "SCALAR"}});
    offset += triangles * kTriangleSize;
  };
  add(content.triangles, 0);
  for (const MeshLevel& level : content.levels) add(level.triangles, level.error);
  if (!coarser.empty()) nodes[0]["extensions"] = {{"MSFT_lod", {{"ids", coarser}}}};
  json["scenes"][0]["nodes"] = {0};
  json["nodes"] = std::move(nodes);
  json["meshes"] = std::move(meshes);
  // Without a material a mesh would look like polished metal.
  json["materials"] = OrderedJson::array(
      {{{"name", "fractal"}, {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0.7}}}}});
  json["accessors"] = std::move(accessors);
  const std::uint64_t vertices = vertexBytes(content, options);
  json["bufferViews"] = OrderedJson::array({{{"buffer", 0},
                                             {"byteOffset", 0},
                                             {"byteLength", vertices},
                                             {"byteStride", glbVertexSize(options, content.normals)},
                                             {"target", kVertices}},
                                            {{"buffer", 0},
                                             {"byteOffset", vertices},
                                             {"byteLength", binaryBytes(content, options) - vertices},
                                             {"target", kIndices}}});
}

std::string jsonText(const GlbContent& content, const MeshWriteOptions& options) {
  OrderedJson recipe = OrderedJson::object();
  for (const auto& [key, value] : options.comments) recipe[key] = value;
  OrderedJson json{{"asset", {{"version", "2.0"}, {"generator", "JuliaVDB " JULIAVDB_VERSION}}},
                   {"scene", 0},
                   {"scenes", OrderedJson::array({OrderedJson::object()})}};
  if (!recipe.empty()) json["asset"]["extras"] = std::move(recipe);
  if (!content.levels.empty()) json["extensionsUsed"] = {"MSFT_lod"};
  if (content.points > 0 && content.triangles > 0) addMeshes(content, options, json);
  if (const std::uint64_t bytes = binaryBytes(content, options); bytes > 0)
    json["buffers"] = OrderedJson::array({{{"byteLength", bytes}}});
  return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

/// The length of the JSON with numbers whose texts are as long as possible.
std::size_t longestJson(const GlbContent& content, const MeshWriteOptions& options) {
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();
  constexpr double kLong = -1.2345678901234567e-100;
  GlbContent longest = content;
  longest.points = longest.triangles = kMost;
  longest.levels.assign(options.levels.size(), {.triangles = kMost, .error = kLong});
  longest.low = longest.high = openvdb::Vec3s(-std::numeric_limits<float>::max());
  if (content.centre != openvdb::Vec3d(0)) longest.centre = openvdb::Vec3d(kLong);
  // The box consists of floats, whose text as doubles may be as long as that of kLong.
  constexpr std::size_t kBoxRoom = 6 * 8;
  return (jsonText(longest, options).size() + kBoxRoom + 3) / 4 * 4;
}

void append(std::string& to, std::uint64_t value) {
  const auto number = static_cast<std::uint32_t>(value);
  to.append(reinterpret_cast<const char*>(&number), sizeof number);
}

}  // namespace

std::size_t glbVertexSize(const MeshWriteOptions& options, bool normals) {
  return (normals ? 2 : 1) * kVectorSize + rowLength(options.columns) * sizeof(float);
}

std::string glbHeader(const GlbContent& content, const MeshWriteOptions& options) {
  std::string json = jsonText(content, options);
  const std::size_t room = longestJson(content, options);
  if (json.size() > room) throw std::logic_error("the JSON of a GLB is longer than the room that was left for it");
  json.resize(room, ' ');
  const std::uint64_t binary = binaryBytes(content, options);
  std::string header;
  append(header, glb::kMagic);
  append(header, glb::kVersion);
  append(header, glb::kFileHead + glb::kChunkHead + json.size() + glb::kChunkHead + binary);
  append(header, json.size());
  append(header, glb::kJsonChunk);
  header += json;
  append(header, binary);
  append(header, glb::kBinaryChunk);
  return header;
}

void requireGlbSize(const GlbContent& content, const MeshWriteOptions& options) {
  const std::uint64_t size =
      glb::kFileHead + 2 * glb::kChunkHead + longestJson(content, options) + binaryBytes(content, options);
  if (size > kLongestFile)
    throw std::invalid_argument("a GLB cannot be larger than 4 GiB, and this mesh has " +
                                std::to_string(content.points) + " points and " + std::to_string(content.triangles) +
                                " triangles or more; write a PLY, or use larger voxels");
}

void requireGlbColumns(const MeshWriteOptions& options) {
  constexpr std::size_t kMost = (kLongestVertex - 2 * kVectorSize) / sizeof(float);
  if (const std::size_t length = rowLength(options.columns); length > kMost)
    throw std::invalid_argument("a GLB holds up to " + std::to_string(kMost) +
                                " numbers a point besides its position and normal, not " + std::to_string(length) +
                                "; write a PLY, or fewer attributes");
}

char* putGlbRow(char* to, const float* row, const MeshWriteOptions& options) {
  for (const VertexColumn& column : options.columns) {
    const std::size_t count = componentsOf(column.kind);
    for (std::size_t k = 0; k < count; ++k, ++row) {
      float value = *row;
      if (column.kind == ColumnKind::LinearRgb) value = std::isfinite(value) ? std::clamp(value, 0.0F, 1.0F) : 0;
      // In glTF the origin of a picture is its upper left corner.
      if (column.kind == ColumnKind::TextureCoordinate && k == 1) value = 1 - value;
      std::memcpy(to, &value, sizeof value);
      to += sizeof value;
    }
  }
  return to;
}

}  // namespace vdbtools
