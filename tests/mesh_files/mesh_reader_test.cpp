// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/mesh_files/mesh_reader.h"
#include "support/temporary_folder.h"
#include "support/test_meshes.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"
#include "vdbtools/mesh/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <iostream>
#include <set>
#include <sstream>

namespace {

using namespace test_meshes;
using vdbtools::DataError;
using vdbtools::MissingInputError;
using vdbtools::readMesh;
using vdbtools::reportMesh;

template <typename T>
std::string bytesOfNumber(T value, bool bigEndian = false) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  if (bigEndian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

std::string number(double value) {
  std::ostringstream text;
  text.precision(17);
  text << value;
  return text.str();
}

std::string pointLine(const Vec3d& p) { return number(p[0]) + " " + number(p[1]) + " " + number(p[2]) + "\n"; }

std::string asObj(const Mesh& mesh) {
  std::string text = "# a comment\n";
  for (const Vec3d& p : mesh.points) text += "v " + pointLine(p);
  for (const Vec3I& t : mesh.triangles) {
    text += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " + std::to_string(t[2] + 1) + "\n";
  }
  return text;
}

std::string asOff(const Mesh& mesh) {
  std::string text =
      "OFF\n# a comment\n" + std::to_string(mesh.points.size()) + " " + std::to_string(mesh.triangles.size()) + " 0\n";
  for (const Vec3d& p : mesh.points) text += pointLine(p);
  for (const Vec3I& t : mesh.triangles) {
    text += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + "\n";
  }
  return text;
}

std::string plyHeader(const Mesh& mesh, const std::string& format, const std::string& type) {
  return "ply\nformat " + format + " 1.0\ncomment made by a test\nobj_info element vertex 99\nelement vertex " +
         std::to_string(mesh.points.size()) + "\nproperty " + type + " x\nproperty " + type + " y\nproperty " + type +
         " z\nproperty uchar quality\nelement face " + std::to_string(mesh.triangles.size()) +
         "\nproperty list uchar float before\nproperty list uint int vertex_indices\nproperty short "
         "after\nend_header\n";
}

std::string asTextPly(const Mesh& mesh) {
  std::string text = plyHeader(mesh, "ascii", "double");
  for (const Vec3d& p : mesh.points) text += number(p[0]) + " " + number(p[1]) + " " + number(p[2]) + " 7\n";
  for (const Vec3I& t : mesh.triangles) {
    text += "2 0.5 0.25 3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + " -1\n";
  }
  return text;
}

template <typename Real>
std::string asBinaryPly(const Mesh& mesh, bool bigEndian) {
  std::string text = plyHeader(mesh, bigEndian ? "binary_big_endian" : "binary_little_endian",
                               sizeof(Real) == 8 ? "float64" : "float");
  for (const Vec3d& p : mesh.points) {
    for (int c = 0; c < 3; ++c) text += bytesOfNumber(static_cast<Real>(p[c]), bigEndian);
    text += '\7';
  }
  for (const Vec3I& t : mesh.triangles) {
    text += '\2' + bytesOfNumber(0.5F, bigEndian) + bytesOfNumber(0.25F, bigEndian) +
            bytesOfNumber(std::uint32_t{3}, bigEndian);
    for (int c = 0; c < 3; ++c) text += bytesOfNumber(static_cast<std::int32_t>(t[c]), bigEndian);
    text += bytesOfNumber(std::int16_t{-1}, bigEndian);
  }
  return text;
}

std::string asBinaryStl(const Mesh& mesh, const std::string& title) {
  std::string text = title;
  text.resize(80, ' ');
  text += bytesOfNumber(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const Vec3I& t : mesh.triangles) {
    text += std::string(12, '\0');
    for (int c = 0; c < 3; ++c) {
      for (int axis = 0; axis < 3; ++axis) text += bytesOfNumber(static_cast<float>(mesh.points[t[c]][axis]));
    }
    text += std::string(2, '\0');
  }
  return text;
}

std::string asTextStl(const Mesh& mesh) {
  std::string text = "solid the outer vertex of a router\n";
  for (const Vec3I& t : mesh.triangles) {
    text += "  facet normal 0 0 0\n    outer loop\n";
    for (int c = 0; c < 3; ++c) text += "      vertex " + pointLine(mesh.points[t[c]]);
    text += "    endloop\n  endfacet\n";
  }
  return text + "endsolid the outer vertex of a router\n";
}

using Corners = std::array<std::array<double, 3>, 3>;

/// The triangles by position, each turned so that its least corner comes first: the same whatever the point order.
std::multiset<Corners> trianglesByPosition(const Mesh& mesh) {
  std::multiset<Corners> result;
  for (const Vec3I& t : mesh.triangles) {
    Corners corners;
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3d& p = mesh.points[t[static_cast<int>(c)]];
      corners[c] = {p[0], p[1], p[2]};
    }
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    result.insert(corners);
  }
  return result;
}

Mesh inSinglePrecision(Mesh mesh) {
  for (Vec3d& p : mesh.points) {
    for (int c = 0; c < 3; ++c) {
      // The basic-block vectoriser of g++ 12.2 at -O2 turns double -> float -> double into nothing at all.
      const volatile float single = static_cast<float>(p[c]);
      p[c] = double{single};
    }
  }
  return mesh;
}

std::string withCrLf(const std::string& text) {
  std::string result;
  for (const char c : text) result += c == '\n' ? "\r\n" : std::string(1, c);
  return result;
}

/// The error that reading @a contents as @a name ends with.
std::string errorOf(const std::string& name, std::string_view contents) {
  const TemporaryFolder folder;
  const auto path = folder.write(name, contents);
  try {
    readMesh(path);
  } catch (const DataError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find(path.string()), std::string::npos) << "names the file: " << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << "is one line: " << text;
    return text;
  }
  ADD_FAILURE() << name << " was read";
  return {};
}

