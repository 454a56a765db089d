// SPDX-License-Identifier: Apache-2.0
#include "support/small_disk.h"
#include "support/temporary_folder.h"
#include "support/test_meshes.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/atomic_file.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/surface/extract_mesh.h"

#include <gtest/gtest.h>

#include <malloc.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <limits>
#include <random>
#include <set>
#include <sstream>

namespace {

using namespace vdbtools;
using openvdb::Vec3d;

class MeshWriter : public testing::Test {
 protected:
  std::filesystem::path write(const char* name, const Mesh& mesh, MeshWriteOptions options) const {
    const std::filesystem::path path = mFolder / name;
    options.format = &meshFormat(path);
    std::ofstream stream(path, std::ios::binary);
    writeMesh(stream, mesh, options);
    return path;
  }
  const TemporaryFolder mTemporary;
  const std::filesystem::path mFolder = mTemporary.path();
};

// Promise: PLY, OBJ and STL of a fractal ...
TEST_F(MeshWriter, EveryFormatReadsBack) {
  Mesh mesh = test_meshes::makeSphere(1.5, 2, Vec3d(0.25, -3, 8));
  for (const bool normals : {false, true}) {
    if (normals) computeNormals(mesh);
    for (const char* name : {"m.ply", "m.OBJ", "m.stl", "m.glb"}) {
      SCOPED_TRACE(name);
      const Mesh read = readMesh(write(name, mesh, {}));
      const MeshReport a = reportMesh(mesh), b = reportMesh(read);
      EXPECT_EQ(b.points, a.points);
      EXPECT_EQ(b.triangles, a.triangles);
      EXPECT_TRUE(b.closed());
      EXPECT_NEAR(b.volume, a.volume, 1e-5 * a.volume);
      if (std::string(name) == "m.stl") continue;  // a soup: its points come in another order
      EXPECT_EQ(read.triangles, mesh.triangles);
      for (std::size_t i = 0; i < mesh.points.size(); ++i)
        ASSERT_NEAR((read.points[i] - mesh.points[i]).length(), 0, 1e-6);
    }
  }
}

// Promise: "Where floats would move ..."
TEST_F(MeshWriter, DoublesWhereFloatsWouldMoveVertices) {
  // Voxels of 1/100 at 10^6: floats are 1/16 apart there.
  const Mesh mesh = test_meshes::makeSphere(1, 2, Vec3d(1e6, 0, 0));
  const Mesh exact = readMesh(write("far.ply", mesh, {.voxelSize = 0.01}));
  for (std::size_t i = 0; i < mesh.points.size(); ++i) ASSERT_EQ(exact.points[i], mesh.points[i]);
  const auto small = std::filesystem::file_size(write("near.ply", test_meshes::makeSphere(1, 2), {.voxelSize = 0.01}));
  EXPECT_LT(small, std::filesystem::file_size(mFolder / "far.ply"));
}

TEST_F(MeshWriter, CommentsComeBack) {
  const std::map<std::string, std::string> comments{
      {"julia_alpha", "40"}, {"julia_input", "a b.obj"}, {"julia_grid", ""}};
  const Mesh mesh = test_meshes::makeCube();
  EXPECT_EQ(readMeshTexts(write("c.ply", mesh, {.comments = comments})), comments);
  EXPECT_EQ(readMeshTexts(write("c.obj", mesh, {.comments = comments})), comments);
  EXPECT_TRUE(readMeshTexts(write("c.stl", mesh, {.comments = comments})).empty());
  EXPECT_NO_THROW(readMesh(mFolder / "c.ply"));
  EXPECT_NO_THROW(readMesh(mFolder / "c.obj"));
  EXPECT_THROW(readMeshTexts(mFolder / "none.ply"), MissingInputError);
}

TEST_F(MeshWriter, OtherFormatsAreRefused) { EXPECT_THROW(meshFormat("a.fbx"), std::invalid_argument); }

const FileFormat* const kFormats[] = {&meshFormat(".ply"), &meshFormat(".obj"), &meshFormat(".stl"),
                                      &meshFormat(".glb")};

/// Like a pipe: there is no position in it.
class PipeBuffer : public std::streambuf {
 public:
  std::string bytes;

