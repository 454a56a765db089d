// SPDX-License-Identifier: Apache-2.0
// GLB as it is written, read by a library that is not ours; and glTF as it is read, with files that are broken.
#include "mesh_files/glb_layout.h"
#include "support/temporary_folder.h"
#include "support/test_meshes.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/surface/extract_mesh.h"

#include <gtest/gtest.h>
#include <tiny_gltf.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstring>
#include <random>
#include <sstream>
#include <tuple>

namespace {

using namespace vdbtools;
using Json = nlohmann::json;
using openvdb::Vec3d;
using openvdb::Vec3I;
using openvdb::Vec3s;

const std::vector<VertexColumn> kColumns = {{"trap", ColumnKind::Number},
                                            {"Cd", ColumnKind::LinearRgb},
                                            {"direction", ColumnKind::Vector},
                                            {"uv", ColumnKind::TextureCoordinate}};

/// A lopsided ball with normals, and a row of values for each point.
struct Made {
  Mesh mesh = test_meshes::transformed(test_meshes::makeSphere(1, 3), 1, Vec3d(0.3, -0.7, 0.2));
  std::vector<float> values;

  Made() {
    for (Vec3d& point : mesh.points) point[0] *= 1 + 0.2 * point[1];
    computeNormals(mesh);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> share(0, 1);
    for (std::size_t i = 0; i < mesh.points.size() * rowLength(kColumns); ++i) values.push_back(share(random));
  }
};

std::string glbOf(const Mesh& mesh, MeshWriteOptions options = {}, std::span<const float> values = {}) {
  options.format = &meshFormat(".glb");
  std::ostringstream stream;
  writeMesh(stream, mesh, options, values);
  return stream.str();
}

tinygltf::Model parsed(const std::string& glb) {
  tinygltf::TinyGLTF loader;
  tinygltf::Model model;
  std::string error, warning;
  EXPECT_TRUE(loader.LoadBinaryFromMemory(&model, &error, &warning, reinterpret_cast<const unsigned char*>(glb.data()),
                                          static_cast<unsigned>(glb.size())))
      << error;
  EXPECT_EQ(error + warning, "");
  return model;
}

/// The floats of an attribute, as the specification says to find them.
std::vector<float> floatsOf(const tinygltf::Model& model, int index) {
  const tinygltf::Accessor& accessor = model.accessors.at(static_cast<std::size_t>(index));
  EXPECT_EQ(accessor.componentType, TINYGLTF_COMPONENT_TYPE_FLOAT);
  const tinygltf::BufferView& view = model.bufferViews.at(static_cast<std::size_t>(accessor.bufferView));
  const auto count =
      static_cast<std::size_t>(tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type)));
  const auto stride = static_cast<std::size_t>(accessor.ByteStride(view));
  std::vector<float> values(count * accessor.count);
  for (std::size_t i = 0; i < accessor.count; ++i)
    std::memcpy(&values[i * count], &model.buffers[0].data.at(view.byteOffset + accessor.byteOffset + i * stride),
                count * sizeof(float));
  return values;
}

std::vector<Vec3I> trianglesInModel(const tinygltf::Model& model, std::size_t mesh) {
  const tinygltf::Accessor& accessor =
      model.accessors.at(static_cast<std::size_t>(model.meshes.at(mesh).primitives.at(0).indices));
  EXPECT_EQ(accessor.componentType, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT);
  const tinygltf::BufferView& view = model.bufferViews.at(static_cast<std::size_t>(accessor.bufferView));
  EXPECT_LE(accessor.byteOffset + 4 * accessor.count, view.byteLength);
  std::vector<Vec3I> triangles(accessor.count / 3);
  std::memcpy(triangles.data(), &model.buffers[0].data.at(view.byteOffset + accessor.byteOffset), 4 * accessor.count);
  return triangles;
}