#define EXPECT_REFUSED(name, contents, words)                              \
  do {                                                                     \
    const std::string text = errorOf(name, contents);                      \
    EXPECT_NE(text.find(words), std::string::npos) << "was told " << text; \
  } while (false)

// Promise: A mesh gives the same fractal ...
TEST(ReadMesh, AllFormatsHoldTheSameTriangles) {
  const TemporaryFolder folder;
  const Mesh exact = transformed(makeSphere(1, 2), 0.1, Vec3d(1e5, 1.0 / 3, -7));
  const Mesh single = inSinglePrecision(makeSphere(1, 2));
  struct Case {
    std::string name, contents;
    const Mesh& mesh;
  };
  const std::vector<Case> cases = {
      {"a.obj", asObj(exact), exact},
      {"crlf.OBJ", withCrLf(asObj(exact)), exact},
      {"a.off", asOff(exact), exact},
      {"crlf.off", withCrLf(asOff(exact)), exact},
      {"text.ply", asTextPly(exact), exact},
      {"crlf.ply", withCrLf(asTextPly(exact)), exact},
      {"little.ply", asBinaryPly<double>(exact, false), exact},
      {"big.ply", asBinaryPly<double>(exact, true), exact},
      {"little_float.ply", asBinaryPly<float>(single, false), single},
      {"big_float.ply", asBinaryPly<float>(single, true), single},
      {"binary.stl", asBinaryStl(single, "made by a test"), single},
      {"solid.stl", asBinaryStl(single, "solid and yet binary\nfacet"), single},
      {"text.Stl", asTextStl(single), single},
      {"crlf.stl", withCrLf(asTextStl(single)), single},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const Mesh mesh = readMesh(folder.write(c.name, c.contents));
    EXPECT_TRUE(trianglesByPosition(mesh) == trianglesByPosition(c.mesh));
    EXPECT_EQ(mesh.points.size(), c.mesh.points.size());
    EXPECT_TRUE(reportMesh(mesh).closed());
  }
}

TEST(ReadMesh, ObjAsFoundInTheWild) {
  const TemporaryFolder folder;
  const std::string obj =
      "mtllib /dev/zero\n"  // a reader that opens this never ends
      "o thing\ng part\nusemtl red\ns 1\n"
      "v 0 0 0 1 0 0\n"     // with a colour
      "v  +1 0  0 1.0\t\n"  // with a weight
      "vt 0 0\nvn 0 0 1\n"
      "v 1 1 0\nv 0 1 0 # the last\n"
      "f 1//1 2//1 3//1\n"
      "f -4/1/1 -2/-1/-1 -1/1/1\n"
      "v 0 0 1\nv 1e0 0 1\nv 1 1 1\nv 0 1 1\n"
      "f -4/1 -3/1 -2/1 -1/1\n"
      "f 1 2 \\\n 6 5\n"
      "l 1 2\np 1\n"
      "f 7 8 1";  // no end of line
  const Mesh mesh = readMesh(folder.write("wild.obj", obj));
  EXPECT_EQ(mesh.points.size(), 8U);
  const std::vector<Vec3I> expected = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4}, {6, 7, 0}};
  EXPECT_EQ(mesh.triangles, expected);
}

