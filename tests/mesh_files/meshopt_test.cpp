// SPDX-License-Identifier: Apache-2.0
// glTF that meshoptimizer has compressed (EXT_meshopt_compression), and quantised (KHR_mesh_quantization).
#include "support/temporary_folder.h"
#include "support/test_meshes.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/mesh_files/mesh_reader.h"

#include <gtest/gtest.h>
#include <meshoptimizer.h>
#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <string>
#include <vector>

namespace {

using vdbtools::Mesh;
using Json = nlohmann::json;

template <class Number>
std::string bytesOf(const std::vector<Number>& numbers) {
  return std::string(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number));
}

std::string vertexCode(const std::string& bytes, std::size_t stride) {
  const std::size_t count = bytes.size() / stride;
  std::string code(meshopt_encodeVertexBufferBound(count, stride), '\0');
  code.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(code.data()), code.size(), bytes.data(),
                                         count, stride));
  return code;
}

std::vector<std::uint32_t> cornersOf(const Mesh& mesh) {
  std::vector<std::uint32_t> corners;
  for (const openvdb::Vec3I& t : mesh.triangles) corners.insert(corners.end(), {t[0], t[1], t[2]});
  return corners;
}

std::string triangleCode(const Mesh& mesh) {
  const std::vector<std::uint32_t> corners = cornersOf(mesh);
  std::string code(meshopt_encodeIndexBufferBound(corners.size(), mesh.points.size()), '\0');
  code.resize(meshopt_encodeIndexBuffer(reinterpret_cast<unsigned char*>(code.data()), code.size(), corners.data(),
                                        corners.size()));
  return code;
}

std::string sequenceCode(const Mesh& mesh) {
  const std::vector<std::uint32_t> corners = cornersOf(mesh);
  std::string code(meshopt_encodeIndexSequenceBound(corners.size(), mesh.points.size()), '\0');
  code.resize(meshopt_encodeIndexSequence(reinterpret_cast<unsigned char*>(code.data()), code.size(), corners.data(),
                                          corners.size()));
  return code;
}