// Promise: PLY, OBJ and STL of a fractal ...
// Promise of handoff.md: A GLB has what the mesh has, and levels of detail "over the same vertices"; beyond 4 GiB "the
//   program says so"
TEST(Glb, HasWhatTheMeshHasForAnotherReader) {
  const Made made;
  const tinygltf::Model model =
      parsed(glbOf(made.mesh, {.columns = kColumns, .comments = {{"julia_alpha", "40 \"x\""}}}, made.values));
  ASSERT_EQ(model.meshes.size(), 1u);
  EXPECT_EQ(model.asset.version, "2.0");
  EXPECT_EQ(model.asset.extras.Get("julia_alpha").Get<std::string>(), "40 \"x\"");
  ASSERT_EQ(model.scenes.at(static_cast<std::size_t>(model.defaultScene)).nodes, std::vector<int>{0});
  EXPECT_TRUE(model.nodes.at(0).translation.empty());
  EXPECT_EQ(trianglesInModel(model, 0), made.mesh.triangles);
  const std::map<std::string, int>& attributes = model.meshes[0].primitives.at(0).attributes;
  EXPECT_EQ(attributes.size(), 6u);
  const std::vector<float> positions = floatsOf(model, attributes.at("POSITION")),
                           normals = floatsOf(model, attributes.at("NORMAL")),
                           colours = floatsOf(model, attributes.at("COLOR_0")),
                           uvs = floatsOf(model, attributes.at("TEXCOORD_0")),
                           traps = floatsOf(model, attributes.at("_trap")),
                           directions = floatsOf(model, attributes.at("_direction"));
  ASSERT_EQ(positions.size(), 3 * made.mesh.points.size());
  Vec3d low(1e9), high(-1e9);
  for (std::size_t i = 0; i < made.mesh.points.size(); ++i) {
    const float* row = &made.values[i * rowLength(kColumns)];
    ASSERT_EQ(traps[i], row[0]);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<int>(k);
      ASSERT_EQ(positions[3 * i + k], static_cast<float>(made.mesh.points[i][axis]));
      ASSERT_EQ(normals[3 * i + k], made.mesh.normals[i][axis]);
      ASSERT_EQ(colours[3 * i + k], row[1 + k]);
      ASSERT_EQ(directions[3 * i + k], row[4 + k]);
      low[axis] = std::min(low[axis], static_cast<double>(positions[3 * i + k]));
      high[axis] = std::max(high[axis], static_cast<double>(positions[3 * i + k]));
    }
    ASSERT_EQ(uvs[2 * i], row[7]);
    ASSERT_EQ(uvs[2 * i + 1], 1 - row[8]);
  }
  const tinygltf::Accessor& accessor = model.accessors.at(static_cast<std::size_t>(attributes.at("POSITION")));
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(accessor.minValues.at(k), low[static_cast<int>(k)]);
    EXPECT_EQ(accessor.maxValues.at(k), high[static_cast<int>(k)]);
  }
}

/// Values of a mesh by the place of their point: readMesh() welds, which may drop and reorder points.
std::map<std::array<float, 3>, std::vector<float>> byPlace(const Mesh& mesh) {
  std::map<std::array<float, 3>, std::vector<float>> result;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const Vec3s p(mesh.points[i]);
    for (const VertexAttribute& attribute : mesh.attributes) result[{p[0], p[1], p[2]}].push_back(attribute.values[i]);
  }
  return result;
}

TEST(Glb, ReadsBack) {
  const Made made;
  const TemporaryFolder folder;
  const Mesh read = readMesh(
      folder.write("a.glb", glbOf(made.mesh, {.columns = kColumns, .comments = {{"julia_alpha", "40"}}}, made.values)));
  EXPECT_EQ(read.triangles, made.mesh.triangles);
  std::vector<std::string> names;
  for (const VertexAttribute& attribute : read.attributes) names.push_back(attribute.name);
  EXPECT_EQ(names,
            (std::vector<std::string>{"red", "green", "blue", "direction_x", "direction_y", "direction_z", "trap"}));
  const auto values = byPlace(read);
  for (std::size_t i = 0; i < made.mesh.points.size(); ++i) {
    const Vec3s p(made.mesh.points[i]);
    const float* row = &made.values[i * rowLength(kColumns)];
    ASSERT_EQ(values.at({p[0], p[1], p[2]}),
              (std::vector<float>{row[1], row[2], row[3], row[4], row[5], row[6], row[0]}));
  }
  ASSERT_EQ(read.cornerUvs.size(), 3 * made.mesh.triangles.size());
  for (std::size_t t = 0; t < made.mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const float* row = &made.values[made.mesh.triangles[t][k] * rowLength(kColumns)];
      const openvdb::Vec2s uv = read.cornerUvs[3 * t + static_cast<std::size_t>(k)];
      ASSERT_EQ(uv[0], row[7]);
      ASSERT_NEAR(uv[1], row[8], 1e-6);
    }
  EXPECT_EQ(readMeshTexts(folder.path() / "a.glb"), (std::map<std::string, std::string>{{"julia_alpha", "40"}}));
}