TEST(ReadMesh, OffAsFoundInTheWild) {
  const TemporaryFolder folder;
  const std::vector<Vec3I> expected = {{0, 1, 2}, {0, 2, 3}};
  for (const std::string contents :
       {"OFF 4 1 4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n",
        "\n# first\nCOFF # colours\n\n4 1\n0 0 0 9 9 9 255\n"
        "1 0 0 9 9 9 255 # second\n\n1 1 0 9 9 9 255\n0 1 0 9 9 9 255\n4  0 1 2 3  0.5 0.5 0.5\n"}) {
    const Mesh mesh = readMesh(folder.write("wild.off", contents));
    EXPECT_EQ(mesh.points.size(), 4U) << contents;
    EXPECT_EQ(mesh.points[2], Vec3d(1, 1, 0)) << contents;
    EXPECT_EQ(mesh.triangles, expected) << contents;
  }
}

TEST(ReadMesh, PlyWithFacesFirstAndOtherElements) {
  const TemporaryFolder folder;
  const std::string ply =
      "ply\nformat ascii 1.0\nelement face 1\nproperty list uint8 uint32 vertex_index\nelement extra 2\nproperty list "
      "char int a\nelement vertex 3\nproperty float z\nproperty float x\nproperty list uchar uchar tags\nproperty int "
      "y\n"
      "end_header\n3 2 1 0\n0\n2 5 6\n1 2 0 3\n1 2 1 9 4\n1 2 2 8 8 5\n";
  const Mesh mesh = readMesh(folder.write("wild.ply", ply));
  ASSERT_EQ(mesh.points.size(), 3U);
  EXPECT_EQ(mesh.points[2], Vec3d(2, 5, 1));
  EXPECT_EQ(mesh.triangles, std::vector<Vec3I>({{2, 1, 0}}));
}

/// A ball of rings of points as a PLY of triangle strips, one around each pair of rings, which ends in -1 except the
/// last one of its row. The points of a pole repeat, so triangles there repeat a corner.
std::string asStripPly(int rings, int around, int stripsPerRow, bool binary) {
  std::string points, rows;
  int pointCount = 0, rowCount = 0;
  for (int ring = 0; ring <= rings; ++ring)
    for (int k = 0; k < around; ++k, ++pointCount) {
      const double polar = M_PI * ring / rings, angle = 2 * M_PI * k / around;
      const bool isPole = ring == 0 || ring == rings;
      const Vec3d p(isPole ? 0 : std::sin(polar) * std::cos(angle), isPole ? 0 : std::sin(polar) * std::sin(angle),
                    ring == 0       ? 1
                    : ring == rings ? -1
                                    : std::cos(polar));
      for (int axis = 0; axis < 3; ++axis) points += binary ? bytesOfNumber(p[axis], true) : "";
      points += binary ? "" : pointLine(p);
    }
  const auto pointOf = [&](int ring, int k) {
    return ring == 0 ? 0 : ring == rings ? rings * around : ring * around + k % around;
  };
  for (int first = 0; first < rings; first += stripsPerRow, ++rowCount) {
    std::vector<int> list;
    for (int ring = first; ring < std::min(rings, first + stripsPerRow); ++ring) {
      if (ring > first) list.push_back(-1);
      for (int k = 0; k <= around; ++k) list.insert(list.end(), {pointOf(ring, k), pointOf(ring + 1, k)});
    }
    rows += binary ? bytesOfNumber(static_cast<std::int32_t>(list.size()), true) : std::to_string(list.size());
    for (const int index : list)
      rows += binary ? bytesOfNumber(std::int32_t{index}, true) : " " + std::to_string(index);
    rows += binary ? "" : "\n";
  }
  return std::string("ply\nformat ") + (binary ? "binary_big_endian" : "ascii") + " 1.0\nelement vertex " +
         std::to_string(pointCount) + "\nproperty double x\nproperty double y\nproperty double z\nelement tristrips " +
         std::to_string(rowCount) + "\nproperty list int int vertex_indices\nend_header\n" + points + rows;
}