/// A GLB with two parts in its binary chunk: of points, and of corners.
struct Glb {
  Json json =
      Json::parse(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "extensionsRequired": ["EXT_meshopt_compression"],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3"},
                  {"bufferView": 1, "componentType": 5125, "type": "SCALAR"}],
    "bufferViews": [{"buffer": 1, "extensions": {"EXT_meshopt_compression": {"buffer": 0, "mode": "ATTRIBUTES"}}},
                    {"buffer": 1, "extensions": {"EXT_meshopt_compression": {"buffer": 0, "mode": "TRIANGLES"}}}]})");
  std::string points, corners;

  Json& packed(std::size_t view) { return json["bufferViews"][view]["extensions"]["EXT_meshopt_compression"]; }

  Glb(const Mesh& mesh, std::size_t stride, std::string pointCode, std::string cornerCode)
      : points(std::move(pointCode)), corners(std::move(cornerCode)) {
    const std::size_t count[] = {mesh.points.size(), 3 * mesh.triangles.size()}, strides[] = {stride, 4};
    std::size_t offset = 0;
    for (std::size_t view = 0; view < 2; ++view) {
      json["accessors"][view]["count"] = count[view];
      json["bufferViews"][view]["byteLength"] = count[view] * strides[view];
      json["bufferViews"][view]["byteOffset"] = offset;
      packed(view)["count"] = count[view];
      packed(view)["byteStride"] = strides[view];
      offset += count[view] * strides[view];
    }
    json["bufferViews"][0]["byteStride"] = stride;
    packed(0)["byteLength"] = points.size();
    packed(1)["byteOffset"] = points.size();
    packed(1)["byteLength"] = corners.size();
    json["buffers"] = {{{"byteLength", points.size() + corners.size()}},
                       {{"byteLength", offset}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
  }

  Mesh read() const {
    std::string text = json.dump(), binary = points + corners, bytes = "glTF";
    text.resize((text.size() + 3) / 4 * 4, ' ');
    binary.resize((binary.size() + 3) / 4 * 4, '\0');
    for (const std::uint32_t number : {std::uint32_t{2}, static_cast<std::uint32_t>(28 + text.size() + binary.size()),
                                       static_cast<std::uint32_t>(text.size()), std::uint32_t{0x4E4F534A}})
      bytes += bytesOf<std::uint32_t>({number});
    bytes += text + bytesOf<std::uint32_t>({static_cast<std::uint32_t>(binary.size()), 0x004E4942}) + binary;
    const TemporaryFolder folder;
    return vdbtools::readMesh(folder.write("a.glb", bytes));
  }
};

std::vector<float> floatsOf(const Mesh& mesh) {
  std::vector<float> numbers;
  for (const openvdb::Vec3d& p : mesh.points)
    for (int axis = 0; axis < 3; ++axis) numbers.push_back(static_cast<float>(p[axis]));
  return numbers;
}

Glb plain(const Mesh& mesh) { return {mesh, 12, vertexCode(bytesOf(floatsOf(mesh)), 12), triangleCode(mesh)}; }

/// Whether the surfaces are the same, whichever corner a triangle begins with.
void expectSame(const Mesh& read, const Mesh& mesh, double within) {
  ASSERT_EQ(read.points.size(), mesh.points.size());
  EXPECT_NEAR(reportMesh(read).volume, reportMesh(mesh).volume, 20 * within);
  EXPECT_TRUE(reportMesh(read).closed());
  for (std::size_t i = 0; i < mesh.points.size(); ++i) EXPECT_LE((read.points[i] - mesh.points[i]).length(), within);
}

// Promise: GLB and glTF as targets: "joined ..."
TEST(Meshopt, PointsAndTrianglesAreThoseOfTheMesh) {
  const Mesh mesh = test_meshes::makeSphere(1, 3);
  Glb glb = plain(mesh);
  expectSame(glb.read(), mesh, 1e-6);
  glb = {mesh, 12, vertexCode(bytesOf(floatsOf(mesh)), 12), sequenceCode(mesh)};
  glb.packed(1)["mode"] = "INDICES";
  const Mesh read = glb.read();
  expectSame(read, mesh, 1e-6);
  EXPECT_EQ(read.triangles, mesh.triangles) << "a sequence keeps its order";
}

TEST(Meshopt, PositionsMayBeWholeNumbers) {
  const Mesh mesh = test_meshes::makeSphere(1, 3);
  std::vector<std::int16_t> numbers;
  for (const openvdb::Vec3d& p : mesh.points) {
    for (int axis = 0; axis < 3; ++axis) numbers.push_back(static_cast<std::int16_t>(std::lround(p[axis] * 32767)));
    numbers.push_back(0);
  }
  Glb glb(mesh, 8, vertexCode(bytesOf(numbers), 8), triangleCode(mesh));
  glb.json["extensionsRequired"].push_back("KHR_mesh_quantization");
  glb.json["accessors"][0]["componentType"] = 5122;
  glb.json["accessors"][0]["normalized"] = true;
  expectSame(glb.read(), mesh, 1e-4);
  glb.json["accessors"][0].erase("normalized");
  glb.json["nodes"][0]["scale"] = {1 / 32767.0, 1 / 32767.0, 1 / 32767.0};
  expectSame(glb.read(), mesh, 1e-4);
}

TEST(Meshopt, PositionsMayHaveExponents) {
  const Mesh mesh = test_meshes::makeSphere(1, 3);
  const std::vector<float> floats = floatsOf(mesh);
  std::vector<std::uint32_t> codes;
  for (const float number : floats) {  // 24 bits of a mantissa, 8 of an exponent
    constexpr int kExponent = -20;
    const auto mantissa = static_cast<std::int32_t>(std::lround(std::ldexp(number, -kExponent)));
    codes.push_back((static_cast<std::uint32_t>(kExponent) << 24) | (static_cast<std::uint32_t>(mantissa) & 0xffffff));
  }
  Glb glb(mesh, 12, vertexCode(bytesOf(codes), 12), triangleCode(mesh));
  glb.packed(0)["filter"] = "EXPONENTIAL";
  expectSame(glb.read(), mesh, 1e-5);
}

TEST(Meshopt, WhatDoesNotFitIsRefused) {
  const Mesh mesh = test_meshes::makeSphere(1, 2);
  const auto refused = [&](const auto& change, const std::string& why) {
    Glb glb = plain(mesh);
    change(glb);
    try {
      glb.read();
      ADD_FAILURE() << "read; expected: " << why;
    } catch (const vdbtools::DataError& error) {
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    }
  };
  refused([](Glb& g) { g.packed(0)["byteStride"] = 13; }, "fit together");
  refused([](Glb& g) { g.packed(0)["byteStride"] = 260; }, "fit together");
  refused([](Glb& g) { g.packed(0)["byteStride"] = 0; }, "fit together");
  refused([](Glb& g) { g.packed(0)["filter"] = "OCTAHEDRAL"; }, "fit together");
  refused([](Glb& g) { g.packed(0)["filter"] = "COLOR"; }, "fit together");
  refused([](Glb& g) { g.packed(1)["filter"] = "EXPONENTIAL"; }, "fit together");
  refused([](Glb& g) { g.packed(1)["byteStride"] = 12; }, "fit together");
  refused([](Glb& g) { g.packed(1)["count"] = 4; }, "fit together");
  refused([](Glb& g) { g.packed(0)["mode"] = "TETRAHEDRA"; }, "TETRAHEDRA");
  refused([](Glb& g) { g.packed(0)["count"] = 4'000'000'000; }, "larger than");
  refused([](Glb& g) { g.packed(0)["byteLength"] = 1'000'000; }, "within");
  refused([](Glb& g) { g.packed(0)["count"] = 3; }, "damaged");
  refused([](Glb& g) { g.packed(1)["byteLength"] = g.corners.size() - 20; }, "damaged");
  refused([](Glb& g) { g.points[0] = '\x7f'; }, "later version");
  refused([](Glb& g) { g.json["bufferViews"][0].erase("extensions"); }, "within");
}

TEST(Meshopt, DamagedCodesAreRefusedOrRead) {
  const Mesh mesh = test_meshes::makeSphere(1, 2);
  std::mt19937 random(3);
  for (int i = 0; i < 300; ++i) {
    Glb glb = plain(mesh);
    for (std::string* code : {&glb.points, &glb.corners})
      for (int k = 0; k < 3; ++k) (*code)[random() % code->size()] = static_cast<char>(random());
    try {
      glb.read();
    } catch (const vdbtools::DataError&) {
    }
  }
}

}  // namespace