// Promise: "Where floats would move ..."
TEST(Glb, ASmallObjectFarAwayKeepsItsShape) {
  const Vec3d away(1e6, -3e5, 2e6);
  Mesh mesh = test_meshes::makeSphere(0.5, 3);
  for (Vec3d& point : mesh.points) point += away;
  const double voxel = 0.01;
  const TemporaryFolder folder;
  const Mesh read = readMesh(folder.write("a.glb", glbOf(mesh, {.voxelSize = voxel})));
  ASSERT_EQ(read.points.size(), mesh.points.size());
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    ASSERT_LT((read.points[i] - mesh.points[i]).length(), 1e-3 * voxel) << i;
  const tinygltf::Model model = parsed(glbOf(mesh, {.voxelSize = voxel, .turn = {UpAxis::Y, UpAxis::Z}}));
  const std::vector<double>& to = model.nodes.at(0).translation;
  ASSERT_EQ(to.size(), 3u);
  EXPECT_NEAR(to[0], away[0], 1);
  EXPECT_NEAR(to[1], -away[2], 1);
  EXPECT_NEAR(to[2], away[1], 1);
}

// Promise: A GLB has what the mesh has, and levels ...
TEST(Glb, LevelsOfDetailAreCoarserMeshesOverTheSamePoints) {
  const Made made;
  const MeshWriteOptions options{.format = &meshFormat(".glb"), .columns = kColumns, .levels = {0.5, 0.1}};
  std::ostringstream stream;
  const std::vector<MeshLevel> levels = writeMesh(stream, made.mesh, options, made.values);
  ASSERT_EQ(levels.size(), 2u);
  const tinygltf::Model model = parsed(stream.str());
  ASSERT_EQ(model.meshes.size(), 3u);
  // A reader without the extension shows the whole mesh alone.
  EXPECT_EQ(model.scenes.at(0).nodes, std::vector<int>{0});
  EXPECT_EQ(model.extensionsUsed, std::vector<std::string>{"MSFT_lod"});
  const tinygltf::Value& ids = model.nodes.at(0).extensions.at("MSFT_lod").Get("ids");
  ASSERT_EQ(ids.ArrayLen(), 2u);
  double before = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    SCOPED_TRACE(i);
    EXPECT_EQ(ids.Get(i).GetNumberAsInt(), static_cast<int>(i + 1));
    EXPECT_EQ(model.nodes.at(i + 1).mesh, static_cast<int>(i + 1));
    Mesh level{.points = made.mesh.points, .triangles = trianglesInModel(model, i + 1)};
    EXPECT_EQ(level.triangles.size(), levels[i].triangles);
    const double share = static_cast<double>(level.triangles.size()) / static_cast<double>(made.mesh.triangles.size());
    EXPECT_NEAR(share, options.levels[i], 0.02);
    EXPECT_TRUE(reportMesh(level).closed());
    EXPECT_GT(levels[i].error, before);
    before = levels[i].error;
    EXPECT_NEAR(model.nodes[i + 1].extras.Get("error").GetNumberAsDouble(), levels[i].error, 1e-12);
    // What is lost of the volume is at most what such a shift of the whole surface would take, a few times over.
    const MeshReport whole = reportMesh(made.mesh), left = reportMesh(level);
    EXPECT_LT(std::abs(whole.volume - left.volume), 3 * levels[i].error * whole.area);
  }
}

