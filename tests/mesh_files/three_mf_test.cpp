// SPDX-License-Identifier: Apache-2.0
// 3MF as it is read: what the program wrote, what others write, and files that are broken.
#include "mesh_files/mesh_formats.h"
#include "support/small_zip.h"
#include "support/temporary_folder.h"
#include "support/test_meshes.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/mesh_files/mesh_writer.h"

#include <gtest/gtest.h>

#include <string>

namespace {

using openvdb::Vec3d;
using vdbtools::DataError;
using vdbtools::Mesh;

const std::string k3mfTetrahedron =
    "<mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1\" y=\"0\" z=\"0\"/><vertex x=\"0\" y=\"1\" "
    "z=\"0\"/>"
    "<vertex x=\"0\" y=\"0\" z=\"1\"/></vertices><triangles><triangle v1=\"0\" v2=\"2\" v3=\"1\"/><triangle v1=\"0\" "
    "v2=\"1\" v3=\"3\"/><triangle v1=\"1\" v2=\"2\" v3=\"3\"/><triangle v1=\"2\" v2=\"0\" "
    "v3=\"3\"/></triangles></mesh>";

std::string object(int id, const std::string& content, const std::string& more = "") {
  return "<object id=\"" + std::to_string(id) + "\" " + more + ">" + content + "</object>";
}

std::string component(int id, const std::string& more = "") {
  return "<component objectid=\"" + std::to_string(id) + "\" " + more + "/>";
}

std::string model(const std::string& resources, const std::string& items, const std::string& more = "") {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?><model "
         "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/"
         "02\" xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\" "
         "xmlns:b=\"http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02\" " +
         more + "><resources>" + resources + "</resources><build>" + items + "</build></model>";
}

std::string item(int id, const std::string& more = "") {
  return "<item objectid=\"" + std::to_string(id) + "\" " + more + "/>";
}

class ThreeMf : public testing::Test {
 protected:
  void SetUp() override {
    if (!vdbtools::canRead3mf()) GTEST_SKIP() << "this build cannot read 3MF";
  }

  Mesh readParts(const std::vector<std::pair<std::string, std::string>>& parts, bool isDeflated = false) const {
    return vdbtools::readMesh(mFolder.write("a.3mf", small_zip::zipOf(parts, isDeflated)));
  }
  Mesh read(const std::string& xml) const { return readParts(small_zip::partsOf3mf(xml)); }

  void expectRefusedFile(std::string_view bytes, const std::string& why) const {
    try {
      vdbtools::readMesh(mFolder.write("bad.3mf", bytes));
      ADD_FAILURE() << "read; expected: " << why;
    } catch (const DataError& error) {
      const std::string text = error.what();
      EXPECT_NE(text.find(why), std::string::npos) << text;
      EXPECT_NE(text.find("bad.3mf"), std::string::npos) << text;
      EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    }
  }
  void expectRefused(const std::string& xml, const std::string& why) const {
    expectRefusedFile(small_zip::zipOf(small_zip::partsOf3mf(xml)), why);
  }

  TemporaryFolder mFolder;
};

// Promise of targets.md: 3MF as a target: "the items of the build with their components and transforms", in its unit
TEST_F(ThreeMf, WhatIsWrittenIsReadBack) {
  const Mesh mesh = test_meshes::transformed(test_meshes::makeSphere(1, 6), 0.1, Vec3d(10, 1.0 / 3, -7));
  const std::string bytes = vdbtools::encode3mf(mesh, {{"a", "<b> & \"c\""}});
  const Mesh read = vdbtools::readMesh(mFolder.write("own.3mf", bytes));
  ASSERT_EQ(read.points.size(), mesh.points.size());
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      ASSERT_EQ(static_cast<float>(read.points[i][axis]), static_cast<float>(mesh.points[i][axis]));
  EXPECT_EQ(read.triangles, mesh.triangles);
  EXPECT_EQ(vdbtools::unitOf3mf("own.3mf", bytes), "mm");
}

// Promise: 3MF as a target: "the items ..."
TEST_F(ThreeMf, KeepsTheNumbersAndSaysTheUnit) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"unit=\"millimeter\"", "mm"}, {"", "mm"},           {"unit=\"centimeter\"", "cm"}, {"unit=\"inch\"", "in"},
      {"unit=\"meter\"", "m"},       {"unit=\"foot\"", ""}};
  for (const auto& [attribute, name] : cases) {
    const std::string bytes =
        small_zip::zipOf(small_zip::partsOf3mf(model(object(1, k3mfTetrahedron), item(1), attribute)));
    EXPECT_EQ(vdbtools::readMesh(mFolder.write("a.3mf", bytes)).points[1], Vec3d(1, 0, 0));
    EXPECT_EQ(vdbtools::unitOf3mf("a.3mf", bytes), name);
  }
}

