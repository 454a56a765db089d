// SPDX-License-Identifier: Apache-2.0
// glTF that Draco has compressed (KHR_draco_mesh_compression). Draco itself makes the files.
#include "mesh_files/draco_decoder.h"
#include "support/temporary_folder.h"
#include "support/test_meshes.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/mesh_files/mesh_reader.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#ifdef TESTS_HAVE_DRACO
#include <draco/compression/expert_encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#endif

#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <vector>

namespace {

using vdbtools::DataError;
using vdbtools::Mesh;
using Json = nlohmann::json;

Json dracoJson(std::size_t points, std::size_t corners, std::size_t bytes) {
  Json json =
      Json::parse(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "extensionsRequired": ["KHR_draco_mesh_compression"],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "_WET": 2}, "indices": 1, "extensions":
      {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0, "_WET": 1}}}}]}],
    "accessors": [{"componentType": 5126, "type": "VEC3"}, {"componentType": 5125, "type": "SCALAR"},
                  {"componentType": 5126, "type": "SCALAR"}],
    "bufferViews": [{"buffer": 0}], "buffers": [{}]})");
  json["accessors"][0]["count"] = json["accessors"][2]["count"] = points;
  json["accessors"][1]["count"] = corners;
  json["bufferViews"][0]["byteLength"] = json["buffers"][0]["byteLength"] = bytes;
  return json;
}

Mesh readDraco(const Json& json, std::string binary) {
  std::string text = json.dump(), glb = "glTF";
  text.resize((text.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  const auto add = [&glb](std::size_t number) {
    const auto word = static_cast<std::uint32_t>(number);
    glb.append(reinterpret_cast<const char*>(&word), sizeof word);
  };
  for (const std::size_t number :
       {std::size_t{2}, 28 + text.size() + binary.size(), text.size(), std::size_t{0x4E4F534A}})
    add(number);
  glb += text;
  add(binary.size());
  add(0x004E4942);
  const TemporaryFolder folder;
  return vdbtools::readMesh(folder.write("a.glb", glb + binary));
}

TEST(Draco, WithoutItFilesAreRefusedByName) {
  if (vdbtools::canDecodeDraco()) GTEST_SKIP() << "this build has Draco";
  try {
    readDraco(dracoJson(3, 3, 40), std::string(40, 'x'));
    ADD_FAILURE() << "read";
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find("KHR_draco_mesh_compression"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("libdraco-dev"), std::string::npos) << error.what();
  }
}

#ifdef TESTS_HAVE_DRACO

/// The code of a mesh with one attribute, which is the x coordinate.
/// @param bits  of a coordinate; 0: floats as they are
std::string dracoCode(const Mesh& mesh, int method, int bits) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(static_cast<int>(mesh.triangles.size()));
  const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32),
            wet = builder.AddAttribute(draco::GeometryAttribute::GENERIC, 1, draco::DT_FLOAT32);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    float corners[3][3], values[3];
    for (int c = 0; c < 3; ++c) {
      for (int axis = 0; axis < 3; ++axis)
        corners[c][axis] = static_cast<float>(mesh.points[mesh.triangles[t][c]][axis]);
      values[c] = corners[c][0];
    }
    const draco::FaceIndex face(static_cast<std::uint32_t>(t));
    builder.SetAttributeValuesForFace(position, face, corners[0], corners[1], corners[2]);
    builder.SetAttributeValuesForFace(wet, face, &values[0], &values[1], &values[2]);
  }
  const std::unique_ptr<draco::Mesh> made = builder.Finalize();
  draco::ExpertEncoder encoder(*made);
  encoder.SetEncodingMethod(method);
  if (bits > 0)
    for (const int attribute : {position, wet}) encoder.SetAttributeQuantization(attribute, bits);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeToBuffer(&buffer).ok());
  return std::string(buffer.data(), buffer.size());
}

// Promise: GLB and glTF as targets: "joined ..."
TEST(Draco, TheSurfaceIsThatOfTheMesh) {
  const Mesh mesh = test_meshes::makeSphere(1, 3);
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING})
    for (const int bits : {0, 14}) {
      const std::string code = dracoCode(mesh, method, bits);
      const Mesh read = readDraco(dracoJson(mesh.points.size(), 3 * mesh.triangles.size(), code.size()), code);
      const vdbtools::MeshReport report = reportMesh(read), known = reportMesh(mesh);
      EXPECT_TRUE(report.closed());
      EXPECT_EQ(report.points, known.points);
      EXPECT_EQ(report.triangles, known.triangles);
      const double within = bits == 0 ? 1e-6 : 1e-3;
      EXPECT_NEAR(report.volume, known.volume, 10 * within);
      ASSERT_EQ(read.attributes.size(), 1U);
      EXPECT_EQ(read.attributes[0].name, "WET");
      for (std::size_t p = 0; p < read.points.size(); ++p)
        ASSERT_NEAR(static_cast<double>(read.attributes[0].values[p]), read.points[p][0], within);
    }
}

TEST(Draco, WhatDoesNotFitIsRefused) {
  const Mesh mesh = test_meshes::makeSphere(1, 2);
  const std::string code = dracoCode(mesh, draco::MESH_EDGEBREAKER_ENCODING, 12);
  const Json json = dracoJson(mesh.points.size(), 3 * mesh.triangles.size(), code.size());
  const auto refused = [&](const auto& change, const std::string& why) {
    Json changed = json;
    std::string bytes = code;
    change(changed, changed["meshes"][0]["primitives"][0], bytes);
    try {
      readDraco(changed, bytes);
      ADD_FAILURE() << "read; expected: " << why;
    } catch (const DataError& error) {
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    }
  };
  constexpr const char* kDraco = "KHR_draco_mesh_compression";
  refused([](Json&, Json& p, std::string&) { p["extensions"][kDraco]["attributes"]["POSITION"] = 7; }, "attribute 7");
  refused([](Json&, Json& p, std::string&) { p["extensions"][kDraco]["attributes"]["POSITION"] = 1; }, "attribute 1");
  refused([](Json&, Json& p, std::string&) { p["extensions"][kDraco]["attributes"]["NORMAL"] = 1; }, "NORMAL");
  refused([](Json&, Json& p, std::string&) { p.erase("indices"); }, "description");
  refused([](Json&, Json& p, std::string&) { p["mode"] = 5; }, "description");
  refused([](Json&, Json& p, std::string&) { p["extensions"][kDraco]["bufferView"] = 1; }, "bufferViews");
  refused([](Json&, Json&, std::string& b) { b[5] = 1; }, "damaged");
  refused([](Json&, Json&, std::string& b) { b.replace(12, 8, "\xff\xff\xff\xff\x0f\xff\xff\xff"); }, "larger than");
  refused([](Json& j, Json&, std::string&) { j["bufferViews"][0]["byteLength"] = 30; }, "damaged");
  refused([](Json& j, Json&, std::string&) { j["bufferViews"][0]["byteLength"] = 3; }, "damaged");
}

TEST(Draco, DamagedCodesAreRefusedOrRead) {
  const Mesh mesh = test_meshes::makeSphere(1, 2);
  std::mt19937 random(5);
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    const std::string code = dracoCode(mesh, method, 12);
    const Json json = dracoJson(mesh.points.size(), 3 * mesh.triangles.size(), code.size());
    for (int i = 0; i < 300; ++i) {
      std::string bytes = code;
      for (int k = 0; k < 3; ++k) bytes[random() % bytes.size()] = static_cast<char>(random());
      try {
        readDraco(json, bytes);
      } catch (const DataError&) {
      }
    }
  }
}

#endif

}  // namespace