// Promise: A GLB has what the mesh has, and levels ...
TEST(Glb, IsRefusedWhereItsNumbersDoNotFit) {
  const MeshWriteOptions options{.format = &meshFormat(".glb")};
  // Of 24 bytes a point and 12 a triangle.
  EXPECT_NO_THROW(requireGlbSize({.normals = true, .points = 80'000'000, .triangles = 160'000'000}, options));
  EXPECT_THROW(requireGlbSize({.normals = true, .points = 90'000'000, .triangles = 180'000'000}, options),
               std::invalid_argument);
  std::vector<VertexColumn> many;
  for (int i = 0; i < 60; ++i) many.push_back({"c" + std::to_string(i), ColumnKind::Number});
  EXPECT_THROW(glbOf({}, {.columns = many}), std::invalid_argument);
  many.resize(57);
  EXPECT_NO_THROW(glbOf({}, {.columns = many}));
}

TEST(Glb, AnEmptyMeshIsStillAFile) {
  const Json json = Json::parse(glbOf({}).substr(20, 4096).substr(0, glbOf({}).size() - 28));
  EXPECT_FALSE(json.contains("meshes"));
}

// ---- reading -------------------------------------------------------------------------------------------------------

std::string base64(const std::string& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : kDigits[bits >> (18 - 6 * k) & 63];
  }
  return text;
}

template <class Number>
std::string packedNumbers(std::initializer_list<Number> numbers) {
  return std::string(reinterpret_cast<const char*>(numbers.begin()), numbers.size() * sizeof(Number));
}

/// A tetrahedron with four points, in one buffer: 48 bytes of positions, 12 of indices.
const std::string kTetrahedron = packedNumbers<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}) +
                                 packedNumbers<std::uint8_t>({0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3});

Json tetrahedron() {
  return Json::parse(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                  {"bufferView": 1, "componentType": 5121, "count": 12, "type": "SCALAR"}],
    "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
    "buffers": [{"byteLength": 60, "uri": "data:application/octet-stream;base64,)" +
                     base64(kTetrahedron) + "\"}]}");
}

Mesh readJson(const Json& json) {
  const TemporaryFolder folder;
  return readMesh(folder.write("a.gltf", json.dump()));
}

void expectRefused(const Json& json, const std::string& why) {
  try {
    readJson(json);
    ADD_FAILURE() << "read: " << json.dump();
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
  }
}

// Promise: Points whose coordinates are not ...
TEST(Gltf, PointsThatNoTriangleUsesNeedNotBeFinite) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::string lost = packedNumbers<float>({nan, 0, 0, 0, nan, 1});
  const auto with = [&](const std::string& indices) {
    Json json = tetrahedron();
    json["buffers"][0] = {
        {"byteLength", 84},
        {"uri", "data:application/octet-stream;base64," + base64(kTetrahedron.substr(0, 48) + lost + indices)}};
    json["bufferViews"] = {{{"buffer", 0}, {"byteLength", 72}},
                           {{"buffer", 0}, {"byteOffset", 72}, {"byteLength", 12}}};
    json["accessors"][0]["count"] = 6;
    return json;
  };
  const Mesh clean = readJson(tetrahedron()), mesh = readJson(with(kTetrahedron.substr(48)));
  EXPECT_EQ(mesh.points, clean.points);
  EXPECT_EQ(mesh.triangles, clean.triangles);
  EXPECT_EQ(mesh.pointsLeftOut, 2U);
  expectRefused(with(packedNumbers<std::uint8_t>({0, 2, 1, 0, 1, 3, 1, 2, 5, 2, 0, 3})), "point 5");
}

// Promise of handoff.md: GLB and glTF as targets: "joined where the nodes place them, and welded"; geometry that Draco
//   or meshoptimizer has compressed "is read"
TEST(Gltf, NodesPlaceTheirMeshes) {
  Json json = tetrahedron();
  const double half = std::sqrt(0.5);
  json["nodes"] = Json::array({{{"children", {1, 2}}, {"translation", {10, 0, 0}}},
                               // A quarter turn about z, then twice the size.
                               {{"mesh", 0}, {"rotation", {0, 0, half, half}}, {"scale", {2, 2, 2}}},
                               {{"mesh", 0}, {"matrix", {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1}}}});
  const Mesh mesh = readJson(json);
  ASSERT_EQ(mesh.points.size(), 8u);
  EXPECT_LT((mesh.points[1] - Vec3d(10, 2, 0)).length(), 1e-12);
  EXPECT_LT((mesh.points[2] - Vec3d(8, 0, 0)).length(), 1e-12);
  EXPECT_EQ(mesh.points[5], Vec3d(9, 0, 5)) << "mirrored";
  const MeshReport report = reportMesh(mesh);
  EXPECT_TRUE(report.closed());
  EXPECT_NEAR(report.volume, (8 + 1) / 6.0, 1e-12) << "a mirrored mesh keeps its orientation";
}