// Promise: 3MF as a target: "the items ..."
TEST_F(ThreeMf, PlacesComponentsAndItems) {
  // Twice the size, then moved along x; the item turns x to y, y to -x and moves along z.
  const Mesh mesh = read(
      model(object(1, k3mfTetrahedron) +
                object(2, "<components>" + component(1) + component(1, "transform=\"2 0 0 0 2 0 0 0 2 10 0 0\"") +
                              "</components>"),
            item(2, "transform=\"0 1 0 -1 0 0 0 0 1 0 0 5\"") + item(1, "transform=\"-1 0 0 0 1 0 0 0 1 0 0 0\"")));
  ASSERT_EQ(mesh.points.size(), 12U);
  EXPECT_EQ(mesh.points[1], Vec3d(0, 1, 5));
  EXPECT_EQ(mesh.points[5], Vec3d(0, 12, 5));
  EXPECT_EQ(mesh.points[6], Vec3d(-2, 10, 5));
  EXPECT_EQ(mesh.points[9], Vec3d(-1, 0, 0)) << "mirrored";
  const vdbtools::MeshReport report = reportMesh(mesh);
  EXPECT_TRUE(report.closed());
  EXPECT_NEAR(report.volume, (1.0 + 8 + 1) / 6, 1e-12) << "all are oriented outward";
}

// Promise: 3MF as a target: "the items ..."
TEST_F(ThreeMf, ReadsWhatIsBuiltAndNoSupports) {
  const std::string three = object(1, k3mfTetrahedron) + object(2, k3mfTetrahedron, "type=\"support\"") +
                            object(3, k3mfTetrahedron) + object(4, k3mfTetrahedron, "type=\"surface\"");
  EXPECT_EQ(read(model(three, item(1) + item(2) + item(4))).triangles.size(), 8U);
  expectRefused(model(three, ""), "no triangle");
}

TEST_F(ThreeMf, ObjectsMayBeInOtherPartsOfTheFile) {
  auto parts = small_zip::partsOf3mf(model(
      object(7, "<components>" + component(7, "p:path=\"/3D/Objects/a.model\" transform=\"1 0 0 0 1 0 0 0 1 0 0 3\"") +
                    "</components>"),
      item(7) + item(8, "p:path=\"/3d/objects/A.model\""), "requiredextensions=\"p\""));
  parts.emplace_back("3D/Objects/a.model", model(object(7, k3mfTetrahedron) + object(8, k3mfTetrahedron), ""));
  for (const bool isDeflated : {false, true}) {
    const Mesh mesh = readParts(parts, isDeflated);
    ASSERT_EQ(mesh.points.size(), 8U);
    EXPECT_EQ(mesh.points[0], Vec3d(0, 0, 3));
    EXPECT_EQ(mesh.points[4], Vec3d(0, 0, 0));
  }
}

TEST_F(ThreeMf, PointsThatNoTriangleUsesNeedNotBeFinite) {
  const auto with = [](const std::string& vertex) {
    std::string mesh = k3mfTetrahedron;
    return mesh.insert(mesh.find("</vertices>"), vertex);
  };
  const Mesh mesh = read(model(object(1, with("<vertex x=\"nan\" y=\"0\" z=\"1e999\"/>")), item(1)));
  EXPECT_EQ(mesh.points.size(), 4U);
  EXPECT_EQ(mesh.pointsLeftOut, 1U);
  std::string used = k3mfTetrahedron;
  used.replace(used.find("z=\"1\""), 5, "z=\"INF\"");
  expectRefused(model(object(1, used), item(1)), "vertex 3: the coordinate z is inf");
}