 protected:
  int_type overflow(int_type c) override {
    bytes += traits_type::to_char_type(c);
    return c;
  }
  std::streamsize xsputn(const char* from, std::streamsize size) override {
    bytes.append(from, static_cast<std::size_t>(size));
    return size;
  }
};

struct Pipe : PipeBuffer, std::ostream {
  Pipe() : std::ostream(static_cast<PipeBuffer*>(this)) {}
};

/// Triangles use points that are near one another in the order of the points, as in a mesh that is made slab by slab.
Mesh randomMesh(std::mt19937& random, std::size_t points, std::size_t triangles, bool normals) {
  Mesh mesh;
  std::uniform_real_distribution<float> coordinate(-2, 2);
  // Arguments of a function are drawn in an order that differs from compiler to compiler.
  const auto vector = [&] {
    openvdb::Vec3s v;
    for (int axis = 0; axis < 3; ++axis) v[axis] = coordinate(random);
    return v;
  };
  for (std::size_t i = 0; i < points; ++i) mesh.points.emplace_back(vector());
  if (normals)
    for (std::size_t i = 0; i < points; ++i) mesh.normals.push_back(vector().unit());
  for (std::size_t i = 0; i < triangles; ++i) {
    const std::size_t first = i * points / triangles;
    const auto corner = [&](std::size_t k) {
      return static_cast<openvdb::Index>(std::min(first + 3 * (random() % 4) + k, points - 3 + k));
    };
    openvdb::Vec3I triangle;
    do {
      for (int k = 0; k < 3; ++k) triangle[k] = corner(static_cast<std::size_t>(k));
      // A face with a corner twice is none in an OBJ.
    } while (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]);
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

/// Gives @a mesh to @a sink in pieces of up to @a longest points, triangles as early as they may come, and no
/// firstPoint smaller than it must be.
/// @param values  rows of @a rowLength values, one for each point
void feed(MeshSink& sink, const Mesh& mesh, std::mt19937& random, std::size_t longest,
          std::span<const float> values = {}, std::size_t rowLength = 0) {
  std::vector<std::uint64_t> firstPoint(mesh.triangles.size() + 1, mesh.points.size());
  for (std::size_t i = mesh.triangles.size(); i-- > 0;) {
    const openvdb::Vec3I& t = mesh.triangles[i];
    firstPoint[i] = std::min<std::uint64_t>({firstPoint[i + 1], t[0], t[1], t[2]});
  }
  const std::span points(mesh.points);
  const std::span normals(mesh.normals);
  const std::span triangles(mesh.triangles);
  std::size_t p = 0, t = 0;
  while (p < points.size() || t < triangles.size()) {
    const std::size_t count = std::min<std::size_t>(random() % (longest + 1), points.size() - p);
    sink.addPoints({points.subspan(p, count), normals.empty() ? normals : normals.subspan(p, count),
                    values.subspan(p * rowLength, count * rowLength)});
    p += count;
    const std::size_t most = random() % (2 * longest + 1);
    std::size_t end = t;
    while (end < triangles.size() && end - t < most &&
           std::max({triangles[end][0], triangles[end][1], triangles[end][2]}) < p)
      ++end;
    sink.addTriangles(triangles.subspan(t, end - t), firstPoint[t]);
    t = end;
  }
}

std::string wholeBytes(const Mesh& mesh, const MeshWriteOptions& options) {
  std::ostringstream stream;
  writeMesh(stream, mesh, options);
  return stream.str();
}

std::string messageOf(const std::function<void()>& act) {
  try {
    act();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "nothing was thrown";
}

using MeshStream = MeshWriter;

/// @return what has come into a stream of either kind when @a mesh came in pieces
std::string streamedBytes(const Mesh& mesh, const MeshWriteOptions& options, bool seekable, std::mt19937& random,
                          std::size_t longest) {
  const TemporaryFolder scratch;
  Pipe pipe;
  std::ostringstream file;
  MeshStreamWriter writer(seekable ? static_cast<std::ostream&>(file) : pipe, scratch.path(), options);
  feed(writer, mesh, random, longest);
  EXPECT_TRUE(std::filesystem::is_empty(scratch.path()));
  writer.finish();
  return seekable ? file.str() : pipe.bytes;
}

// Promise: A mesh that is written while ...
TEST_F(MeshStream, PiecesGiveTheBytesOfTheWhole) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    std::mt19937 random(seed);
    const bool normals = seed % 2 == 1;
    const std::size_t points = 3 + random() % 200, triangles = random() % 400;
    const Mesh mesh = randomMesh(random, points, triangles, normals);
    for (const FileFormat* const format : kFormats)
      for (const double voxelSize : {0.0, 0.1, 1e-5}) {
        SCOPED_TRACE(testing::Message() << "seed " << seed << ", format " << format->name << ", voxels of "
                                        << voxelSize);
        MeshWriteOptions options{.format = format, .voxelSize = voxelSize, .comments = {{"julia_alpha", "40"}}};
        // Its middle is what the positions of a GLB are relative to.
        if (format == &meshFormat(".glb")) options.box = openvdb::BBoxd(Vec3d(-2), Vec3d(2.5));
        if (format == &meshFormat(".stl") && voxelSize == 1e-5) {
          // Its floats are too coarse for these voxels, which both know from the box.
          EXPECT_THROW(wholeBytes(mesh, options), std::invalid_argument);
          options.box = openvdb::BBoxd(Vec3d(-2), Vec3d(2));
          EXPECT_THROW(streamedBytes(mesh, options, true, random, points), std::invalid_argument);
          continue;
        }
        const std::string whole = wholeBytes(mesh, options);
        if (!options.box) options.box = openvdb::BBoxd(Vec3d(-2), Vec3d(2));
        ASSERT_EQ(wholeBytes(mesh, options), whole);
        for (const bool seekable : {true, false}) {
          const std::size_t longest = 1 + random() % points;
          ASSERT_EQ(streamedBytes(mesh, options, seekable, random, longest), whole) << (seekable ? "file" : "pipe");
        }
      }
  }
}

TEST_F(MeshStream, PartsOfSeveralBuffersToo) {
  std::mt19937 random(1);
  const Mesh mesh = randomMesh(random, 100000, 200000, true);
  for (const FileFormat* const format : kFormats)
    for (const bool seekable : {true, false})
      EXPECT_TRUE(streamedBytes(mesh, {.format = format}, seekable, random, 20000) ==
                  wholeBytes(mesh, {.format = format}))
          << format->name << (seekable ? " file" : " pipe");
}

TEST_F(MeshStream, AnEmptyMeshIsWrittenToo) {
  std::mt19937 random;
  for (const FileFormat* const format : kFormats)
    for (const bool seekable : {true, false})
      EXPECT_EQ(streamedBytes({}, {.format = format}, seekable, random, 1), wholeBytes({}, {.format = format}));
}

TEST_F(MeshStream, StandsInTheMidstOfAStream) {
  std::mt19937 random(2);
  const Mesh mesh = randomMesh(random, 50, 80, false);
  for (const FileFormat* const format : kFormats) {
    // Into a longer file that is overwritten.
    std::stringstream stream(std::string(100000, '-'));
    stream << "before";
    MeshStreamWriter writer(stream, mFolder, {.format = format});
    feed(writer, mesh, random, 20);
    writer.finish();
    stream << "after";
    const std::string bytes = "before" + wholeBytes(mesh, {.format = format}) + "after";
    EXPECT_EQ(stream.str().substr(0, bytes.size() + 1), bytes + "-");
  }
}

TEST_F(MeshStream, AFileReadsBack) {
  std::mt19937 random(3);
  const std::filesystem::path path = mFolder / "m.ply";
  for (const double voxelSize : {0.0, 1e-5}) {
    const Mesh mesh = randomMesh(random, 1000, 2000, true);
    const std::map<std::string, std::string> comments{{"julia_alpha", "40"}, {"julia_dots", "...."}};
    AtomicFile file(path);
    MeshStreamWriter writer(file.stream(), mFolder,
                            {.voxelSize = voxelSize, .box = openvdb::BBoxd(Vec3d(-2), Vec3d(2)), .comments = comments});
    feed(writer, mesh, random, 100);
    writer.finish();
    file.commit();
    const Mesh read = readMesh(path);
    EXPECT_EQ(read.points, mesh.points);
    EXPECT_EQ(read.triangles, mesh.triangles);
    EXPECT_EQ(readMeshTexts(path), comments);
  }
}

// Promise: "Where floats would move ..."
TEST_F(MeshStream, TheBoxDecidesWhetherFloatsWillDo) {
  const Mesh mesh = test_meshes::makeCube();
  const auto sizeIn = [&](double reach) {
    return wholeBytes(mesh, {.voxelSize = 0.01, .box = openvdb::BBoxd(Vec3d(-reach), Vec3d(1))}).size();
  };
  EXPECT_EQ(sizeIn(1), wholeBytes(mesh, {.voxelSize = 0.01}).size());
  // Three coordinates of 4 bytes more a point; "double" is a letter longer than "float".
  EXPECT_EQ(sizeIn(1e6), sizeIn(1) + mesh.points.size() * 12 + 3);
}

/// Words are told apart by one blank, every line is of a known kind, and the body is as long as the header says.
void checkStrictly(const std::string& bytes, const Mesh& mesh) {
  const std::size_t body = bytes.find("end_header\n") + 11;
  std::istringstream header(bytes.substr(0, body));
  std::vector<std::string> elements;
  for (std::string line; std::getline(header, line);) {
    EXPECT_EQ(line.find("  "), std::string::npos) << line;
    EXPECT_NE(line.back(), ' ') << line;
    const std::string keyword = line.substr(0, line.find(' '));
    EXPECT_TRUE(
        std::set<std::string>({"ply", "format", "comment", "element", "property", "end_header"}).contains(keyword))
        << line;
    if (keyword == "element") elements.push_back(line);
  }
  EXPECT_EQ(elements, std::vector({"element vertex " + std::to_string(mesh.points.size()),
                                   "element face " + std::to_string(mesh.triangles.size())}));
  EXPECT_EQ(bytes.size() - body, 12 * mesh.points.size() + 13 * mesh.triangles.size());
}

TEST_F(MeshStream, HeadersAreOfOneLengthWhateverTheCounts) {
  std::mt19937 random(4);
  std::size_t length = 0;
  for (const std::size_t points : {9, 10, 99, 100})
    for (const std::size_t triangles : {9, 10, 99, 100, 999, 1000}) {
      const Mesh mesh = randomMesh(random, points, triangles, false);
      const std::string bytes = streamedBytes(mesh, {}, true, random, 7);
      checkStrictly(bytes, mesh);
      const std::size_t header = bytes.find("end_header\n");
      EXPECT_EQ(length == 0 ? header : length, header) << points << " points, " << triangles << " triangles";
      length = header;
    }
}

/// A mesh with a row for each point: a colour, a number, texture coordinates and a vector.
struct ColumnMesh {
  std::mt19937 random{5};
  Mesh mesh = randomMesh(random, 300, 500, true);
  std::vector<VertexColumn> columns{{"Cd", ColumnKind::LinearRgb},
                                    {"trap", ColumnKind::Number},
                                    {"uv", ColumnKind::TextureCoordinate},
                                    {"direction", ColumnKind::Vector}};
  static constexpr std::size_t kRow = 9;
  std::vector<float> values;