// Promise of handoff.md: "A node with instances (`EXT_mesh_gpu_instancing`) counts once for each of them"
TEST(Gltf, InstancesAreNodes) {
  // Two instances, moved, turned and scaled: the same surface as that of two nodes.
  const float half = std::sqrt(0.5F);
  const std::string places = packedNumbers<float>({5, 0, 0, 0, 7, 0}) +
                             packedNumbers<float>({0, 0, half, half, 0, 0, 0, 1}) +
                             packedNumbers<float>({2, 2, 2, 1, 1, 3});
  Json instanced = tetrahedron();
  instanced["nodes"][0]["translation"] = {0, 0, 10};
  instanced["nodes"][0]["extensions"] = {
      {"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", 2}, {"ROTATION", 3}, {"SCALE", 4}}}}}};
  instanced["buffers"].push_back(
      {{"byteLength", places.size()}, {"uri", "data:application/octet-stream;base64," + base64(places)}});
  for (const auto& [offset, size, type] : {std::tuple(0, 24, "VEC3"), {24, 32, "VEC4"}, {56, 24, "VEC3"}}) {
    instanced["bufferViews"].push_back({{"buffer", 1}, {"byteOffset", offset}, {"byteLength", size}});
    instanced["accessors"].push_back(
        {{"bufferView", instanced["bufferViews"].size() - 1}, {"componentType", 5126}, {"count", 2}, {"type", type}});
  }
  Json nodes = tetrahedron();
  const double turn = static_cast<double>(half);
  nodes["nodes"] =
      Json::array({{{"children", {1, 2}}, {"translation", {0, 0, 10}}},
                   {{"mesh", 0}, {"translation", {5, 0, 0}}, {"rotation", {0, 0, turn, turn}}, {"scale", {2, 2, 2}}},
                   {{"mesh", 0}, {"translation", {0, 7, 0}}, {"scale", {1, 1, 3}}}});
  const Mesh one = readJson(instanced), other = readJson(nodes);
  EXPECT_EQ(one.triangles, other.triangles);
  EXPECT_EQ(one.points, other.points);

  for (const auto& [path, value, why] :
       {std::tuple("/nodes/0/extensions/EXT_mesh_gpu_instancing", Json(7), "attributes"),
        {"/accessors/3/count", Json(1), "instances"},
        {"/accessors/2/type", Json("VEC2"), "instances"},
        {"/accessors/4/count", Json(9), "does not lie within"}}) {
    Json bad = instanced;
    bad[Json::json_pointer(path)] = value;
    expectRefused(bad, why);
  }
}

// Promise: GLB and glTF as targets: "joined ..."
TEST(Gltf, CornersOfSeamsAreJoined) {
  // Each triangle has points of its own.
  Json json = tetrahedron();
  std::string soup;
  for (std::size_t i = 0; i < 12; ++i)
    soup += kTetrahedron.substr(12 * static_cast<unsigned char>(kTetrahedron[48 + i]), 12);
  json["buffers"][0] = {{"byteLength", 144}, {"uri", "data:;base64," + base64(soup)}};
  json["bufferViews"] = Json::array({{{"buffer", 0}, {"byteLength", 144}}});
  json["accessors"] = Json::array({{{"bufferView", 0}, {"componentType", 5126}, {"count", 12}, {"type", "VEC3"}}});
  json["meshes"][0]["primitives"][0].erase("indices");
  const Mesh mesh = readJson(json);
  EXPECT_EQ(mesh.points.size(), 4u);
  EXPECT_TRUE(reportMesh(mesh).closed());
}

