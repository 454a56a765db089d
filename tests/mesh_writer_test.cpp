// SPDX-License-Identifier: Apache-2.0
#include "test_meshes.h"

#include "vdbtools/extract_mesh.h"
#include "vdbtools/mesh_writer.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <fstream>
#include <sstream>

namespace {

using namespace vdbtools;
using openvdb::Vec3d;

class MeshWriter : public testing::Test {
 protected:
  MeshWriter() : mFolder(std::filesystem::temp_directory_path() / ("juliavdb_writer_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(mFolder);
  }
  ~MeshWriter() override { std::filesystem::remove_all(mFolder); }
  std::filesystem::path write(const char* name, const Mesh& mesh, MeshWriteOptions options) const {
    const std::filesystem::path path = mFolder / name;
    options.format = meshFormat(path);
    std::ofstream stream(path, std::ios::binary);
    writeMesh(stream, mesh, options);
    return path;
  }
  std::filesystem::path mFolder;
};

TEST_F(MeshWriter, EveryFormatReadsBack) {
  Mesh mesh = test_meshes::makeSphere(1.5, 2, Vec3d(0.25, -3, 8));
  for (const bool normals : {false, true}) {
    if (normals) computeNormals(mesh);
    for (const char* name : {"m.ply", "m.OBJ", "m.stl"}) {
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
  EXPECT_EQ(readMeshComments(write("c.ply", mesh, {.comments = comments})), comments);
  EXPECT_EQ(readMeshComments(write("c.obj", mesh, {.comments = comments})), comments);
  EXPECT_TRUE(readMeshComments(write("c.stl", mesh, {.comments = comments})).empty());
  EXPECT_NO_THROW(readMesh(mFolder / "c.ply"));
  EXPECT_NO_THROW(readMesh(mFolder / "c.obj"));
  EXPECT_THROW(readMeshComments(mFolder / "none.ply"), MissingInputError);
}

TEST_F(MeshWriter, OtherFormatsAreRefused) { EXPECT_THROW(meshFormat("a.fbx"), std::invalid_argument); }

}  // namespace