TEST(ReadMesh, StripsOfAPlyAreABall) {
  constexpr int rings = 12, around = 16;
  for (const int stripsPerRow : {1, 5, rings})
    for (const bool binary : {false, true}) {
      const TemporaryFolder folder;
      const Mesh mesh = readMesh(folder.write("strips.ply", asStripPly(rings, around, stripsPerRow, binary)));
      const vdbtools::MeshReport report = reportMesh(mesh);
      EXPECT_EQ(report.triangles, 2u * around * (rings - 1)) << stripsPerRow;
      EXPECT_TRUE(report.closed()) << stripsPerRow;
      EXPECT_EQ(report.degenerateFaces, 0u);
      EXPECT_NEAR(report.volume, 4 * M_PI / 3, 0.3);
    }
}

TEST(ReadMesh, StripsOfAPly) {
  const auto ply = [](const std::string& elements, const std::string& rows) {
    return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n" +
           elements + "end_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n" + rows;
  };
  const std::string strips = "element tristrips 1\nproperty list int int vertex_indices\n";
  const TemporaryFolder folder;
  const auto trianglesOf = [&](const std::string& text) { return readMesh(folder.write("a.ply", text)).triangles; };
  // As many as points less two, every second one turned.
  EXPECT_EQ(trianglesOf(ply(strips, "5 0 1 2 3 0\n")), std::vector<Vec3I>({{0, 1, 2}, {2, 1, 3}, {2, 3, 0}}));
  // After a -1 the first triangle is as it stands again; one that is too short, or nothing at all, is none.
  EXPECT_EQ(trianglesOf(ply(strips, "12 -1 0 1 2 3 -1 -1 1 3 -1 2 0\n")), std::vector<Vec3I>({{0, 1, 2}, {2, 1, 3}}));
  EXPECT_EQ(trianglesOf(ply(strips, "8 0 1 2 3 -1 1 0 3\n")), std::vector<Vec3I>({{0, 1, 2}, {2, 1, 3}, {1, 0, 3}}));
  // A triangle that repeats a corner is left out, and counts for the next one's turn.
  EXPECT_EQ(trianglesOf(ply(strips, "6 0 1 2 2 3 1\n")), std::vector<Vec3I>({{0, 1, 2}, {3, 2, 1}}));
  // Beside faces they say the same once more.
  const std::string faces = "element face 1\nproperty list int int vertex_indices\n";
  EXPECT_EQ(trianglesOf(ply(strips + faces, "4 0 1 2 3\n3 3 2 1\n")), std::vector<Vec3I>({{3, 2, 1}}));
  EXPECT_EQ(trianglesOf(ply(faces + strips, "3 3 2 1\n4 0 1 2 3\n")), std::vector<Vec3I>({{3, 2, 1}}));
  EXPECT_REFUSED("a.ply", ply(strips, "4 0 1 2 4\n"), "point 4");
  EXPECT_REFUSED("a.ply", ply(strips, "4 0 1 2 -2\n"), "-2");
  EXPECT_REFUSED("a.ply", ply(strips, "4 0 1 2 0.5\n"), "0.5");
  EXPECT_REFUSED("a.ply", ply(strips, "4 0 1 2\n"), "truncated");
  EXPECT_REFUSED("a.ply", ply(strips, "4 0 1 -1 2\n"), "no triangle");
  EXPECT_REFUSED("a.ply", ply("element tristrips 1\nproperty list int int indices\n", "3 0 1 2\n"), "vertex_indices");
}

TEST(ReadMesh, ConcavePolygonsAreCoveredOnce) {
  const TemporaryFolder folder;
  struct Case {
    std::string contents;
    double area;
  };
  const std::vector<Case> cases = {
      // an L in a slanted plane, and a dart; a fan about their first corners turns a triangle over
      {"v 0 0 0\nv 2 0 2\nv 2 1 2\nv 1 1 1\nv 1 2 1\nv 0 2 0\nf 2 3 4 5 6 1\n", 3 * std::sqrt(2.0)},
      {"v -2 -1 0\nv 0 0 0\nv 2 -1 0\nv 0 3 0\nf 1 2 3 4\n", 6},
      // the same dart the other way round, and a convex pentagon
      {"v -2 -1 0\nv 0 0 0\nv 2 -1 0\nv 0 3 0\nf 4 3 2 1\n", 6},
      {"v 0 0 0\nv 2 0 0\nv 3 1 0\nv 1 2 0\nv 0 1 0\nf 1 2 3 4 5\n", 4},
  };
  for (const Case& c : cases) {
    const Mesh mesh = readMesh(folder.write("concave.obj", c.contents));
    EXPECT_EQ(mesh.triangles.size(), mesh.points.size() - 2) << c.contents;
    Vec3d vectorArea(0);
    for (const Vec3I& t : mesh.triangles) {
      vectorArea += (mesh.points[t[1]] - mesh.points[t[0]]).cross(mesh.points[t[2]] - mesh.points[t[0]]) / 2.0;
    }
    EXPECT_NEAR(reportMesh(mesh).area, c.area, 1e-12) << c.contents;
    EXPECT_NEAR(vectorArea.length(), c.area, 1e-12) << "a triangle is turned over: " << c.contents;
  }
}