TEST(Gltf, StripsAndFansAreTriangles) {
  for (const int mode : {5, 6}) {
    Json json = tetrahedron();
    json["meshes"][0]["primitives"][0]["mode"] = mode;
    // The strip of four triangles around a tetrahedron; the fan of three about its first point.
    const std::string corners =
        mode == 5 ? packedNumbers<std::uint8_t>({0, 2, 1, 3, 0, 2}) : packedNumbers<std::uint8_t>({0, 1, 3, 2, 1, 0});
    json["buffers"][0]["uri"] = "data:;base64," + base64(kTetrahedron.substr(0, 48) + corners + std::string(6, '\0'));
    json["accessors"][1]["count"] = mode == 5 ? 6 : 5;
    const MeshReport report = reportMesh(readJson(json));
    EXPECT_EQ(report.triangles, mode == 5 ? 4u : 3u);
    EXPECT_EQ(report.misorientedEdges, 0u);
    if (mode == 5) {
      EXPECT_TRUE(report.closed());
      EXPECT_NEAR(report.volume, 1 / 6.0, 1e-12);
    }
  }
}

TEST(Gltf, ColoursMayBeIntegersAndLackInSomeParts) {
  Json json = tetrahedron();
  json["buffers"].push_back(
      {{"byteLength", 32},
       {"uri", "data:;base64," + base64(packedNumbers<std::uint16_t>(
                                     {0, 13107, 65535, 1, 0, 0, 0, 65535, 0, 0, 0, 0, 65535, 0, 0, 0}))}});
  json["bufferViews"].push_back({{"buffer", 1}, {"byteLength", 32}});
  json["accessors"].push_back(
      {{"bufferView", 2}, {"componentType", 5123}, {"count", 4}, {"type", "VEC4"}, {"normalized", true}});
  json["meshes"].push_back(json["meshes"][0]);
  json["meshes"][1]["primitives"][0]["attributes"]["COLOR_0"] = 2;
  json["nodes"] = Json::array({{{"mesh", 0}}, {{"mesh", 1}, {"translation", {5, 0, 0}}}});
  json["scenes"][0]["nodes"] = {0, 1};
  const Mesh mesh = readJson(json);
  ASSERT_EQ(mesh.attributes.size(), 4u);
  EXPECT_EQ(mesh.attributes[1].name, "green");
  EXPECT_EQ(mesh.attributes[1].values, (std::vector<float>{1, 1, 1, 1, 0.2F, 0, 0, 0}));
  EXPECT_EQ(mesh.attributes[3].name, "alpha");
}

// Promise: GLB and glTF as targets: "joined ..."
TEST(Gltf, BuffersLieBesideTheFileOnly) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "sub");
  folder.write("a b.bin", kTetrahedron);
  folder.write("sub/c.bin", kTetrahedron);
  Json json = tetrahedron();
  const auto read = [&](const std::string& uri) {
    json["buffers"][0]["uri"] = uri;
    return readMesh(folder.write("sub.gltf", json.dump())).triangles.size();
  };
  EXPECT_EQ(read("a%20b.bin"), 4u);
  EXPECT_EQ(read("sub/c.bin"), 4u);
  for (const std::string& uri : {"../" + folder.path().filename().string() + "/a b.bin",
                                 (folder.path() / "a b.bin").string(), std::string("file:///etc/hostname"),
                                 std::string("sub/../a b.bin"), std::string("%2e%2e/a b.bin"), std::string()})
    EXPECT_THROW(read(uri), DataError) << uri;
  EXPECT_THROW(read("none.bin"), MissingInputError);
}

