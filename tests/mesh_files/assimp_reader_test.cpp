// SPDX-License-Identifier: Apache-2.0
// FBX, DAE, 3DS and X3D: the same shape in each of them is the same mesh as in an OBJ, where the nodes place it. The
// files are written here.
#include "mesh_files/mesh_formats.h"
#include "support/temporary_folder.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/mesh_files/mesh_writer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace {
/// The other tests of readers have helpers of the same names.
namespace imported {

using openvdb::Vec3d;
using vdbtools::DataError;
using vdbtools::Mesh;
using Polygon = std::vector<int>;

/// Coordinates that are exact as floats and as short texts.
struct Shape {
  std::vector<Vec3d> points;
  std::vector<Polygon> polygons;
};

/// A prism over a polygon that is not convex, of two hexagons and six quadrilaterals.
Shape prism() {
  Shape shape;
  const std::array<std::array<double, 2>, 6> outline = {{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2.5}, {0, 2.5}}};
  for (const double z : {0.0, 0.75})
    for (const auto& [x, y] : outline) shape.points.emplace_back(x, y, z);
  shape.polygons = {{5, 4, 3, 2, 1, 0}, {6, 7, 8, 9, 10, 11}};
  for (int i = 0; i < 6; ++i) shape.polygons.push_back({i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6});
  return shape;
}