  ColumnMesh() {
    std::uniform_real_distribution<float> value(0, 1);
    for (std::size_t i = 0; i < kRow * mesh.points.size(); ++i) values.push_back(value(random));
  }
  float at(std::size_t point, std::size_t k) const { return values[point * kRow + k]; }
};

TEST_F(MeshStream, ColumnsComeBackFromAPly) {
  const ColumnMesh made;
  const auto path = mFolder / "columns.ply";
  std::ofstream file(path, std::ios::binary);
  writeMesh(file, made.mesh, {.columns = made.columns}, made.values);
  file.close();
  const Mesh read = readMesh(path);
  std::vector<std::string> names;
  for (const VertexAttribute& attribute : read.attributes) names.push_back(attribute.name);
  EXPECT_EQ(names,
            std::vector<std::string>({"red", "green", "blue", "trap", "direction_x", "direction_y", "direction_z"}));
  constexpr std::size_t kFirst[] = {0, 1, 2, 3, 6, 7, 8};
  for (std::size_t a = 0; a < read.attributes.size(); ++a)
    for (std::size_t i = 0; i < made.mesh.points.size(); ++i) {
      const float value = made.at(i, kFirst[a]), found = read.attributes[a].values[i];
      if (a < 3) {  // bytes of sRGB: black is 0, white is 1, and 0.2140 in light is half way in code
        EXPECT_NEAR(value, std::pow((found + 0.055) / 1.055, 2.4), 0.01) << names[a];
      } else {
        EXPECT_EQ(value, found) << names[a];
      }
    }
  ASSERT_EQ(read.cornerUvs.size(), 3 * read.triangles.size());
  for (std::size_t t = 0; t < read.triangles.size(); ++t)
    for (unsigned k = 0; k < 3; ++k) {
      const std::size_t i = read.triangles[t][static_cast<int>(k)];
      EXPECT_EQ(read.cornerUvs[3 * t + k], openvdb::Vec2s(made.at(i, 4), made.at(i, 5)));
    }
}

TEST_F(MeshStream, ObjHoldsColoursAndTextureCoordinates) {
  const ColumnMesh made;
  const auto ply = mFolder / "columns.ply", obj = mFolder / "columns.obj";
  for (const auto& path : {ply, obj}) {
    std::ofstream file(path, std::ios::binary);
    writeMesh(file, made.mesh, {.format = &meshFormat(path), .columns = made.columns}, made.values);
  }
  const Mesh fromPly = readMesh(ply), fromObj = readMesh(obj);
  ASSERT_EQ(fromObj.attributes.size(), 3u);
  for (std::size_t a = 0; a < 3; ++a) EXPECT_EQ(fromObj.attributes[a].values, fromPly.attributes[a].values);
  EXPECT_EQ(fromObj.cornerUvs, fromPly.cornerUvs);
}

TEST_F(MeshStream, PiecesWithColumnsGiveTheBytesOfTheWhole) {
  ColumnMesh made;
  for (const FileFormat* const format : kFormats) {
    const MeshWriteOptions options{.format = format, .columns = made.columns};
    std::ostringstream whole, pieces;
    writeMesh(whole, made.mesh, options, made.values);
    MeshStreamWriter writer(pieces, mFolder, options);
    feed(writer, made.mesh, made.random, 20, made.values, ColumnMesh::kRow);
    writer.finish();
    EXPECT_EQ(pieces.str(), whole.str()) << format->name;
  }
}

TEST_F(MeshStream, EveryPointHasARow) {
  const ColumnMesh made;
  std::ostringstream stream;
  MeshStreamWriter writer(stream, mFolder, {.columns = made.columns});
  EXPECT_THROW(writer.addPoints({made.mesh.points, made.mesh.normals}), std::logic_error);
  EXPECT_THROW(writeMesh(stream, made.mesh, {}, made.values), std::logic_error);
}

TEST_F(MeshStream, NothingPassesForAMeshBeforeItIsFinished) {
  const Mesh mesh = test_meshes::makeSphere(1, 5);
  for (const char* name : {"u.ply", "u.stl", "u.glb"}) {
    std::ofstream stream(mFolder / name, std::ios::binary);
    MeshStreamWriter writer(stream, mFolder, {.format = &meshFormat(name)});
    std::mt19937 random;
    feed(writer, mesh, random, 1000);
    stream.flush();
    EXPECT_THROW(readMesh(mFolder / name), DataError) << name;
  }
}

TEST_F(MeshStream, TrianglesKeepToTheWindow) {
  const Mesh mesh = test_meshes::makeCube();
  const std::vector<openvdb::Vec3I> late{{5, 6, 7}}, early{{4, 6, 7}}, future{{6, 7, 8}};
  for (const FileFormat* const format : kFormats) {
    const auto use = [&](const std::vector<openvdb::Vec3I>& triangles, std::uint64_t firstPoint) {
      std::ostringstream stream;
      MeshStreamWriter writer(stream, mFolder, {.format = format});
      writer.addPoints({mesh.points});
      writer.addTriangles(late, 5);
      writer.addTriangles(triangles, firstPoint);
      writer.finish();
    };
    EXPECT_NO_THROW(use(late, 5));
    EXPECT_THROW(use(late, 6), std::logic_error);
    EXPECT_THROW(use(early, 5), std::logic_error);
    EXPECT_THROW(use(early, 0), std::logic_error);  // the earlier call said that none would come
    EXPECT_THROW(use(future, 5), std::logic_error);
    EXPECT_NO_THROW(use({}, 100));  // no triangle at all uses a point before 100
    Mesh outside = mesh;
    outside.triangles.emplace_back(0, 1, 8);
    EXPECT_THROW(wholeBytes(outside, {.format = format}), std::logic_error);
  }
}

// Promise of usage.md: A mesh alone "takes the memory of a few layers of the lattice only"
TEST_F(MeshStream, MemoryFollowsTheWindow) {
  constexpr std::size_t kPiece = 1000, kPieces = 2000;
  const std::vector<Vec3d> points(kPiece);
  std::vector<openvdb::Vec3I> triangles(kPiece);
  std::ofstream nowhere("/dev/null");
  MeshStreamWriter writer(nowhere, mFolder, {.format = &meshFormat(".stl")});
  const auto allocated = [] {
    const struct mallinfo2 info = mallinfo2();
    return info.uordblks + info.hblkhd;
  };
  const std::size_t before = allocated();
  for (std::size_t i = 0; i < kPieces; ++i) {
    writer.addPoints({points});
    for (std::size_t k = 0; k < kPiece; ++k) triangles[k] = openvdb::Vec3I(static_cast<openvdb::Index>(i * kPiece + k));
    writer.addTriangles(triangles, i * kPiece);
  }
  // Twice the window, and what a growing vector holds beyond; all points would be 48 MB.
  EXPECT_LT(allocated(), before + 8 * kPiece * sizeof(Vec3d));
  writer.finish();
}

TEST_F(MeshStream, NormalsComeForAllPointsOrNone) {
  const Mesh mesh = test_meshes::makeCube();
  const std::vector<openvdb::Vec3s> normals(mesh.points.size(), openvdb::Vec3s(0, 0, 1));
  const auto add = [&](std::span<const openvdb::Vec3s> first, std::span<const openvdb::Vec3s> second) {
    std::ostringstream stream;
    MeshStreamWriter writer(stream, mFolder, {});
    writer.addPoints({});
    writer.addPoints({mesh.points, first});
    writer.addPoints({mesh.points, second});
  };
  EXPECT_NO_THROW(add(normals, normals));
  EXPECT_NO_THROW(add({}, {}));
  EXPECT_THROW(add(normals, {}), std::logic_error);
  EXPECT_THROW(add({}, normals), std::logic_error);
  EXPECT_THROW(add(std::span(normals).first(3), {}), std::logic_error);
  Mesh half = mesh;
  half.normals.assign(3, normals[0]);
  EXPECT_THROW(wholeBytes(half, {}), std::logic_error);
}

TEST_F(MeshStream, NothingIsTakenAfterTheEndOrAnError) {
  const Mesh mesh = test_meshes::makeCube();
  std::ostringstream stream;
  MeshStreamWriter finished(stream, mFolder, {});
  finished.finish();
  EXPECT_THROW(finished.finish(), std::logic_error);
  EXPECT_THROW(finished.addPoints({mesh.points}), std::logic_error);
  MeshStreamWriter broken(stream, mFolder, {});
  EXPECT_THROW(broken.addTriangles(mesh.triangles, 0), std::logic_error);
  EXPECT_THROW(broken.finish(), std::logic_error);
}

/// Room for many elements, of which none is ever touched.
template <class T>
class Vast {
 public:
  explicit Vast(std::size_t count)
      : mCount(count),
        mPlace(::mmap(nullptr, count * sizeof(T), PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0)) {}
  ~Vast() {
    if (exists()) ::munmap(mPlace, mCount * sizeof(T));
  }
  Vast(const Vast&) = delete;
  Vast& operator=(const Vast&) = delete;
  bool exists() const { return mPlace != MAP_FAILED; }
  std::span<const T> span() const { return {static_cast<const T*>(mPlace), mCount}; }