TEST_F(ThreeMf, WhatIsBrokenIsRefused) {
  const auto instead = [](const std::string& old, const std::string& now) {
    std::string text = k3mfTetrahedron;
    return model(object(1, text.replace(text.find(old), old.size(), now)), item(1));
  };
  expectRefused(instead("v2=\"2\"", "v2=\"4\""), "refers to vertex 4, but there are only 4");
  expectRefused(instead("v2=\"2\"", "v2=\"-1\""), "'-1'");
  expectRefused(instead("v2=\"2\"", "v2=\"99999999999\""), "'99999999999'");
  expectRefused(instead("v2=\"2\"", ""), "has no 'v2'");
  expectRefused(instead("x=\"1\"", "x=\"one\""), "'one'");
  expectRefused(instead("</triangles>", ""), "line 1: it is not valid XML");
  expectRefused(model(object(1, k3mfTetrahedron), item(2)), "object 2 is used, but there is none");
  expectRefused(model(object(1, k3mfTetrahedron) + object(1, k3mfTetrahedron), item(1)),
                "two objects with the number 1");
  for (const std::string transform : {"1 0 0", "1 0 0 0 1 0 0 0 1 0 0 0 0", "1 0 0 0 1 0 0 0 1 0 0 nan", ""})
    expectRefused(model(object(1, k3mfTetrahedron), item(1, "transform=\"" + transform + "\"")), "12 numbers");
  expectRefused(model(object(1, k3mfTetrahedron), item(1), "requiredextensions=\"p b\""), "beamlattice");
  expectRefused(model(object(1, k3mfTetrahedron), item(1), "requiredextensions=\"x\""), "extension");
  expectRefused("<!DOCTYPE m [<!ENTITY a \"b\">]>" + model(object(1, k3mfTetrahedron), item(1)).substr(38),
                "document type");
  expectRefused(model(object(1, "<components>" + component(1) + "</components>"), item(1)), "levels");
  expectRefused(model(object(1, k3mfTetrahedron), item(1, "name=\"" + std::string(3 << 20, 'a') + "\"")),
                "does not end");
  std::string outer = instead("v2=\"2\"", "v2=\"9\"");
  expectRefused(outer.insert(outer.find("</mesh>"), object(2, "")), "within another");
  const std::string other = "p:path=\"/3D/none.model\"";
  expectRefused(model(object(1, "<components>" + component(1, other) + "</components>"), item(1)), "'3D/none.model'");
  expectRefusedFile("PK, but no zip", "zip");
  expectRefusedFile(small_zip::zipOf({{"word/document.xml", "<w/>"}}), "'_rels/.rels'");
  expectRefusedFile(small_zip::zipOf({{"_rels/.rels", "<Relationships/>"}}), "names no 3D model");
  std::string damaged = vdbtools::encode3mf(test_meshes::makeSphere(1, 2));
  for (std::size_t i = 0; i < 60; ++i) damaged[damaged.size() / 2 + i] = static_cast<char>(i);
  expectRefusedFile(damaged, "bad.3mf");
}

TEST_F(ThreeMf, ACutFileIsRefusedWhereverItEnds) {
  const std::string whole = vdbtools::encode3mf(test_meshes::makeCube());
  for (std::size_t size = 1; size < whole.size(); size += 7)
    expectRefusedFile(std::string_view(whole).substr(0, size), "bad.3mf");
}

TEST_F(ThreeMf, SmallFilesDoNotBecomeLargeMeshes) {
  // 2^40 tetrahedra, and as many objects without any.
  for (const std::string& first : {k3mfTetrahedron, std::string()}) {
    std::string objects = object(1, first);
    for (int i = 2; i <= 41; ++i)
      objects += object(i, "<components>" + component(i - 1) + component(i - 1) + "</components>");
    expectRefused(model(objects, item(41)), "so often");
  }
  std::string items;
  for (int i = 0; i < 1'000'000; ++i) items += item(1);
  expectRefusedFile(small_zip::zipOf(small_zip::partsOf3mf(model(object(1, ""), items)), true), "1000000 objects");
  // Deflate shrinks spaces to a thousandth.
  const std::string blanks(std::size_t{90} << 20, ' ');
  expectRefusedFile(small_zip::zipOf(small_zip::partsOf3mf(model(blanks + object(1, k3mfTetrahedron), item(1))), true),
                    "times as large");
}

}  // namespace
