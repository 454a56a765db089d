// SPDX-License-Identifier: Apache-2.0
// Which way is up in files: turned exactly, the same shape in every format, and told by the file itself.
#include "support/temporary_folder.h"
#include "support/test_fields.h"
#include "support/test_meshes.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/render/camera.h"
#include "vdbtools/surface/extract_mesh.h"
#include "vdbtools/surface/level_set.h"

#include <gtest/gtest.h>

#include <sstream>

namespace {

using namespace vdbtools;
using openvdb::FloatGrid;
using openvdb::Vec3d;
using openvdb::Vec3s;

const Vec3d kPoint(1.25, -2.5, 0.75);

// Promise of handoff.md: The turn "only exchanges coordinates, so that nothing is rounded"; "the voxels are the same"
TEST(UpTurn, IsAnExactTurnThatTakesUpToUp) {
  for (const UpAxis from : {UpAxis::Y, UpAxis::Z})
    for (const UpAxis to : {UpAxis::Y, UpAxis::Z}) {
      const UpTurn turn(from, to), back(to, from);
      EXPECT_EQ(turn.turns(), from != to);
      EXPECT_EQ(turn(directionOf(from)), directionOf(to));
      EXPECT_EQ(back(turn(kPoint)), kPoint);
      const Vec3d x = turn(Vec3d(1, 0, 0)), y = turn(Vec3d(0, 1, 0)), z = turn(Vec3d(0, 0, 1));
      EXPECT_EQ(x.cross(y), z) << "a turn, and no mirror";
      EXPECT_EQ(x, Vec3d(1, 0, 0));
      const openvdb::BBoxd box = turn(openvdb::BBoxd(Vec3d(-1, 2, -5), Vec3d(3, 4, 6)));
      for (const Vec3d& corner : {Vec3d(-1, 2, -5), Vec3d(3, 4, 6), Vec3d(-1, 4, 6)})
        EXPECT_TRUE(box.isInside(turn(corner)));
      EXPECT_EQ(box.volume(), 4 * 2 * 11);
    }
}

// Promise: The table of `--up` and formats; "The metadata ..."
TEST(FileAxes, FollowTheRuleAndGlbHasYUpAlways) {
  const FileFormat* const kFormats[] = {&meshFormat(".ply"), &meshFormat(".obj"), &meshFormat(".stl"),
                                        &meshFormat(".glb")};
  for (const UpAxis target : {UpAxis::Y, UpAxis::Z}) {
    EXPECT_EQ((FileAxes{target, UpRule::Keep}).ofVdb(), target);
    EXPECT_EQ((FileAxes{target, UpRule::Auto}).ofVdb(), UpAxis::Y);
    for (const FileFormat* const format : kFormats) {
      const bool glb = format == &meshFormat(".glb"),
                 upright = format == &meshFormat(".ply") || format == &meshFormat(".stl");
      EXPECT_EQ((FileAxes{target, UpRule::Keep}).of(*format), glb ? UpAxis::Y : target);
      EXPECT_EQ((FileAxes{target, UpRule::Z}).of(*format), glb ? UpAxis::Y : UpAxis::Z);
      EXPECT_EQ((FileAxes{target, UpRule::Auto}).of(*format), upright ? UpAxis::Z : UpAxis::Y);
      const MeshWriteOptions options = meshWriteOptions(*format, FileAxes{target, UpRule::Auto}, {});
      EXPECT_EQ(options.turn.turns(), target != (upright ? UpAxis::Z : UpAxis::Y));
      EXPECT_EQ(recordedUpAxis(options.comments), upright ? UpAxis::Z : UpAxis::Y);
    }
  }
}

// Promise: The turn "only exchanges ..."
TEST(FileAxes, MeshesAreTurnedWhateverTheirPieces) {
  Mesh mesh = test_meshes::makeSphere(1, 2, kPoint), turned = mesh;
  computeNormals(mesh);
  const UpTurn turn(UpAxis::Y, UpAxis::Z);
  turned.normals = mesh.normals;
  for (Vec3d& point : turned.points) point = turn(point);
  for (Vec3s& normal : turned.normals) normal = turn(normal);
  std::vector<float> values(3 * mesh.points.size());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i) / 1000;
  for (const FileFormat* const format :
       {&meshFormat(".ply"), &meshFormat(".obj"), &meshFormat(".stl"), &meshFormat(".glb")}) {
    // Coordinates so large against the voxels that the box decides on doubles, which an STL does not have.
    const double voxelSize = format == &meshFormat(".stl") ? 1e-3 : 1e-7;
    MeshWriteOptions options{.format = format, .voxelSize = voxelSize, .columns = {{"direction", ColumnKind::Vector}}};
    std::ostringstream expected, whole, pieces;
    writeMesh(expected, turned, options, values);
    options.turn = turn;
    writeMesh(whole, mesh, options, values);
    EXPECT_TRUE(whole.str() == expected.str()) << "format " << format->name;
    options.box.emplace();
    for (const Vec3d& point : mesh.points) options.box->expand(point);
    const TemporaryFolder folder;
    MeshStreamWriter writer(pieces, folder.path(), options);
    const std::size_t half = mesh.points.size() / 2;
    const std::span points(mesh.points);
    const std::span normals(mesh.normals);
    const std::span<const float> rows(values);
    writer.addPoints({points.first(half), normals.first(half), rows.first(3 * half)});
    writer.addPoints({points.subspan(half), normals.subspan(half), rows.subspan(3 * half)});
    writer.addTriangles(mesh.triangles, 0);
    writer.finish();
    EXPECT_TRUE(pieces.str() == expected.str()) << "in pieces, format " << format->name;
  }
}