 private:
  std::size_t mCount;
  void* mPlace;
};

// Promise: "`merge` refuses a mesh that does ..."
TEST_F(MeshStream, CountsThatDoNotFitAreRefusedAtOnce) {
  const Vast<Vec3d> points(std::size_t{1} << 32);
  const Vast<openvdb::Vec3I> triangles(std::size_t{1} << 32);
  if (!points.exists() || !triangles.exists()) GTEST_SKIP() << "no room of that size can be had here";
  std::ostringstream stream;
  for (const FileFormat* const format : kFormats) {
    MeshStreamWriter writer(stream, mFolder, {.format = format});
    EXPECT_THROW(writer.addPoints({points.span()}), DataError);
    MeshStreamWriter other(stream, mFolder, {.format = format});
    EXPECT_NE(messageOf([&] { other.addPoints({points.span()}); }).find("4294967296"), std::string::npos);
  }
  MeshStreamWriter writer(stream, mFolder, {.format = &meshFormat(".stl")});
  EXPECT_THROW(writer.addTriangles(triangles.span(), 0), std::invalid_argument);
}

// Promise: "`merge` refuses a mesh that does ..."
TEST_F(MeshStream, WhatAFormatCannotCountIsKnownBeforeAMeshIsMade) {
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();
  for (const FileFormat* const format : {&meshFormat(".ply"), &meshFormat(".obj"), &meshFormat(".stl")}) {
    EXPECT_NO_THROW(requireMeshCounts({.format = format}, true, kMost, kMost));
    EXPECT_THROW(requireMeshCounts({.format = format}, true, kMost + 1, 1), DataError);
    if (format == &meshFormat(".stl"))
      EXPECT_THROW(requireMeshCounts({.format = format}, true, 3, kMost + 1), std::invalid_argument);
    else
      EXPECT_NO_THROW(requireMeshCounts({.format = format}, true, kMost, 5 * kMost));
  }
}

// Promise: "`merge` refuses a mesh that does ..."
TEST_F(MeshStream, AGlbIsRefusedFromTheByteOnThatItCannotCount) {
  Mesh mesh = test_meshes::makeSphere(1, 1);
  for (const bool normals : {false, true}) {
    if (normals) computeNormals(mesh);
    std::ostringstream stream;
    writeMesh(stream, mesh, {.format = &meshFormat(".glb")});
    const std::uint64_t point = normals ? 24 : 12, triangle = 12;  // bytes
    const std::uint64_t others = stream.str().size() - mesh.points.size() * point - mesh.triangles.size() * triangle;
    constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();
    for (const std::uint64_t points : {3ul, 1000ul, 70'000'001ul, 150'000'000ul}) {
      const std::uint64_t triangles = (kMost - others - points * point) / triangle;
      EXPECT_NO_THROW(requireMeshCounts({.format = &meshFormat(".glb")}, normals, points, triangles));
      EXPECT_THROW(requireMeshCounts({.format = &meshFormat(".glb")}, normals, points, triangles + 1),
                   std::invalid_argument);
    }
  }
}

TEST_F(MeshStream, VoxelsNeedTheirBox) {
  std::ostringstream stream;
  EXPECT_THROW(MeshStreamWriter(stream, mFolder, {.voxelSize = 0.1}), std::invalid_argument);
  EXPECT_NO_THROW(MeshStreamWriter(stream, mFolder, {.voxelSize = 0.1, .box = openvdb::BBoxd()}));
}

TEST_F(MeshStream, TheScratchFolderIsNamedWhereItFails) {
  std::ostringstream stream;
  const std::filesystem::path missing = mFolder / "nowhere";
  EXPECT_THROW(MeshStreamWriter(stream, missing, {}), CreateError);
  EXPECT_NO_THROW(MeshStreamWriter(stream, "", {}));
  EXPECT_NE(messageOf([&] { MeshStreamWriter(stream, missing, {}); }).find(missing.string()), std::string::npos);

  const std::filesystem::path folder = mFolder / "disk";
  const SmallDisk disk(folder);
  if (!disk.isMounted()) GTEST_SKIP() << "no small file system can be mounted here: " << disk.error();
  std::mt19937 random(5);
  const Mesh mesh = randomMesh(random, 100000, 200000, true);
  for (const FileFormat* const format : kFormats) {
    Pipe pipe;
    MeshStreamWriter writer(pipe, folder, {.format = format});
    const auto write = [&] {
      feed(writer, mesh, random, 10000);
      writer.finish();
    };
    const std::string message = messageOf(write);
    EXPECT_NE(message.find(folder.string()), std::string::npos) << message;
    EXPECT_NE(message.find(std::strerror(ENOSPC)), std::string::npos) << message;
    EXPECT_THROW(writer.finish(), std::logic_error);
  }
  // The room is free again.
  Pipe pipe;
  MeshStreamWriter writer(pipe, folder, {});
  feed(writer, test_meshes::makeCube(), random, 4);
  writer.finish();
  EXPECT_EQ(pipe.bytes, wholeBytes(test_meshes::makeCube(), {}));
}

TEST_F(MeshStream, AFullOutputStopsTheWork) {
  std::mt19937 random(6);
  const Mesh mesh = randomMesh(random, 100000, 200000, false);
  for (const FileFormat* const format : kFormats) {
    const auto write = [&](std::ostream& stream) {
      MeshStreamWriter writer(stream, mFolder, {.format = format});
      feed(writer, mesh, random, 10000);
      writer.finish();
    };
    AtomicFile device("/dev/full");  // no position in it
    EXPECT_THROW(write(device.stream()), IoError);
    EXPECT_THROW(device.commit(), IoError);
    std::ofstream file("/dev/full");  // any position
    EXPECT_THROW(write(file), IoError);
  }
}

}  // namespace