/// A 3DS has triangles alone.
Shape tetrahedron() {
  return {{Vec3d(0), Vec3d(1, 0, 0), Vec3d(0, 2, 0), Vec3d(0, 0, 3)}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
}

/// Where a node puts the shape.
struct Place {
  Vec3d move{0, 0, 0};
  Vec3d scale{1, 1, 1};
  Vec3d operator()(const Vec3d& p) const { return p * scale + move; }
};

std::string text(const Vec3d& v, const char* between = " ") {
  std::ostringstream stream;
  stream << v[0] << between << v[1] << between << v[2];
  return stream.str();
}

template <class List, class Text>
std::string joined(const List& list, const char* between, const Text& textOf) {
  std::string result;
  for (const auto& each : list) result += (result.empty() ? "" : between) + textOf(each);
  return result;
}

std::string corners(const Polygon& polygon, const char* between) {
  return joined(polygon, between, [](int corner) { return std::to_string(corner); });
}

std::string obj(const Shape& shape, const std::vector<Place>& places) {
  std::string result;
  int first = 1;
  for (const Place& place : places) {
    for (const Vec3d& p : shape.points) result += "v " + text(place(p)) + "\n";
    for (Polygon polygon : shape.polygons) {
      for (int& corner : polygon) corner += first;
      if (place.scale[0] * place.scale[1] * place.scale[2] < 0) std::reverse(polygon.begin(), polygon.end());
      result += "f " + corners(polygon, " ") + "\n";
    }
    first += static_cast<int>(shape.points.size());
  }
  return result;
}

std::string dae(const Shape& shape, const std::vector<Place>& places,
                const std::string& asset = "<up_axis>Y_UP</up_axis>") {
  const auto count = [](std::size_t n) { return " count=\"" + std::to_string(n) + "\""; };
  const std::size_t n = shape.points.size();
  return "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n"
         "<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\"><asset>" +
         asset + "</asset><library_geometries><geometry id=\"g\"><mesh><source id=\"p\"><float_array id=\"a\"" +
         count(3 * n) + ">" + joined(shape.points, " ", [](const Vec3d& p) { return text(p); }) +
         "</float_array><technique_common><accessor source=\"#a\"" + count(n) +
         " stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/>"
         "<param name=\"Z\" type=\"float\"/></accessor></technique_common></source>"
         "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices><polylist" +
         count(shape.polygons.size()) + "><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><vcount>" +
         joined(shape.polygons, " ", [](const Polygon& p) { return std::to_string(p.size()); }) + "</vcount><p>" +
         joined(shape.polygons, " ", [](const Polygon& p) { return corners(p, " "); }) +
         "</p></polylist></mesh></geometry></library_geometries><library_visual_scenes><visual_scene id=\"s\">" +
         joined(places, "",
                [](const Place& place) {
                  return "<node><translate>" + text(place.move) + "</translate><scale>" + text(place.scale) +
                         "</scale><instance_geometry url=\"#g\"/></node>";
                }) +
         "</visual_scene></library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>\n";
}

std::string x3d(const Shape& shape, const std::vector<Place>& places, const std::string& colours = "") {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<X3D profile=\"Interchange\" version=\"3.3\"><Scene>" +
         joined(places, "\n",
                [&](const Place& place) {
                  return "<Transform translation=\"" + text(place.move) + "\" scale=\"" + text(place.scale) +
                         "\"><Shape><IndexedFaceSet coordIndex=\"" +
                         joined(shape.polygons, " ", [](const Polygon& p) { return corners(p, " ") + " -1"; }) +
                         "\"><Coordinate point=\"" + joined(shape.points, " ", [](const Vec3d& p) { return text(p); }) +
                         "\"/>" + colours + "</IndexedFaceSet></Shape></Transform>";
                }) +
         "</Scene></X3D>\n";
}

std::string fbx(const Shape& shape, const std::vector<Place>& places, const std::string& settings = "") {
  const auto array = [](std::size_t n, const std::string& values) {
    return ": *" + std::to_string(n) + " {\na: " + values + "\n}\n";
  };
  std::size_t count = 0;
  const std::string indices = joined(shape.polygons, ",", [&](Polygon p) {
    count += p.size();
    p.back() = -1 - p.back();  // the last corner of each polygon
    return corners(p, ",");
  });
  std::string models, links;
  int id = 2000;
  for (const Place& place : places) {
    const std::string name = std::to_string(++id);
    models += "Model: " + name +
              ", \"Model::n\", \"Mesh\" {\nVersion: 232\nProperties70:  {\n"
              "P: \"Lcl Translation\", \"Lcl Translation\", \"\", \"A\"," +
              text(place.move, ",") + "\nP: \"Lcl Scaling\", \"Lcl Scaling\", \"\", \"A\"," + text(place.scale, ",") +
              "\n}\n}\n";
    links += "C: \"OO\"," + name + ",0\nC: \"OO\",1000," + name + "\n";
  }
  return "; FBX 7.3.0 project file\nFBXHeaderExtension:  {\nFBXHeaderVersion: 1003\nFBXVersion: 7300\n}\n"
         "GlobalSettings:  {\nVersion: 1000\nProperties70:  {\n" +
         settings +
         "}\n}\nObjects:  {\n"
         "Geometry: 1000, \"Geometry::g\", \"Mesh\" {\nVertices" +
         array(3 * shape.points.size(), joined(shape.points, ",", [](const Vec3d& p) { return text(p, ","); })) +
         "PolygonVertexIndex" + array(count, indices) + "GeometryVersion: 124\n}\n" + models + "}\nConnections:  {\n" +
         links + "}\n";
}

/// A property of an FBX.
std::string whole(const char* name, int value) {
  return "P: \"" + std::string(name) + "\", \"int\", \"Integer\", \"\"," + std::to_string(value) + "\n";
}

std::string unit(double centimetres) {
  return "P: \"UnitScaleFactor\", \"double\", \"Number\", \"\"," + std::to_string(centimetres) + "\n";
}

/// Little-endian.
template <class Number>
std::string bytesOf(Number number) {
  return {reinterpret_cast<const char*>(&number), sizeof number};
}

std::string chunk(std::uint16_t id, const std::string& data) {
  return bytesOf(id) + bytesOf(static_cast<std::uint32_t>(6 + data.size())) + data;
}

/// One object, without places.
std::string threeDs(const Shape& shape) {
  std::string points = bytesOf(static_cast<std::uint16_t>(shape.points.size()));
  for (const Vec3d& p : shape.points)
    for (int axis = 0; axis < 3; ++axis) points += bytesOf(static_cast<float>(p[axis]));
  std::string faces = bytesOf(static_cast<std::uint16_t>(shape.polygons.size()));
  for (const Polygon& polygon : shape.polygons) {
    for (const int corner : polygon) faces += bytesOf(static_cast<std::uint16_t>(corner));
    faces += bytesOf(std::uint16_t{7});  // all edges are shown
  }
  const std::string mesh = chunk(0x4100, chunk(0x4110, points) + chunk(0x4120, faces));
  return chunk(0x4D4D,
               chunk(0x0002, bytesOf(std::uint32_t{3})) + chunk(0x3D3D, chunk(0x4000, std::string("o\0", 2) + mesh)));
}

/// Z up, turned to Y up.
Vec3d upright(const Vec3d& p) { return {p[0], p[2], -p[1]}; }

/// The triangles by their corners, each beginning with its least one, in order.
std::vector<std::array<Vec3d, 3>> trianglesOf(const Mesh& mesh) {
  std::vector<std::array<Vec3d, 3>> triangles;
  for (const openvdb::Vec3I& t : mesh.triangles) {
    std::array<Vec3d, 3> corners = {mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]};
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    triangles.push_back(corners);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

class ImportedMesh : public testing::Test {
 protected:
  void SetUp() override {
    if (!vdbtools::canImport()) GTEST_SKIP() << "this build has no Assimp";
    vdbtools::trustImporter(true);
  }
  void TearDown() override { vdbtools::trustImporter(false); }

  Mesh read(const std::string& name, const std::string& bytes) const {
    return vdbtools::readMesh(mFolder.write(name, bytes));
  }

  void expectSame(const std::string& name, const std::string& bytes, const Mesh& wanted) const {
    const Mesh mesh = read(name, bytes);
    EXPECT_EQ(mesh.points.size(), wanted.points.size()) << name;
    EXPECT_EQ(trianglesOf(mesh), trianglesOf(wanted)) << name;
    EXPECT_TRUE(vdbtools::reportMesh(mesh).closed()) << name;
    EXPECT_GT(vdbtools::reportMesh(mesh).volume, 0) << name;
  }

  void expectRefused(const std::string& name, const std::string& bytes, const std::vector<std::string>& words) const {
    try {
      read(name, bytes);
      ADD_FAILURE() << name << " was read";
    } catch (const DataError& error) {
      const std::string what = error.what();
      EXPECT_EQ(what.find('\n'), std::string::npos) << what;
      EXPECT_NE(what.find(name + ": "), std::string::npos) << what;
      for (const std::string& word : words) EXPECT_NE(what.find(word), std::string::npos) << what << ": " << word;
    }
  }

  TemporaryFolder mFolder;
};

// Promise of targets.md: FBX, DAE, 3DS and X3D: "the program reads them with `--trust-importer` only", "no recipe and
//   no request of the page can set it"; "all meshes where the nodes place them", turned such that Y points up
TEST_F(ImportedMesh, IsTheMeshOfAnObj) {
  const Shape shape = prism();
  const Mesh wanted = read("a.obj", obj(shape, {{}}));
  ASSERT_TRUE(vdbtools::reportMesh(wanted).closed());
  expectSame("a.dae", dae(shape, {{}}), wanted);
  expectSame("a.x3d", x3d(shape, {{}}), wanted);
  expectSame("a.fbx", fbx(shape, {{}}), wanted);
  expectSame("A.FBX", fbx(shape, {{}}), wanted);

  Mesh simple = read("b.obj", obj(tetrahedron(), {{}}));
  for (Vec3d& p : simple.points) p = upright(p);
  expectSame("b.3ds", threeDs(tetrahedron()), simple);
}

// Promise: FBX, DAE, 3DS and X3D: "the program ..."
TEST_F(ImportedMesh, StandsWhereTheNodesShowIt) {
  const Shape shape = prism();
  const std::vector<Place> places = {{{10, 0, 0}, {2, 2, 2}}, {{-8, 0.5, 0}, {-1, 1, 4}}, {{0, 0, 30}, {1, 1, 1}}};
  const Mesh wanted = read("a.obj", obj(shape, places));
  expectSame("a.dae", dae(shape, places), wanted);
  expectSame("a.x3d", x3d(shape, places), wanted);
  expectSame("a.fbx", fbx(shape, places), wanted);
}

// Promise: FBX, DAE, 3DS and X3D: "the program ..."
TEST_F(ImportedMesh, IsTurnedToYUpAndKeepsItsNumbersAndItsUnit) {
  const Shape shape = tetrahedron();
  const std::vector<Place> places = {{{4, 5, 6}, {1, 1, 1}}};
  const Mesh asItIs = read("a.obj", obj(shape, places));
  Mesh turned = asItIs;
  for (Vec3d& p : turned.points) p = upright(p);

  const std::string zUp = whole("UpAxis", 2) + whole("UpAxisSign", 1) + whole("FrontAxis", 1) +
                          whole("FrontAxisSign", -1) + whole("CoordAxis", 0) + whole("CoordAxisSign", 1);
  const std::map<std::string, double> metres = {{"mm", 0.001}, {"cm", 0.01}, {"m", 1}, {"in", 0.0254}, {"", 0.3048}};
  for (const auto& [name, size] : metres) {
    const std::string asset = "<unit meter=\"" + std::to_string(size) + "\"/><up_axis>";
    const std::map<std::string, std::pair<std::string, const Mesh*>> files = {
        {"y.dae", {dae(shape, places, asset + "Y_UP</up_axis>"), &asItIs}},
        {"z.dae", {dae(shape, places, asset + "Z_UP</up_axis>"), &turned}},
        {"y.fbx", {fbx(shape, places, unit(100 * size)), &asItIs}},
        {"z.fbx", {fbx(shape, places, zUp + unit(100 * size)), &turned}}};
    for (const auto& [file, content] : files) {
      expectSame(file, content.first, *content.second);
      const vdbtools::FileTexts unit =
          name.empty() ? vdbtools::FileTexts() : vdbtools::FileTexts{{"julia_length_unit", name}};
      EXPECT_EQ(vdbtools::readMeshTexts(mFolder.write(file, content.first)), unit) << file;
    }
  }
  EXPECT_TRUE(vdbtools::readMeshTexts(mFolder.write("a.3ds", threeDs(shape))).empty());
  EXPECT_TRUE(vdbtools::readMeshTexts(mFolder.write("a.x3d", x3d(shape, places))).empty());
}

TEST_F(ImportedMesh, HasTheColoursOfItsVertices) {
  const Shape shape = tetrahedron();
  const Mesh mesh = read("a.x3d", x3d(shape, {{}}, "<Color color=\"1 0 0  0 0.5 0  0 0 1  0.25 0.25 0\"/>"));
  ASSERT_EQ(mesh.attributes.size(), 3U);
  const std::array<const char*, 3> names = {"red", "green", "blue"};
  const std::map<Vec3d, Vec3d> colours = {{shape.points[0], {1, 0, 0}},
                                          {shape.points[1], {0, 0.5, 0}},
                                          {shape.points[2], {0, 0, 1}},
                                          {shape.points[3], {0.25, 0.25, 0}}};
  ASSERT_EQ(mesh.points.size(), 4U);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    EXPECT_EQ(mesh.attributes[channel].name, names[channel]);
    for (std::size_t p = 0; p < 4; ++p)
      EXPECT_EQ(mesh.attributes[channel].values[p], colours.at(mesh.points[p])[static_cast<int>(channel)]);
  }
  EXPECT_TRUE(read("b.x3d", x3d(shape, {{}})).attributes.empty());
}

// Promise: FBX, DAE, 3DS and X3D: "the program ..."
TEST_F(ImportedMesh, IsRefusedWithoutTrust) {
  vdbtools::trustImporter(false);
  const Shape shape = tetrahedron();
  expectRefused("a.fbx", fbx(shape, {{}}), {"FBX", "--trust-importer", ".glb", "Blender"});
  expectRefused("a.dae", dae(shape, {{}}), {"DAE", "--trust-importer", ".glb", "Blender"});
  expectRefused("a.x3d", x3d(shape, {{}}), {"X3D", "--trust-importer", ".glb", "Blender"});
  expectRefused("A.3DS", threeDs(shape), {"3DS", "--trust-importer", ".glb", "Blender"});
  EXPECT_TRUE(vdbtools::readMeshTexts(mFolder.write("a.fbx", fbx(shape, {{}}))).empty());
}

// Promise: FBX, DAE, 3DS and X3D: "the program ..."
TEST_F(ImportedMesh, BrokenFilesAreRefusedInOneLine) {
  const Shape shape = tetrahedron();
  const std::map<std::string, std::string> files = {
      {"a.fbx", fbx(shape, {{}})}, {"a.dae", dae(shape, {{}})}, {"a.x3d", x3d(shape, {{}})}, {"a.3ds", threeDs(shape)}};
  for (const auto& [name, bytes] : files) {
    expectRefused(name, "", {"empty"});
    expectRefused(name, "what is this\n", {});
    expectRefused(name, bytes.substr(0, bytes.size() / 3), {});
  }
  Shape wrong = shape;
  wrong.polygons[2][1] = 77;
  expectRefused("index.dae", dae(wrong, {{}}), {});
  expectRefused("index.fbx", fbx(wrong, {{}}), {});
  expectRefused("nan.fbx", fbx(shape, {{{0, 0, 0}, {1e30, 1e30, 1e30}}, {{0, 0, 0}, {1e300, 1, 1}}}), {});
}

TEST(ImportedMeshWithoutAssimp, IsRefusedByNameWithTheWayOut) {
  if (vdbtools::canImport()) GTEST_SKIP() << "this build has Assimp";
  TemporaryFolder folder;
  try {
    vdbtools::readMesh(folder.write("a.fbx", fbx(tetrahedron(), {{}})));
    ADD_FAILURE() << "read";
  } catch (const DataError& error) {
    for (const char* const word : {"a.fbx", "FBX", "libassimp-dev", ".glb"})
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }
}

}  // namespace imported
}  // namespace