// Promise: GLB and glTF as targets: "joined ..."
TEST(Gltf, WhatCannotBeIsRefused) {
  const auto changed = [](const std::function<void(Json&)>& change) {
    Json json = tetrahedron();
    change(json);
    return json;
  };
  expectRefused(changed([](Json& j) { j["accessors"][0]["count"] = 5; }), "within");
  expectRefused(changed([](Json& j) { j["accessors"][0]["count"] = 18446744073709551615u; }), "within");
  expectRefused(changed([](Json& j) { j["accessors"][0]["count"] = -1; }), "whole number");
  expectRefused(changed([](Json& j) { j["accessors"][0]["byteOffset"] = 1e15; }), "within");
  expectRefused(changed([](Json& j) { j["accessors"][0]["type"] = "MAT9"; }), "type");
  expectRefused(changed([](Json& j) { j["accessors"][1]["componentType"] = 5126; }), "within");
  expectRefused(changed([](Json& j) { j["bufferViews"][0]["byteOffset"] = 18446744073709551615u; }), "within");
  expectRefused(changed([](Json& j) { j["bufferViews"][0]["buffer"] = 7; }), "buffer 7");
  expectRefused(changed([](Json& j) { j["buffers"][0]["byteLength"] = 4000000000u; }), "bytes");
  expectRefused(changed([](Json& j) { j["buffers"][0].erase("uri"); }), "no content");
  expectRefused(changed([](Json& j) { j["nodes"][0]["mesh"] = 3; }), "meshes");
  expectRefused(changed([](Json& j) { j["nodes"][0]["children"] = {0}; }), "twice");
  expectRefused(changed([](Json& j) { j["scenes"][0]["nodes"] = {0, 0}; }), "twice");
  expectRefused(changed([](Json& j) { j["nodes"][0]["matrix"] = {1, 2}; }), "16 numbers");
  expectRefused(changed([](Json& j) { j["scenes"][0]["nodes"] = Json::array(); }), "no triangle");
  expectRefused(changed([](Json& j) { j["meshes"][0]["primitives"][0]["mode"] = 1; }), "no triangle");
  expectRefused(changed([](Json& j) { j["accessors"][0]["sparse"] = Json::object(); }), "sparse");
  expectRefused(changed([](Json& j) {
                  j["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = Json::object();
                }),
                "without compression");
  expectRefused(Json::array(), "no 'asset'");
  // A small file that shows one mesh very often.
  expectRefused(changed([](Json& j) {
                  const std::string zeros(1 << 20, '\0');
                  j["buffers"][0] = {{"byteLength", zeros.size()}, {"uri", "data:;base64," + base64(zeros)}};
                  j["bufferViews"] = Json::array({{{"buffer", 0}, {"byteLength", zeros.size()}}});
                  j["accessors"] = Json::array(
                      {{{"bufferView", 0}, {"componentType", 5126}, {"count", zeros.size() / 12}, {"type", "VEC3"}}});
                  j["meshes"][0]["primitives"] = Json::array();
                  for (int i = 0; i < 10000; ++i)
                    j["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 6}});
                }),
                "so often");
}

/// Extras may be anything. What is nested so deeply that it would exhaust the stack is refused instead.
TEST(Gltf, NestingIsHarmless) {
  const auto nested = [](std::size_t levels) {
    std::string text = tetrahedron().dump();
    text.back() = ',';
    return text + "\"extras\":" + std::string(levels, '[') + std::string(levels, ']') + '}';
  };
  const TemporaryFolder folder;
  EXPECT_EQ(readMesh(folder.write("a.gltf", nested(90))).triangles.size(), 4u);
  EXPECT_THROW(readMesh(folder.write("b.gltf", nested(100'000))), DataError);
}

// Promise: "A file that is broken, or made ..."
TEST(Gltf, BrokenFilesAreRefusedOrRead) {
  const Made made;
  const std::vector<std::string> files = {
      glbOf(test_meshes::makeSphere(1, 1), {.columns = {{"Cd", ColumnKind::LinearRgb}}, .levels = {0.5}},
            std::vector<float>(3 * 42, 0.5F)),
      tetrahedron().dump()};
  const TemporaryFolder folder;
  std::mt19937 random(3);
  int refused = 0;
  for (const std::string& file : files) {
    const char* name = file.front() == 'g' ? "a.glb" : "a.gltf";
    for (int i = 0; i < 3000; ++i) {
      std::string broken = file;
      if (i % 3 == 0) {
        broken.resize(random() % file.size());
      } else {
        // Most of the bytes that matter are in the head and in the JSON.
        for (unsigned n = 1 + random() % 3; n > 0; --n) {
          char& byte = broken[random() % std::min<std::size_t>(file.size(), 2500)];
          byte = i % 3 == 1 ? static_cast<char>(random()) : "0123456789-{}[],\""[random() % 17];
        }
      }
      try {
        const Mesh mesh = readMesh(folder.write(name, broken));
        for (const Vec3I& t : mesh.triangles)
          for (int k = 0; k < 3; ++k) ASSERT_LT(t[k], mesh.points.size());
        reportMesh(mesh);
      } catch (const DataError&) {
        ++refused;
      } catch (const MissingInputError&) {
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 3000);
}

}  // namespace
