// SPDX-License-Identifier: Apache-2.0
// A target that is a mesh in memory: the same fractal as from its file, and the same care with what is wrong.
#include "support/temporary_folder.h"
#include "support/test_meshes.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/mesh_files/mesh_writer.h"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>

namespace {

using namespace vdbtools;

const Recipe kRecipe{{"resolution", "30"}, {"sdf-resolution", "40"}, {"detail", "0.4"}, {"texture", "shells"}};

FractalOptions optionsFor(const Mesh& mesh) {
  Recipe recipe = kRecipe;
  recipe["input"] = "memory";
  FractalOptions options = parseFractalOptions(completeRecipe(recipe, fractalOptionTable()));
  options.target->mesh = std::make_shared<const Mesh>(mesh);
  return options;
}

Scene sceneOf(const Mesh& mesh) {
  Monitor monitor;
  return makeScene(optionsFor(mesh), monitor);
}

// Promise: A target of arrays is as good ...
TEST(MemoryTarget, MakesTheFractalOfItsFile) {
  openvdb::initialize();
  const TemporaryFolder folder;
  const Mesh mesh = test_meshes::makeSphere(1.3, 3);
  const std::string path = folder.path() / "sphere.obj";
  std::ofstream file(path);
  writeMesh(file, mesh, {.format = &meshFormat(".obj")});
  file.close();
  Recipe recipe = kRecipe;
  recipe["input"] = path;
  Monitor monitor;
  const Scene fromFile = makeScene(parseFractalOptions(completeRecipe(recipe, fractalOptionTable())), monitor);
  const Scene fromMemory = sceneOf(mesh);
  const Mesh a = fractalMesh(fromFile, monitor), b = fractalMesh(fromMemory, monitor);
  EXPECT_GT(a.triangles.size(), 1000u);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(fromFile.metadata.at("julia_space_scale"), fromMemory.metadata.at("julia_space_scale"));
}

// Promise: A target of arrays is as good ...
TEST(MemoryTarget, ItsHashChangesWithEveryPartOfTheMesh) {
  const Mesh mesh = test_meshes::makeCube();
  Mesh moved = mesh, turned = mesh;
  moved.points[3][1] = std::nextafter(moved.points[3][1], 9.0);
  std::swap(turned.triangles[2][0], turned.triangles[2][1]);
  EXPECT_EQ(sha256OfMesh(mesh), sha256OfMesh(test_meshes::makeCube()));
  EXPECT_NE(sha256OfMesh(mesh), sha256OfMesh(moved));
  EXPECT_NE(sha256OfMesh(mesh), sha256OfMesh(turned));
}

TEST(MemoryTarget, RefusesWhatNoFileWouldGive) {
  const Mesh cube = test_meshes::makeCube();
  Mesh empty = cube, wild = cube, broken = cube;
  empty.triangles.clear();
  wild.points[2][0] = std::numeric_limits<double>::quiet_NaN();
  broken.triangles[1][2] = static_cast<openvdb::Index32>(cube.points.size());
  for (const Mesh& mesh : {empty, wild, broken}) EXPECT_THROW(sceneOf(mesh), DataError);
}

}  // namespace