// Promise: The turn "only exchanges ..."
// Promise of handoff.md: A VDB with Y up has a "creator" that begins with "Houdini", and one with Z up has not
TEST(FileAxes, VdbsAreTurnedThroughTheirTransforms) {
  const TemporaryFolder folder;
  const FloatGrid::Ptr grid = test_fields::bandGrid(
      [](const Vec3d& p) { return (p - Vec3d(0.3, 0.2, -0.1)).length() - 0.6; }, 0.05, 0.15, 0.15);
  grid->setName("surface");
  const std::string before = encodeVdb({grid}, {});
  for (const UpAxis target : {UpAxis::Y, UpAxis::Z})
    for (const UpRule rule : {UpRule::Keep, UpRule::Y, UpRule::Z}) {
      const FileAxes axes{target, rule};
      const VdbFile file = readVdb(folder.write("a.vdb", encodeVdb({grid}, vdbWriteOptions(axes, {{"julia_x", "1"}}))));
      const UpTurn turn(target, axes.ofVdb());
      EXPECT_EQ(recordedUpAxis(file.metadata, UpAxis::Y), axes.ofVdb());
      EXPECT_EQ(file.metadata.at("julia_x"), "1");
      // What Blender looks at.
      EXPECT_EQ(file.metadata.at("creator").starts_with("Houdini"), axes.ofVdb() == UpAxis::Y);
      const FloatGrid::Ptr read = chooseFloatGrid(file, "", "a.vdb");
      EXPECT_EQ(read->activeVoxelCount(), grid->activeVoxelCount());
      for (auto value = grid->cbeginValueOn(); value; ++value) {
        const Vec3d at = read->indexToWorld(value.getCoord());
        ASSERT_EQ(read->tree().getValue(value.getCoord()), *value);
        ASSERT_LT((at - turn(grid->indexToWorld(value.getCoord()))).length(), 1e-12);
      }
      EXPECT_TRUE(read->hasUniformVoxels());
      EXPECT_EQ(checkSurface(*read).failure, checkSurface(*grid).failure);
    }
  EXPECT_EQ(encodeVdb({grid}, {}), before) << "the grid itself stays as it is";
}

TEST(FileAxes, CamerasTurnWithTheWorld) {
  const UpTurn turn(UpAxis::Y, UpAxis::Z);
  for (const double elevation : {-90.0, -30.0, 0.0, 45.0, 90.0}) {
    const ViewAngles angles{.azimuth = 25, .elevation = elevation};
    const Camera upright = cameraAround({kPoint, 2}, angles, 1.5);
    const Camera turned = cameraAround({turn(kPoint), 2}, angles, 1.5, UpAxis::Z);
    EXPECT_LT((turned.eye - turn(upright.eye)).length(), 1e-12);
    EXPECT_EQ(turned.lookAt, turn(upright.lookAt));
    EXPECT_LT((turned.up - turn(upright.up)).length(), 1e-12);
    EXPECT_EQ(turned.fieldOfView, upright.fieldOfView);
  }
}

}  // namespace