TEST(ReadMesh, NonManifoldFacesKeepTheirPoints) {
  const TemporaryFolder folder;
  const Mesh mesh = readMesh(
      folder.write("fin.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nf 1 2 3\nf 2 1 4\nf 1 2 5\nf 1 2 3\n"));
  EXPECT_EQ(mesh.points.size(), 5U);
  EXPECT_EQ(mesh.triangles.size(), 4U);
  EXPECT_EQ(reportMesh(mesh).nonManifoldEdges, 1U);
}

// Promise: The library "never prints, and it never exits"
TEST(ReadMesh, PrintsNothing) {
  const TemporaryFolder folder;
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  readMesh(folder.write("a.obj", "mtllib missing.mtl\nusemtl none\n" + asObj(makeCube())));
  readMesh(folder.write("a.ply", asBinaryPly<double>(makeCube(), false)));
  readMesh(folder.write("a.off", asOff(makeCube())));
  EXPECT_THROW(readMesh(folder.write("b.obj", "v 1 2\n")), DataError);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

TEST(ReadMesh, MissingAndUnreadable) {
  const TemporaryFolder folder;
  EXPECT_THROW(readMesh(folder.path() / "none.obj"), MissingInputError);
  std::filesystem::create_directory(folder.path() / "folder.obj");
  EXPECT_THROW(readMesh(folder.path() / "folder.obj"), MissingInputError);
  EXPECT_THROW(readMesh("/dev/null"), MissingInputError);
  if (geteuid() != 0) {  // root may read it all the same
    const auto path = folder.write("closed.obj", asObj(makeCube()));
    std::filesystem::permissions(path, std::filesystem::perms::none);
    EXPECT_THROW(readMesh(path), MissingInputError);
  }
}

TEST(ReadMesh, SaysWhereReadingBrokeOff) {
  // An ordinary file by its kind, whose first byte cannot be read.
  const TemporaryFolder folder;
  const auto path = folder.path() / "broken.obj";
  std::filesystem::create_symlink("/proc/self/mem", path);
  EXPECT_THROW(readMesh(path), vdbtools::IoError);
}

TEST(ReadMesh, RepeatedCornersOfObjAreDropped) {
  const TemporaryFolder folder;
  const Mesh mesh = readMesh(
      folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 2 3\nf 1 2 1\nf 4 1 3 4\nf 1 2 3 1 4 2\n"));
  EXPECT_EQ(mesh.points.size(), 4U);
  EXPECT_EQ(mesh.triangles, std::vector<Vec3I>({{0, 1, 2}, {3, 0, 2}, {0, 1, 2}, {0, 2, 3}}));
}

TEST(ReadMesh, ErrorsOfTextNameTheLine) {
  EXPECT_REFUSED("a.obj", "v 0 0 0\n# two\nv 0 \\\nx 0\n", "line 4: 'x'");
  EXPECT_REFUSED("a.obj", "v 0 0 0\nf 1 1 9\nv 1 1 1\n", "line 2: a face refers to point 9");
  EXPECT_REFUSED("a.off", "OFF\n3 1\n\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n", "line 5: ''");
  EXPECT_REFUSED("a.stl", "solid\nouter loop\nvertex 0 0 0\nvertex 0 y 0\n", "line 4: 'y'");
  EXPECT_REFUSED("a.stl", "solid\nouter loop\nvertex 0 0 0\nouter loop\n", "line 4: a triangle begins within another");
  EXPECT_REFUSED("a.ply", "ply\nformat ascii 1.0\nelement vertex many\n", "line 3: 'many'");
}

TEST(ReadMesh, PlyNeedsEachCoordinateOnce) {
  const auto ply = [](const std::string& names) {
    std::string text = "ply\nformat ascii 1.0\nelement vertex 3\n";
    for (const char name : names) text += "property float " + std::string(1, name) + "\n";
    text += "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    for (int p = 0; p < 3; ++p) {
      for (std::size_t k = 0; k < names.size(); ++k) text += k % 3 == static_cast<std::size_t>(p) ? "1 " : "0 ";
      text += "\n";
    }
    return text + "3 0 1 2\n";
  };
  const TemporaryFolder folder;
  EXPECT_EQ(readMesh(folder.write("good.ply", ply("zxy"))).points[0], Vec3d(0, 0, 1));
  for (const std::string names : {"xxy", "xyy", "xy", "xyzx", "xyzxyz", "xxx"}) {
    SCOPED_TRACE(names);
    EXPECT_REFUSED("a.ply", ply(names), "exactly once each");
  }
}

TEST(ReadMesh, RefusesWhatItCannotRead) {
  EXPECT_REFUSED("a.blend", asObj(makeCube()), "'.blend'");
  EXPECT_REFUSED("plain", asObj(makeCube()), "format");
  for (const char* name : {"a.obj", "a.ply", "a.stl", "a.off"}) {
    EXPECT_REFUSED(name, "", "empty");
    EXPECT_FALSE(errorOf(name, "\n").empty()) << name;
    EXPECT_FALSE(errorOf(name, std::string(200, '\0')).empty()) << name;
    EXPECT_FALSE(errorOf(name, "\x89PNG\r\n\x1a\n binary of another kind").empty()) << name;
  }
  EXPECT_REFUSED("points.obj", "v 0 0 0\nv 1 0 0\n", "no triangle");
  EXPECT_REFUSED("none.off", "OFF\n1 0 0\n0 0 0\n", "no triangle");
  EXPECT_REFUSED("none.stl", asBinaryStl(Mesh(), "x"), "no triangle");
  EXPECT_REFUSED("none.stl", "solid x\nendsolid x\n", "no triangle");
  EXPECT_REFUSED("none.ply",
                 "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty "
                 "float z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n",
                 "no triangle");
}

// Promise: "A file that is broken, or made ..."
TEST(ReadMesh, RefusesAnyTruncation) {
  const Mesh cube = makeCube();
  const std::vector<std::pair<std::string, std::string>> files = {
      {"a.off", asOff(cube)},
      {"text.ply", asTextPly(cube)},
      {"binary.ply", asBinaryPly<double>(cube, false)},
      {"binary.stl", asBinaryStl(cube, "x")},
      {"text.stl", asTextStl(cube)},
  };
  for (const auto& [name, contents] : files) {
    // Each length but the last few, whose loss changes nothing or a digit: the name after 'endsolid', the last "-1".
    const std::size_t spare = name == "text.stl" ? 32 : name == "binary.stl" || name == "binary.ply" ? 0 : 3;
    for (std::size_t length = 0; length < contents.size() - spare; length += length < 400 ? 3 : 29) {
      EXPECT_FALSE(errorOf(name, contents.substr(0, length)).empty()) << name << " cut to " << length;
    }
  }
  // OBJ says nowhere how long it is; what can be seen is a line that breaks off and a point that never came.
  EXPECT_REFUSED("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2", "2 corners");
  EXPECT_REFUSED("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nv 1 2", "number");
}

// Promise: "A file that is broken, or made ..."
TEST(ReadMesh, RefusesCountsThatCannotBe) {
  EXPECT_REFUSED("a.off", "OFF\n4000000000 1 0\n0 0 0\n", "4000000000");
  EXPECT_REFUSED("a.off", "OFF\n-1 1 0\n0 0 0\n", "-1");
  EXPECT_REFUSED("a.off", "OFF\n1 1 0\n0 0 0\n2000000000 0 0 0\n", "number");
  std::string stl = asBinaryStl(makeCube(), "x");
  stl.replace(80, 4, "\xff\xff\xff\xff");
  EXPECT_REFUSED("a.stl", stl, "4294967295");
  stl.replace(80, 4, bytesOfNumber(std::uint32_t{3}));
  EXPECT_REFUSED("a.stl", stl, "3 triangles");
  const auto ply = [](const std::string& vertices, const std::string& faces, const std::string& body) {
    return "ply\nformat binary_little_endian 1.0\nelement vertex " + vertices +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
           "\nproperty list int int vertex_indices\nend_header\n" + body;
  };
  EXPECT_REFUSED("a.ply", ply("4294967295", "1", "x"), "4294967295");
  EXPECT_REFUSED("a.ply", ply("99999999999999999999", "1", "x"), "99999999999999999999");
  EXPECT_REFUSED("a.ply", ply("-3", "1", "x"), "-3");
  EXPECT_REFUSED("a.ply", ply("0", "4000000000", "x"), "4000000000");
  EXPECT_REFUSED("a.ply", ply("1", "1", std::string(12, '\0') + bytesOfNumber(2000000000)), "truncated");
  EXPECT_REFUSED("a.ply", ply("1", "1", std::string(12, '\0') + bytesOfNumber(-5)), "-5");
  EXPECT_REFUSED("a.ply", "ply\nformat ascii 1.0\nelement vertex 3\n", "header");
  EXPECT_REFUSED("a.ply", "ply\nformat ascii 1.0\nelement vertex 18446744073709551615\nend_header\n", "whole number");
}

TEST(ReadMesh, RefusesIndicesOutOfRange) {
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  EXPECT_REFUSED("a.obj", points + "f 1 2 4\n", "point 4");
  EXPECT_REFUSED("a.obj", points + "f 1 2 0\n", "point 0");
  EXPECT_REFUSED("a.obj", points + "f 1 2 -4\n", "-4");
  EXPECT_REFUSED("a.obj", points + "f 1 2 99999999999999999999\n", "99999999999999999999");
  EXPECT_REFUSED("a.obj", points + "f 1 2 three\n", "three");
  EXPECT_REFUSED("a.obj", "f 1 2 3\n", "point 3");
  EXPECT_REFUSED("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "point 3");
  EXPECT_REFUSED("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "-1");
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 ";
  EXPECT_REFUSED("a.ply", ply + "3\n", "point 3");
  EXPECT_REFUSED("a.ply", ply + "-1\n", "-1");
  EXPECT_REFUSED("a.ply", ply + "1.5\n", "1.5");
}

TEST(ReadMesh, RefusesCoordinatesThatAreNotFinite) {
  for (const std::string bad : {"nan", "inf", "-INF", "1e400", "0x10", "1,5", "1.0f"}) {
    const std::string three = "1 " + bad + " 0\n", obj = "v 0 0 0\nv 1 0 0\nv " + three + "f 1 2 3\n",
                      off = "OFF\n3 1 0\n0 0 0\n1 0 0\n" + three + "3 0 1 2\n";
    if (vdbtools::numberFromText(bad)) {
      EXPECT_REFUSED("a.obj", obj, "vertex 3: the coordinate y is ");  // OBJ counts from 1
      EXPECT_REFUSED("a.off", off, "vertex 2: the coordinate y is ");
    } else {
      EXPECT_REFUSED("a.obj", obj, bad);
      EXPECT_REFUSED("a.off", off, bad);
    }
    EXPECT_REFUSED("a.stl",
                   "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex " + three +
                       "endloop\nendfacet\nendsolid\n",
                   bad);
    EXPECT_FALSE(errorOf("a.ply",
                         "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
                         "float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n" +
                             three + "3 0 1 2\n")
                     .empty())
        << bad;
  }
  Mesh mesh = makeCube();
  mesh.points[3][1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_REFUSED("a.ply", asBinaryPly<double>(mesh, true), "nan");
  EXPECT_REFUSED("a.stl", asBinaryStl(mesh, "x"), "nan");
  mesh.points[3][1] = std::numeric_limits<double>::infinity();
  EXPECT_REFUSED("a.ply", asBinaryPly<float>(mesh, false), "inf");
  EXPECT_REFUSED("a.stl", asBinaryStl(mesh, "x"), "inf");
  EXPECT_REFUSED("a.stl",
                 "solid\nfacet\nouter loop\nvertex 0 0 1e39\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
                 "endsolid\n",
                 "1e39");
}

/// The same mesh with points in between that no triangle uses and that are not finite.
Mesh withLostPoints(const Mesh& mesh, std::size_t& lost) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const Vec3d bad[] = {{nan, nan, nan}, {1, nan, 2}, {infinity, 0, 0}, {0, 0, -infinity}};
  Mesh result;
  std::vector<std::uint32_t> places;
  lost = 0;
  for (std::size_t p = 0; p <= mesh.points.size(); ++p) {
    for (std::size_t i = 0; i < p % 4; ++i) result.points.push_back(bad[lost++ % std::size(bad)]);
    places.push_back(static_cast<std::uint32_t>(result.points.size()));
    if (p < mesh.points.size()) result.points.push_back(mesh.points[p]);
  }
  for (const Vec3I& t : mesh.triangles) result.triangles.emplace_back(places[t[0]], places[t[1]], places[t[2]]);
  return result;
}

// Promise: Points whose coordinates are not ...
TEST(ReadMesh, PointsThatNoFaceUsesNeedNotBeFinite) {
  const Mesh clean = makeSphere(1, 2);
  std::size_t lost = 0;
  const Mesh mesh = withLostPoints(clean, lost);
  ASSERT_GT(lost, 100U);
  const TemporaryFolder folder;
  for (const auto& [name, contents] : {std::pair<std::string, std::string>{"a.obj", asObj(mesh)},
                                       {"a.off", asOff(mesh)},
                                       {"text.ply", asTextPly(mesh)},
                                       {"little.ply", asBinaryPly<double>(mesh, false)},
                                       {"big.ply", asBinaryPly<double>(mesh, true)}}) {
    const Mesh read = readMesh(folder.write(name, contents));
    EXPECT_EQ(read.points, clean.points) << name;
    EXPECT_EQ(read.triangles, clean.triangles) << name;
    EXPECT_EQ(read.pointsLeftOut, lost) << name;
  }
  EXPECT_EQ(readMesh(folder.write("clean.obj", asObj(clean))).pointsLeftOut, 0U);
}

TEST(ReadMesh, LostPointsTakeTheirAttributesWithThem) {
  const TemporaryFolder folder;
  const Mesh ply =
      readMesh(folder.write("a.ply",
                            "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
                            "property float z\nproperty float s\nproperty float t\nproperty float wet\n"
                            "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
                            "0 0 0 0 1 5\nnan 0 0 9 9 9\n1 0 0 2 3 6\n0 inf 0 9 9 9\n0 1 0 4 5 7\n3 0 2 4\n"));
  ASSERT_EQ(ply.attributes.size(), 1U);
  EXPECT_EQ(ply.attributes[0].values, (std::vector<float>{5, 6, 7}));
  EXPECT_EQ(ply.cornerUvs, (std::vector<openvdb::Vec2s>{{0, 1}, {2, 3}, {4, 5}}));
  const Mesh obj = readMesh(folder.write(
      "a.obj", "v nan 0 0 0.5 0.5 0.5\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv 0 0 inf\nf 2 3 4\n"));
  ASSERT_EQ(obj.attributes.size(), 3U);
  EXPECT_EQ(obj.attributes[1].values, (std::vector<float>{0, 1, 0}));
}

TEST(ReadMesh, ACloudMayHavePlacesWithoutAPoint) {
  const Mesh clean = makeSphere(1, 2);
  std::size_t lost = 0;
  Mesh cloud = withLostPoints(clean, lost);
  cloud.triangles.clear();
  const TemporaryFolder folder;
  const Mesh read = vdbtools::readPoints(folder.write("a.ply", asBinaryPly<double>(cloud, false)));
  EXPECT_EQ(read.points, clean.points);
  EXPECT_EQ(read.triangles.size(), clean.points.size());
  EXPECT_EQ(read.pointsLeftOut, lost);
  EXPECT_THROW(vdbtools::readPoints(folder.write("none.obj", "v nan nan nan\nv nan nan nan\n")), DataError);
}

TEST(ReadMesh, TinyNumbersAreNumbers) {
  const TemporaryFolder folder;
  const Mesh mesh = readMesh(folder.write("a.obj", "v 1e-400 0 0\nv 1 1e-42 0\nv 0 1 -1e-320\nf 1 2 3\n"));
  EXPECT_EQ(mesh.points[0], Vec3d(0));
  EXPECT_EQ(mesh.points[1][1], 1e-42);
  EXPECT_EQ(mesh.triangles.size(), 1U);
}

TEST(ReadMesh, Bunny) {
  if (!hasBunny()) GTEST_SKIP() << bunnyPath() << " is not installed";
  const vdbtools::MeshReport report = reportMesh(bunny());
  EXPECT_EQ(report.points, 34835U);
  EXPECT_EQ(report.triangles, 69666U);
  EXPECT_TRUE(report.closed());
  EXPECT_EQ(report.components, 1U);
  EXPECT_NEAR(report.volume, 1.59981, 1e-4);
}

}  // namespace
