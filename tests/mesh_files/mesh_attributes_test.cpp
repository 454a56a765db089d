// SPDX-License-Identifier: Apache-2.0
// What files say of points and corners besides their place: read from each format that has it, and kept by what
// follows.
#include "support/temporary_folder.h"
#include "support/test_meshes.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh_files/mesh_reader.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>

namespace {

using namespace test_meshes;
using openvdb::Vec2s;
using vdbtools::DataError;
using vdbtools::readMesh;
using vdbtools::weldMesh;
using Values = std::vector<float>;

std::vector<std::string> namesOf(const Mesh& mesh) {
  std::vector<std::string> names;
  for (const vdbtools::VertexAttribute& attribute : mesh.attributes) {
    names.push_back(attribute.name);
    EXPECT_EQ(attribute.values.size(), mesh.points.size()) << attribute.name;
  }
  return names;
}

void expectNone(const Mesh& mesh) {
  EXPECT_TRUE(mesh.attributes.empty());
  EXPECT_TRUE(mesh.cornerUvs.empty());
}

Mesh readText(const std::string& name, const std::string& contents) {
  const TemporaryFolder folder;
  return readMesh(folder.write(name, contents));
}

const std::string kPlyStart = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n";
const std::string kPlyEnd = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";

TEST(MeshAttributes, ThereAreNoneWhereTheFileHasNone) {
  expectNone(readText("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n"));
  // Normals are no attributes.
  expectNone(readText("a.ply", kPlyStart +
                                   "property float nx\nproperty float z\nproperty float ny\nproperty float nz\n" +
                                   kPlyEnd + "0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n"));
}

/// Two squares side by side, of four triangles: the middle edge has faces of both.
const std::string kTwoSquares =
    "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 9 9 9\n"
    "g left part\nusemtl stone age\nf 1 2 5\nusemtl stone age\nf 1 5 4\ng right\nusemtl moss:1\nf 2 3 6\nf 2 6 5\n";

const Values& valuesOf(const Mesh& mesh, const std::string& name) {
  static const Values none;
  for (const vdbtools::VertexAttribute& attribute : mesh.attributes)
    if (attribute.name == name) return attribute.values;
  ADD_FAILURE() << "there is no attribute " << name;
  return none;
}

// Promise of controls.md: "`material_NAME` and `group_NAME` are the share of the faces at a point that have this name"
TEST(MeshAttributes, MaterialsAndGroupsOfObjAreSharesOfFaces) {
  const Mesh mesh = readText("a.obj", "mtllib nowhere.mtl\n" + kTwoSquares);
  EXPECT_EQ(namesOf(mesh),
            (std::vector<std::string>{"material_stone", "material_moss_1", "group_left", "group_right"}));
  // Point 2 has a face on the left and two on the right, point 5 two and one; point 7 has none.
  const float third = 1.0F / 3;
  EXPECT_EQ(valuesOf(mesh, "group_left"), (Values{1, third, 0, 1, 2.0F / 3, 0, 0}));
  for (std::size_t p = 0; p < 6; ++p)
    EXPECT_FLOAT_EQ(valuesOf(mesh, "group_left")[p] + valuesOf(mesh, "group_right")[p], 1);
  EXPECT_EQ(valuesOf(mesh, "material_stone"), valuesOf(mesh, "group_left"));
  EXPECT_EQ(mesh.faceNames.materials, (std::vector<std::string>{"stone", "moss:1"}));
  EXPECT_EQ(mesh.faceNames.groups, (std::vector<std::string>{"left", "right"}));
  EXPECT_EQ(weldMesh(mesh).faceNames.materials, mesh.faceNames.materials);
  EXPECT_EQ(valuesOf(mesh, "material_moss_1"), valuesOf(mesh, "group_right"));
  // What all faces share says nothing.
  expectNone(readText("b.obj", "g all\nusemtl one\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
  // Faces may precede their points, and a name may come back.
  const Mesh again = readText("c.obj", "g a\nf 1 2 3\ng b\nf 1 3 2\ng a\nf 2 1 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n");
  EXPECT_EQ(namesOf(again), (std::vector<std::string>{"group_a", "group_b"}));
  EXPECT_EQ(valuesOf(again, "group_a"), (Values{2.0F / 3, 2.0F / 3, 2.0F / 3}));
}

// Promise: "`material_NAME` and `group_NAME` are the share ..."
TEST(MeshAttributes, ManyGroupsAreNotAttributes) {
  std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (int group = 0; group < 1000; ++group) obj += "g part" + std::to_string(group) + "\nf 1 2 3\n";
  EXPECT_EQ(readText("a.obj", obj).attributes.size(), 32U);
}

// Promise of controls.md: "`red`, `green` and `blue` are the mean of the diffuse colours (`Kd`) of the faces at a
//   point"
TEST(MeshAttributes, ColoursOfALibraryAreTheMeanOfFaces) {
  const TemporaryFolder folder;
  folder.write("a b.mtl", "# made by hand\nnewmtl stone\nKa 9 9 9\nKd 0.5 0.25 1\nnewmtl moss:1\nKd 0.25\n");
  const Mesh mesh = readMesh(folder.write("a.obj", "mtllib a b.mtl\n" + kTwoSquares));
  EXPECT_EQ(namesOf(mesh), (std::vector<std::string>{"red", "green", "blue", "material_stone", "material_moss_1",
                                                     "group_left", "group_right"}));
  EXPECT_EQ(valuesOf(mesh, "red"), (Values{0.5F, 1.0F / 3, 0.25F, 0.5F, 1.25F / 3, 0.25F, 1}));
  EXPECT_EQ(valuesOf(mesh, "blue")[0], 1);
  // Colours behind the points come first, and a library elsewhere is not read.
  const Mesh painted =
      readMesh(folder.write("p.obj", "mtllib a b.mtl\nv 0 0 0 0 0 1\nv 1 0 0\nv 0 1 0\nusemtl stone\nf 1 2 3\n"));
  EXPECT_EQ(valuesOf(painted, "red"), (Values{0, 1, 1}));
  std::filesystem::create_directories(folder.path() / "below");
  EXPECT_EQ(namesOf(readMesh(folder.write("below/a.obj", "mtllib ../a b.mtl\n" + kTwoSquares))).front(),
            "material_stone");
  for (const char* bad :
       {"newmtl stone\nKd 0.5 x 1\n", "Kd 1 1 1\n", "newmtl stone\nKd nan 0 0\n", "newmtl stone\nKd\n"}) {
    folder.write("a b.mtl", bad);
    EXPECT_THROW(readMesh(folder.path() / "a.obj"), DataError) << bad;
  }
}

// Promise: Attributes and pictures have ...
TEST(MeshAttributes, AreTheNumbersOfPlyVertices) {
  const Mesh mesh = readText(
      "a.ply", kPlyStart +
                   "property uchar red\nproperty ushort green\nproperty float blue\nproperty float z\nproperty double "
                   "wetness\nproperty list uchar float tags\nproperty uchar label\n" +
                   kPlyEnd +
                   "0 0 255 0 0.25 7 1e-3 2 5 6 3\n1 0 51 65535 2 7 nan 0 200\n0 1 0 13107 -1 7 3 1 9 0\n3 0 1 2\n");
  EXPECT_EQ(namesOf(mesh), (std::vector<std::string>{"red", "green", "blue", "wetness", "label"}));
  EXPECT_EQ(mesh.attributes[0].values, (Values{1, 0.2F, 0}));
  EXPECT_EQ(mesh.attributes[1].values, (Values{0, 1, 0.2F}));
  EXPECT_EQ(mesh.attributes[2].values, (Values{0.25F, 2, -1})) << "floats are what they are";
  EXPECT_EQ(mesh.attributes[3].values[0], 1e-3F);
  EXPECT_TRUE(std::isnan(mesh.attributes[3].values[1])) << "what nobody uses need not be finite";
  EXPECT_EQ(mesh.attributes[4].values, (Values{3, 200, 0})) << "only colours are shares of 255";
  EXPECT_EQ(mesh.points[2], Vec3d(0, 1, 7));
  EXPECT_TRUE(mesh.cornerUvs.empty());
}

TEST(MeshAttributes, AreTheSameInBinaryPlyOfEitherEnd) {
  for (const bool big : {false, true}) {
    std::string ply = "ply\nformat binary_" + std::string(big ? "big" : "little") +
                      "_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty "
                      "uchar alpha\nproperty ushort red\nproperty double heat\n" +
                      kPlyEnd;
    const auto add = [&](auto value) {
      char bytes[sizeof value];
      std::memcpy(bytes, &value, sizeof value);
      if (big == (std::endian::native == std::endian::little)) std::reverse(bytes, bytes + sizeof value);
      ply.append(bytes, sizeof value);
    };
    for (int p = 0; p < 3; ++p) {
      for (int c = 0; c < 3; ++c) add(c == p ? 1.0F : 0.0F);
      add(static_cast<std::uint8_t>(51 * p));
      add(static_cast<std::uint16_t>(13107 * p));
      add(1.5 * p);
    }
    add(std::uint8_t{3});
    for (const std::int32_t corner : {0, 1, 2}) add(corner);
    const Mesh mesh = readText("a.ply", ply);
    EXPECT_EQ(namesOf(mesh), (std::vector<std::string>{"alpha", "red", "heat"}));
    EXPECT_EQ(mesh.attributes[0].values, (Values{0, 0.2F, 0.4F}));
    EXPECT_EQ(mesh.attributes[1].values, (Values{0, 0.2F, 0.4F}));
    EXPECT_EQ(mesh.attributes[2].values, (Values{0, 1.5F, 3}));
  }
}

// Promise: Attributes and pictures have ...
// Promise: "`luminance` is 0.2126 red ..."
TEST(MeshAttributes, AreTheColoursOfObjPoints) {
  const Mesh mesh =
      readText("a.obj", "v 0 0 0\nv 1 0 0 0.5 0.25 0\nv 0 1 0 1.0\nv 1 1 0 0 1 0.125\nv 5 5 5\nf 1 2 3\n");
  EXPECT_EQ(namesOf(mesh), (std::vector<std::string>{"red", "green", "blue"}));
  // White where no colour stands; a single number is a weight.
  EXPECT_EQ(mesh.attributes[0].values, (Values{1, 0.5F, 1, 0, 1}));
  EXPECT_EQ(mesh.attributes[1].values, (Values{1, 0.25F, 1, 1, 1}));
  EXPECT_EQ(mesh.attributes[2].values, (Values{1, 0, 1, 0.125F, 1}));
  EXPECT_THROW(readText("a.obj", "v 0 0 0 red green blue\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), DataError);
}

/// The texture coordinates of a triangle's corner at a point.
Vec2s uvAt(const Mesh& mesh, std::size_t triangle, std::uint32_t point) {
  for (int c = 0; c < 3; ++c)
    if (mesh.triangles[triangle][c] == point) return mesh.cornerUvs[3 * triangle + static_cast<std::size_t>(c)];
  ADD_FAILURE() << "triangle " << triangle << " has no corner at point " << point;
  return {};
}

// Two squares share an edge, whose points have other texture coordinates in each: a seam.
// Promise: A picture is read "through ..."
TEST(MeshAttributes, CornersOfObjKeepTheirSideOfASeam) {
  const Mesh mesh = readText("a.obj",
                             "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\n"
                             "vt 0 0\nvt 0.5 0 0\nvt 0.5 1\nvt 0 1\nvt 0.75\n"
                             "f 1/1 2/2 5/3 4/4\n"
                             "f 2/-1/7 3/-4 6/-3 5/-2\n");
  ASSERT_EQ(mesh.triangles.size(), 4U);
  ASSERT_EQ(mesh.cornerUvs.size(), 12U);
  for (const std::size_t triangle : {0, 1}) {
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t point = mesh.triangles[triangle][c];
      const Vec3d& p = mesh.points[point];
      EXPECT_EQ(uvAt(mesh, triangle, point), Vec2s(static_cast<float>(p[0] / 2), static_cast<float>(p[1])));
    }
  }
  const std::map<std::uint32_t, Vec2s> second{{1, {0.75F, 0}}, {2, {0.5F, 0}}, {5, {0.5F, 1}}, {4, {0, 1}}};
  for (const std::size_t triangle : {2, 3})
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t point = mesh.triangles[triangle][c];
      EXPECT_EQ(uvAt(mesh, triangle, point), second.at(point));
    }
}

TEST(MeshAttributes, ConcaveFacesAndRepeatedCornersKeepTheirTextureCoordinates) {
  // The dart is clipped by ears; one corner of the second face is repeated.
  const Mesh mesh = readText("a.obj",
                             "v -2 -1 0\nv 0 0 0\nv 2 -1 0\nv 0 3 0\nv 4 4 0\n"
                             "vt 1 1\nvt 2 2\nvt 3 3\nvt 4 4\nvt 5 5\nvt 6 6\n"
                             "f 1/1 2/2 3/3 4/4\nf 3/3 5/5 5/6 4/4\nf 1 2 3\n");
  ASSERT_EQ(mesh.triangles.size(), 4U);
  for (std::size_t triangle = 0; triangle < 3; ++triangle)
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t point = mesh.triangles[triangle][c];
      EXPECT_EQ(uvAt(mesh, triangle, point), Vec2s(static_cast<float>(point + 1)));
    }
  for (std::size_t corner = 9; corner < 12; ++corner) EXPECT_TRUE(std::isnan(mesh.cornerUvs[corner][0]));
}

TEST(MeshAttributes, WrongTextureCoordinatesOfObjAreRefused) {
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (const char* rest : {"vt 0 0\nf 1/1 2/2 3/1\n", "vt 0 0\nf 1/1 2/0 3/1\n", "vt 0 0\nf 1/-2 2/1 3/1\n",
                           "vt 0 nan\nf 1/1 2/1 3/1\n", "vt a\nf 1/1 2/1 3/1\n", "vt\nf 1/1 2/1 3/1\n"})
    EXPECT_THROW(readText("a.obj", points + rest), DataError) << rest;
  // Some exporters count on coordinates that they never write.
  expectNone(readText("a.obj", points + "f 1/1 2/2 3/3\n"));
}

// Promise: A picture is read "through ..."
TEST(MeshAttributes, TextureCoordinatesOfPlyVerticesGoToTheCorners) {
  for (const auto& [u, v] : {std::pair("s", "t"), std::pair("u", "v"), std::pair("texture_u", "texture_v")}) {
    const Mesh mesh = readText("a.ply", kPlyStart + "property float z\nproperty float " + v +
                                            "\nproperty float heat\nproperty float " + u + "\n" + kPlyEnd +
                                            "0 0 0 1 7 0.5\n1 0 0 2 8 0.25\n0 1 0 3 9 0.125\n3 2 0 1\n");
    EXPECT_EQ(mesh.cornerUvs, (std::vector<Vec2s>{{0.125F, 3}, {0.5F, 1}, {0.25F, 2}})) << u;
    EXPECT_EQ(namesOf(mesh), (std::vector<std::string>{"heat"}));
    EXPECT_EQ(mesh.attributes[0].values, (Values{7, 8, 9}));
  }
  // One of the two is a number like any other.
  EXPECT_EQ(namesOf(readText("a.ply", kPlyStart + "property float z\nproperty float u\n" + kPlyEnd +
                                          "0 0 0 1\n1 0 0 2\n0 1 0 3\n3 0 1 2\n")),
            (std::vector<std::string>{"u"}));
}

// Promise: A picture is read "through ..."
TEST(MeshAttributes, TextureCoordinatesOfPlyFacesAreTheCorners) {
  const std::string start =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 2\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n"
      "end_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
  const Mesh mesh = readText("a.ply", start + "3 0 1 2 6 0 0 1 0 1 1\n3 0 2 3 0\n");
  ASSERT_EQ(mesh.cornerUvs.size(), 6U);
  EXPECT_EQ(mesh.cornerUvs[1], Vec2s(1, 0));
  EXPECT_EQ(mesh.cornerUvs[2], Vec2s(1, 1));
  EXPECT_TRUE(std::isnan(mesh.cornerUvs[3][0]));
  EXPECT_THROW(readText("a.ply", start + "3 0 1 2 4 0 0 1 0\n3 0 2 3 0\n"), DataError);
  EXPECT_THROW(readText("a.ply", start + "3 0 1 2 5 0 0 1 0 1\n3 0 2 3 0\n"), DataError);
}

TEST(MeshAttributes, WeldingKeepsThem) {
  Mesh soup = makeSoup(makeCube(), 0);
  Values numbers;
  for (std::size_t p = 0; p < soup.points.size(); ++p) {
    numbers.push_back(static_cast<float>(soup.points[p][0] + 10 * soup.points[p][1]));
    soup.cornerUvs.emplace_back(static_cast<float>(p), 0.5F);  // a soup's corners are its points
  }
  soup.attributes = {{"number", numbers}};
  soup.triangles.emplace_back(0, 0, 1);
  soup.cornerUvs.insert(soup.cornerUvs.end(), 3, Vec2s(-1));
  const Mesh welded = weldMesh(soup);
  ASSERT_EQ(welded.points.size(), 8U);
  EXPECT_EQ(namesOf(welded), (std::vector<std::string>{"number"}));
  for (std::size_t p = 0; p < 8; ++p)
    EXPECT_EQ(welded.attributes[0].values[p], static_cast<float>(welded.points[p][0] + 10 * welded.points[p][1]));
  ASSERT_EQ(welded.triangles.size(), 12U);
  ASSERT_EQ(welded.cornerUvs.size(), 36U);
  for (std::size_t corner = 0; corner < 36; ++corner)
    EXPECT_EQ(welded.cornerUvs[corner], Vec2s(static_cast<float>(corner), 0.5F));
}

}  // namespace
