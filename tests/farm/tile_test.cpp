// SPDX-License-Identifier: Apache-2.0
// Tiles: however a lattice is cut, what is merged has the bytes of one run.
#include "farm/tile_count.h"
#include "farm/tile_file.h"
#include "support/mesh_laws.h"
#include "support/temporary_folder.h"
#include "support/test_meshes.h"

#include "scene/prepared_scene.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/farm/manifest.h"
#include "vdbtools/farm/merge.h"
#include "vdbtools/farm/plans.h"
#include "vdbtools/farm/task.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/mesh_files/mesh_writer.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <sstream>

namespace {

using namespace vdbtools;
using namespace vdbtools::farm;
namespace fs = std::filesystem;
using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::Vec3d;

class Tiles : public testing::Test {
 protected:
  Tiles() {
    // Two lobes off the centre, one thin: nothing is symmetric, and no face of the lattice's blocks is special.
    const Mesh body = test_meshes::transformed(test_meshes::makeSphere(1, 3), 1, Vec3d(0.31, -0.17, 0.23));
    Mesh arm = test_meshes::makeBox(Vec3d(0.9, -0.4, 0.1), Vec3d(2.1, -0.1, 0.35));
    std::ostringstream stream;
    writeMesh(stream, test_meshes::merged(body, arm), {.format = &meshFormat(".obj")});
    mShape = mFolder.write("shape.obj", stream.str()).string();
  }

  Recipe shape(const Recipe& others) const {
    Recipe recipe = {{"input", mShape}, {"sdf-resolution", "32"}, {"resolution", "32"}};
    for (const auto& [name, value] : others) recipe[name] = value;
    return completed(recipe);
  }
  static Recipe completed(const Recipe& recipe) { return completeRecipe(recipe, fractalOptionTable()); }

  /// Plans, makes every task, and gives the folder.
  fs::path made(const Recipe& recipe, const TilePlanOptions& cut) {
    const fs::path folder = mFolder.path() / ("plan" + std::to_string(++mPlans));
    mPlan = planTiles(parseFractalOptions(recipe), recipe, cut, folder, mMonitor);
    writePlan(folder, mPlan.manifest);
    TaskRunner runner(folder);
    // In no particular order.
    std::vector<std::uint64_t> order(mPlan.manifest.tasks.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i + 1;
    std::shuffle(order.begin(), order.end(), std::mt19937(7));
    for (const std::uint64_t index : order) EXPECT_TRUE(runner.run(index, mMonitor));
    return folder;
  }

  std::string inFolder(const std::string& name) const { return (mFolder.path() / name).string(); }

  /// One run's files, called one.vdb and one.EXTENSION.
  FractalResult makeOneRun(const Recipe& recipe, const std::string& extension) {
    AtomicFile vdb(inFolder("one.vdb")), mesh(inFolder("one." + extension));
    const Scene scene = makeScene(parseFractalOptions(recipe), mMonitor);
    FractalResult result = writeFractal(
        scene, recipe, {.files = {{&vdb, findFormat(".vdb")}, {&mesh, &meshFormat("a." + extension)}}}, mMonitor);
    vdb.commit();
    mesh.commit();
    return result;
  }

  /// @return the crumbs that one run has dropped
  CrumbReport expectOneRun(const Recipe& recipe, const std::vector<TilePlanOptions>& cuts,
                           const std::string& extension = "ply") {
    const std::optional<CrumbReport> crumbs = makeOneRun(recipe, extension).crumbs;
    for (TilePlanOptions cut : cuts) {
      SCOPED_TRACE(cut.tiles ? "tiles " + std::to_string(*cut.tiles) : "nodes " + std::to_string(*cut.tileNodes));
      cut.makes = {"vdb", extension};
      const fs::path folder = made(recipe, cut);
      const MergeResult result = mergePlan(
          folder, readManifest(folder), {.grids = inFolder("all.vdb"), .mesh = inFolder("all." + extension)}, mMonitor);
      EXPECT_EQ(result.crumbs.has_value(), crumbs.has_value());
      if (crumbs && result.crumbs) {
        EXPECT_EQ(result.crumbs->crumbs, crumbs->crumbs);
        EXPECT_EQ(result.crumbs->nodes, crumbs->nodes);
      }
      EXPECT_TRUE(readWholeFile(inFolder("all.vdb")) == readWholeFile(inFolder("one.vdb")));
      EXPECT_TRUE(readWholeFile(inFolder("all." + extension)) == readWholeFile(inFolder("one." + extension)));
    }
    return crumbs.value_or(CrumbReport());
  }

  TemporaryFolder mFolder;
  Monitor mMonitor;
  std::string mShape;
  TilePlan mPlan;
  int mPlans = 0;
};

// Promise: What is merged "has the same ..."
TEST_F(Tiles, AShapeIsThatOfOneRun) {
  // Cuts between blocks of 8 nodes, and through them.
  expectOneRun(shape({{"alpha", "6"}}), {{.tiles = 2}, {.tileNodes = 11}});
  expectOneRun(shape({{"alpha", "40"}, {"origin", "centre"}}), {{.tiles = 7}, {.tileNodes = 16}, {.tileNodes = 23}});
  expectOneRun(shape({{"detail", "0.5"}}), {{.tiles = 64}, {.tileNodes = 13}});
}

// Promise: "pictures, meshes, VDBs, tiles ..."
// Promise of attributes.md: "`plan tiles` and `merge` give the bytes of one run with all attributes but `mask`, which
//   they refuse"
TEST_F(Tiles, AttributesAreThoseOfOneRun) {
  const std::string all = "Cd,direction,trap,iterations,depth,tau";
  expectOneRun(shape({{"detail", "0.5"}, {"attributes", all}, {"colour", "depth:magma"}, {"half", "true"}}),
               {{.tiles = 5}, {.tileNodes = 13}});
  // Where tiles have no grid of their own.
  expectOneRun(shape({{"alpha", "6"}, {"attributes", "Cd,trap"}, {"grids", "logmodulus"}}), {{.tiles = 3}});
  expectOneRun(shape({{"alpha", "6"}, {"attributes", "Cd"}, {"largest", "1"}}), {{.tiles = 3}});
  expectOneRun(shape({{"alpha", "6"}, {"colour", "clay"}}), {{.tiles = 2}}, "obj");
}

// Promise: "`plan tiles` and `merge` ..."
TEST_F(Tiles, WhatIsTransferredIsThatOfOneRun) {
  const Mesh ball = test_meshes::makeSphere(1, 3);
  std::ostringstream text;
  text << "ply\nformat ascii 1.0\nelement vertex " << ball.points.size()
       << "\nproperty double x\nproperty double y\nproperty double z\nproperty float wet\nelement face "
       << ball.triangles.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Vec3d& p : ball.points) text << p[0] << ' ' << p[1] << ' ' << p[2] << ' ' << p[0] * p[1] << '\n';
  for (const openvdb::Vec3I& t : ball.triangles) text << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
  Recipe recipe = shape({{"alpha", "12"}, {"transfer", "wet"}});
  recipe["input"] = mFolder.write("ball.ply", text.str()).string();
  expectOneRun(recipe, {{.tiles = 4}});
}

// Promise: "neither tiles nor threads ..."
// Promise: What is merged "has the same ..."
TEST_F(Tiles, RandomCutsAreThoseOfOneRun) {
  std::mt19937 random(20261122);
  std::vector<TilePlanOptions> cuts;
  for (int i = 0; i < 3; ++i) cuts.push_back({.tiles = 2 + static_cast<int>(random() % 63)});
  for (int i = 0; i < 3; ++i) cuts.push_back({.tileNodes = 9 + static_cast<int>(random() % 40)});
  expectOneRun(shape({{"detail", "0.3"}, {"resolution", "30"}}), cuts);
}

// Promise of farm.md: "Crumbs are dropped in each tile, and `merge` says how many there were in all: as many as in one
//   run"
TEST_F(Tiles, CrumbsAcrossBordersAreThoseOfOneRun) {
  std::mt19937 random(20261124);
  const auto cuts = [&] {
    return std::vector<TilePlanOptions>{{.tiles = 2 + static_cast<int>(random() % 40)},
                                        {.tileNodes = 7 + static_cast<int>(random() % 9)},
                                        {.tileNodes = 16 + static_cast<int>(random() % 9)}};
  };
  const Recipe dusty = {{"alpha", "8"}, {"texture", "random"}, {"resolution", "40"}, {"crumbs", "drop"}};
  EXPECT_GT(expectOneRun(shape(dusty), cuts()).crumbs, 20U);
  Recipe box = dusty;
  box["box"] = "-0.4,-0.9,-0.35,1.5,0.6,0.9";
  EXPECT_GT(expectOneRun(shape(box), cuts()).crumbs, 10U);
  box["grids"] = "surface,logmodulus";
  box["largest"] = "2";
  expectOneRun(shape(box), {{.tileNodes = 9}});
  Recipe bulb = {{"map", "mandelbulb"}, {"resolution", "40"}, {"crumbs", "drop"}};
  EXPECT_GT(expectOneRun(completed(bulb), cuts()).crumbs, 20U);
  bulb["crumbs"] = "keep";
  EXPECT_EQ(expectOneRun(completed(bulb), {{.tiles = 5}}).crumbs, 0U);
}

TEST_F(Tiles, ABoxIsThatOfOneRunWithItsCapsOrWithout) {
  const Recipe box = {{"box", "-0.4,-0.9,-0.35,1.5,0.6,0.9"}, {"resolution", "30"}};
  expectOneRun(shape(box), {{.tiles = 5}, {.tileNodes = 14}});
  Recipe capped = box;
  capped["cap"] = "true";
  expectOneRun(shape(capped), {{.tiles = 5}, {.tileNodes = 14}});
}

// Promise: What is merged "has the same ..."
TEST_F(Tiles, EveryGridIsThatOfOneRun) {
  const Recipe grids = {{"grids", "iterations,versor,surface,density,logmodulus"}, {"resolution", "24"}};
  expectOneRun(shape(grids), {{.tiles = 6}, {.tileNodes = 13}});
  Recipe cut = grids;
  cut["box"] = "-0.4,-0.9,-0.35,1.5,0.6,0.9";
  cut["half"] = "true";
  expectOneRun(shape(cut), {{.tileNodes = 13}});
}

// Promise: The turn "only exchanges ..."
TEST_F(Tiles, TurnedFilesAreThoseOfOneRun) {
  expectOneRun(shape({{"resolution", "24"}, {"up", "auto"}}), {{.tileNodes = 13}});
  expectOneRun(shape({{"resolution", "24"}, {"target-up", "z"}, {"up", "y"}}), {{.tileNodes = 13}}, "obj");
}

// Promise: What is merged "has the same ..."
TEST_F(Tiles, FormatsThatKeepDoublesAreThoseOfOneRun) {
  expectOneRun(shape({{"resolution", "24"}}), {{.tileNodes = 13}}, "obj");
  expectOneRun(shape({{"resolution", "24"}}), {{.tileNodes = 13}}, "stl");
  expectOneRun(shape({{"resolution", "24"}, {"lod", "100%,30%"}}), {{.tileNodes = 13}}, "glb");
  // So far away that a PLY has doubles.
  std::ostringstream stream;
  writeMesh(stream, test_meshes::transformed(test_meshes::makeSphere(1, 3), 1, Vec3d(40000, -70000, 90000)),
            {.format = &meshFormat(".obj")});
  const std::string far = mFolder.write("far.obj", stream.str()).string();
  expectOneRun(completed({{"input", far}, {"sdf-resolution", "30"}, {"resolution", "24"}}),
               {{.tiles = 5}, {.tileNodes = 13}});
}

// Promise: What is merged "has the same ..."
TEST_F(Tiles, MapsWithoutAShellAreThoseOfOneRun) {
  expectOneRun(completed({{"map", "cross"}, {"scheme", "5"}, {"pair", "A"}, {"c", "0.39,0.2,0"}, {"resolution", "24"}}),
               {{.tiles = 4}, {.tileNodes = 11}});
  expectOneRun(completed({{"map", "quadratic"}, {"c", "-0.2,0.6,0.2,0.2"}, {"resolution", "24"}}), {{.tileNodes = 17}});
  expectOneRun(shape({{"map", "rational"}, {"texture-roots", "5"}, {"resolution", "24"}}),
               {{.tiles = 3}, {.tileNodes = 19}});
}

// Every piece is a mesh by itself, and together they are the whole: the same triangles, whose neighbours they share
// points with.
TEST_F(Tiles, PiecesAddUpToTheWhole) {
  const Recipe recipe = shape({{"resolution", "30"}});
  makeOneRun(recipe, "ply");
  const fs::path folder = made(recipe, {.tileNodes = 17, .makes = {"vdb", "ply"}});
  const MergeResult result = writeTileFiles(folder, readManifest(folder), inFolder("pieces.json"), mMonitor);
  const auto index = nlohmann::json::parse(readWholeFile(inFolder("pieces.json")));
  Mesh together;
  std::uint64_t triangles = 0, active = 0;
  const auto whole = chooseFloatGrid(readVdb(inFolder("one.vdb")), "surface", "one.vdb");
  for (const auto& tile : index.at("tiles"))
    for (const auto& file : tile.at("files")) {
      const std::string name = inFolder(file.at("name").get<std::string>());
      EXPECT_EQ(fs::file_size(name), file.at("bytes").get<std::uint64_t>());
      if (isVdbPath(name)) {
        const auto part = chooseFloatGrid(readVdb(name), "surface", name);
        active += part->activeVoxelCount();
        for (auto value = part->cbeginValueOn(); value; ++value)
          ASSERT_EQ(*value, whole->tree().getValue(value.getCoord()));
        continue;
      }
      const Mesh piece = readMesh(name);
      EXPECT_EQ(piece.triangles.size(), tile.at("triangles").get<std::uint64_t>());
      EXPECT_EQ(piece.points.size(), tile.at("points").get<std::uint64_t>());
      triangles += piece.triangles.size();
      together = test_meshes::merged(together, piece);
    }
  const Mesh one = readMesh(inFolder("one.ply"));
  EXPECT_EQ(triangles, one.triangles.size());
  EXPECT_EQ(result.mesh.triangles, one.triangles.size());
  EXPECT_EQ(active, whole->activeVoxelCount());
  const Mesh welded = weldMesh(together);
  EXPECT_EQ(welded.points.size(), weldMesh(one).points.size());
  EXPECT_EQ(mesh_laws::notClosedManifold(welded), mesh_laws::notClosedManifold(weldMesh(one)));
}

TEST_F(Tiles, AMeshOfTooManyPointsIsCutIntoFiles) {
  const Recipe recipe = shape({{"resolution", "90"}});
  makeOneRun(recipe, "ply");
  const Mesh one = readMesh(inFolder("one.ply"));
  const fs::path folder = made(recipe, {.tiles = 3, .makes = {"ply"}});
  const std::uint64_t most = one.points.size() / 2;
  const MergeResult result =
      mergePlan(folder, readManifest(folder), {.mesh = inFolder("cut.ply"), .mostPoints = most}, mMonitor);
  ASSERT_GE(result.files.size(), 2U);
  // The same triangles in the same order.
  std::size_t at = 0;
  for (const fs::path& file : result.files) {
    const Mesh part = readMesh(file);
    EXPECT_LE(part.points.size(), most);
    for (const openvdb::Vec3I& triangle : part.triangles) {
      ASSERT_LT(at, one.triangles.size());
      for (int k = 0; k < 3; ++k) ASSERT_EQ(part.points[triangle[k]], one.points[one.triangles[at][k]]);
      ++at;
    }
  }
  EXPECT_EQ(at, one.triangles.size());
  EXPECT_THROW(mergePlan(folder, readManifest(folder), {.mesh = inFolder("x.ply"), .mostPoints = 5}, mMonitor),
               DataError);
  EXPECT_FALSE(fs::exists(inFolder("x.ply"))) << "half a mesh stayed";
  EXPECT_FALSE(fs::exists(inFolder("x.1.ply"))) << "half a mesh stayed";
}

TEST_F(Tiles, APreparedSceneEvaluatesTheSameBits) {
  std::vector<Recipe> recipes{shape({{"detail", "x:0.1:0.5"}}), shape({{"alpha", "30"}, {"sampling", "quadratic"}}),
                              completed({{"map", "mandelbulb"}, {"resolution", "30"}})};
  // Roots that are strewn by the distances, which have been in a file for the second scene.
  std::ostringstream ball;
  writeMesh(ball, test_meshes::makeSphere(0.7, 3, Vec3d(0.3, -5.1, 2.7)), {.format = &meshFormat(".obj")});
  const std::string mesh = mFolder.write("ball.obj", ball.str()).string();
  for (const char* placement : {"surface", "inside"})
    for (const char* resolution : {"23", "29", "31"})
      recipes.push_back(completed(
          {{"input", mesh}, {"sdf-resolution", resolution}, {"texture", "random"}, {"texture-placement", placement}}));
  for (const Recipe& recipe : recipes) {
    const FractalOptions options = parseFractalOptions(recipe);
    const Scene scene = makeScene(options, mMonitor);
    const Scene again = readPreparedScene(options, mFolder.write("prepared.vdb", encodePreparedScene(scene)));
    EXPECT_EQ(again.metadata, scene.metadata);
    std::mt19937 random(3);
    std::vector<julia::Point> points(4000);
    for (julia::Point& point : points)
      for (double& x : point) x = static_cast<double>(random()) / 0x1p31 - 1;
    std::vector<double> one(points.size()), other(points.size());
    scene.field.evaluator->evaluate(points, one, {});
    again.field.evaluator->evaluate(points, other, {});
    EXPECT_EQ(one, other);
    EXPECT_EQ(planScene(scene).domain, planScene(again).domain);
    EXPECT_EQ(planScene(scene).blocks->activeVoxelCount(), planScene(again).blocks->activeVoxelCount());
  }
}

TEST_F(Tiles, WhatCannotBeMergedIsRefused) {
  const Recipe recipe = shape({{"resolution", "20"}});
  const fs::path folder = made(recipe, {.tiles = 3, .makes = {"ply"}});
  const Manifest manifest = readManifest(folder);
  EXPECT_THROW(mergePlan(folder, manifest, {.grids = inFolder("a.vdb")}, mMonitor), std::invalid_argument);
  EXPECT_THROW(mergePlan(folder, manifest, {.mesh = inFolder("a.stl")}, mMonitor), std::invalid_argument);
  const fs::path tile = folder / "tiles" / "0002.tile";
  const std::string bytes = readWholeFile(tile);
  std::string other = bytes;
  other[other.size() / 2] = static_cast<char>(other[other.size() / 2] ^ 1);
  mFolder.write("plan" + std::to_string(mPlans) + "/tiles/0002.tile", other);
  try {
    mergePlan(folder, manifest, {.mesh = inFolder("a.ply")}, mMonitor);
    ADD_FAILURE() << "a tile that was changed has passed";
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find("task 2"), std::string::npos) << error.what();
  }
  EXPECT_FALSE(fs::exists(inFolder("a.ply")));
}

// Promise: "`merge` refuses a mesh that does ..."
TEST_F(Tiles, AMeshHasNoMorePointsThanItsTrianglesCanReferTo) {
  const fs::path folder = made(shape({{"resolution", "20"}}), {.tiles = 2, .makes = {"ply"}});
  const Manifest manifest = readManifest(folder);
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();
  EXPECT_THROW(mergePlan(folder, manifest, {.mesh = inFolder("a.ply"), .mostPoints = kMost + 1}, mMonitor),
               std::invalid_argument);
  EXPECT_FALSE(fs::exists(inFolder("a.ply")));
  EXPECT_NO_THROW(mergePlan(folder, manifest, {.mesh = inFolder("a.ply"), .mostPoints = kMost}, mMonitor));
}

TEST_F(Tiles, BrokenTilesAreRefused) {
  const fs::path folder = made(shape({{"resolution", "20"}}), {.tiles = 1, .makes = {"ply"}});
  const std::string bytes = readWholeFile(folder / "tiles" / "0001.tile");
  const auto read = [&](const std::string& content) {
    TileReader tile(mFolder.write("broken.tile", content));
    while (tile.nextX()) tile.next();
  };
  EXPECT_NO_THROW(read(bytes));
  for (std::size_t size = 0; size < bytes.size(); size += 1 + bytes.size() / 97)
    EXPECT_THROW(read(bytes.substr(0, size)), DataError) << size;
  std::string magic = bytes;
  magic[3] = '?';
  EXPECT_THROW(read(magic), DataError);
  // A count that no memory holds.
  std::string huge = bytes;
  for (std::size_t i = 52; i < 56; ++i) huge[i] = '\xff';
  EXPECT_THROW(read(huge), DataError);
  EXPECT_THROW(TileReader(inFolder("none.tile")), MissingInputError);
}

// Promise: With `--make count`, "The numbers ..."
TEST_F(Tiles, ACountIsThatOfTheTilesThatAnotherPlanKeeps) {
  const Recipe recipe = shape({{"detail", "0.5"}});
  const fs::path counted = made(recipe, {.tiles = 5, .makes = {"count"}});
  const fs::path kept = made(recipe, {.tiles = 5, .makes = {"ply"}});
  const std::size_t tiles = mPlan.manifest.tasks.size();
  ASSERT_GT(tiles, 1u);
  for (std::size_t i = 1; i <= tiles; ++i) {
    const std::string name = "tiles/" + taskName(i);
    const TileCount count = parseTileCount(readWholeFile(counted / (name + ".json")));
    const TileReader tile(kept / (name + ".tile"));
    EXPECT_EQ(count.points, tile.counts().points);
    EXPECT_EQ(count.triangles, tile.counts().triangles);
    EXPECT_EQ(count.sha256, sha256OfFile(kept / (name + ".tile")));
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(counted / "tiles"), fs::directory_iterator()),
            static_cast<std::ptrdiff_t>(tiles));

  const MergeResult result = mergeCounts(counted, readManifest(counted), inFolder("count.json"), mMonitor);
  const Mesh mesh = fractalMesh(makeScene(parseFractalOptions(recipe), mMonitor), mMonitor);
  EXPECT_EQ(result.mesh.triangles, mesh.triangles.size());
  EXPECT_EQ(result.mesh.points, mesh.points.size());
  const auto json = nlohmann::json::parse(readWholeFile(inFolder("count.json")));
  EXPECT_EQ(json.at("triangles"), mesh.triangles.size());
  EXPECT_EQ(json.at("tiles"), tiles);
  EXPECT_EQ(json.at("recipe").at("julia_detail"), "0.5");
  openvdb::BBoxd box;
  for (const Vec3d& point : mesh.points) box.expand(point);
  const auto numbers = json.at("box").get<std::vector<double>>();
  EXPECT_EQ(Vec3d(numbers.data()), box.min());
  EXPECT_EQ(Vec3d(numbers.data() + 3), box.max());
}

// The tasks of a plan share a scene in one process, and none in processes of their own.
// Promise: Tasks "can run in any order, at any ..."
TEST_F(Tiles, OneProcessMakesTheFilesOfOneForEachTask) {
  for (const std::vector<std::string>& makes : std::vector<std::vector<std::string>>{{"ply"}, {"count"}, {"vdb"}}) {
    const fs::path together = made(shape({{"detail", "0.5"}}), {.tileNodes = 19, .makes = makes});
    const fs::path apart = inFolder("apart-" + makes.front());
    fs::create_directory(apart);
    for (const char* name : {kManifestName, "prepared.vdb"}) fs::copy_file(together / name, apart / name);
    ASSERT_GT(mPlan.manifest.tasks.size(), 3u);
    for (std::size_t i = 1; i <= mPlan.manifest.tasks.size(); ++i) EXPECT_TRUE(TaskRunner(apart).run(i, mMonitor));
    for (const PlannedTask& task : mPlan.manifest.tasks)
      for (const std::string& name : task.writes)
        EXPECT_TRUE(readWholeFile(together / name) == readWholeFile(apart / name)) << name;
  }
}

// Grids need the whole field of a tile. A tile that has none is made in layers, and has the same mesh.
// Promise: What is merged "has the same ..."
TEST_F(Tiles, AStreamedTileIsThatOfAHeldField) {
  const Recipe box = {{"box", "-0.4,-0.9,-0.35,1.5,0.6,0.9"}};
  Recipe capped = box;
  capped["cap"] = "true";
  const std::vector<Recipe> recipes = {
      shape({{"detail", "0.5"}}),
      shape(box),
      shape(capped),
      shape({{"alpha", "8"}, {"texture", "random"}, {"crumbs", "drop"}}),
      completed({{"map", "cross"}, {"scheme", "5"}, {"pair", "A"}, {"c", "0.39,0.2,0"}, {"resolution", "24"}}),
      completed({{"map", "mandelbulb"}, {"resolution", "30"}, {"crumbs", "drop"}})};
  for (std::size_t i = 0; i < recipes.size(); ++i)
    for (const char* grids : {"surface", "logmodulus"}) {
      SCOPED_TRACE(std::to_string(i) + " with " + grids);
      Recipe recipe = recipes[i];
      recipe["grids"] = grids;
      for (const TilePlanOptions& cut : {TilePlanOptions{.tiles = 3}, TilePlanOptions{.tileNodes = 13}}) {
        TilePlanOptions with = cut, without = cut;
        with.makes = {"vdb", "ply"};
        without.makes = {"ply"};
        const fs::path held = made(recipe, with), streamed = made(recipe, without);
        for (std::size_t tile = 1; tile <= mPlan.manifest.tasks.size(); ++tile) {
          const std::string name = "tiles/" + taskName(tile) + ".tile";
          EXPECT_TRUE(readWholeFile(held / name) == readWholeFile(streamed / name)) << name;
        }
      }
    }
}

// Promise: With `--make count`, "The numbers ..."
TEST_F(Tiles, WhatCannotBeCountedIsRefused) {
  const Recipe recipe = shape({{"resolution", "20"}});
  const auto plan = [&](const Recipe& given, const std::vector<std::string>& makes) {
    return planTiles(parseFractalOptions(given), given, {.tiles = 2, .makes = makes}, mFolder.path() / "refused",
                     mMonitor);
  };
  EXPECT_THROW(plan(recipe, {"count", "ply"}), std::invalid_argument);
  EXPECT_THROW(plan(shape({{"largest", "1"}}), {"count"}), std::invalid_argument);
  EXPECT_THROW(plan(shape({{"attributes", "trap"}}), {"count"}), std::invalid_argument);
  EXPECT_FALSE(fs::exists(mFolder.path() / "refused"));

  const fs::path counted = made(recipe, {.tiles = 2, .makes = {"count"}});
  const Manifest counts = readManifest(counted);
  EXPECT_THROW(mergePlan(counted, counts, {.mesh = inFolder("a.ply")}, mMonitor), std::invalid_argument);
  EXPECT_THROW(writeTileFiles(counted, counts, inFolder("a.json"), mMonitor), std::invalid_argument);
  const fs::path kept = made(recipe, {.tiles = 2, .makes = {"ply"}});
  EXPECT_THROW(mergeCounts(kept, readManifest(kept), inFolder("a.json"), mMonitor), std::invalid_argument);
  // A count that was changed is no longer its task's.
  mFolder.write("plan1/tiles/0002.json", encodeTileCount({.sha256 = std::string(64, '0')}));
  EXPECT_THROW(mergeCounts(counted, counts, inFolder("a.json"), mMonitor), DataError);
  EXPECT_FALSE(fs::exists(inFolder("a.json")));
}

// Promise: With `--make count`, "The numbers ..."
TEST(TileCount, TheSumsOfLargeTilesAreExact) {
  // More triangles than 32 bits count, in one tile and in the sum.
  constexpr std::uint64_t kMany = 5'000'000'001;
  const openvdb::BBoxd left(Vec3d(-1, 0, 0), Vec3d(0, 1, 1)), right(Vec3d(0, -2, 0), Vec3d(1, 1, 0.1));
  const TileCount some[] = {{kMany / 2, kMany, left, std::string(64, 'a')},
                            {kMany / 2, kMany, right, std::string(64, 'b')},
                            {0, 0, std::nullopt, std::string(64, 'c')}};
  for (const TileCount& count : some) {
    const TileCount again = parseTileCount(encodeTileCount(count));
    EXPECT_EQ(again.points, count.points);
    EXPECT_EQ(again.triangles, count.triangles);
    EXPECT_EQ(again.box, count.box);
    EXPECT_EQ(again.sha256, count.sha256);
  }
  const TileCount whole = addedUp(some);
  EXPECT_EQ(whole.triangles, 10'000'000'002u);
  EXPECT_EQ(whole.points, 5'000'000'000u);
  EXPECT_EQ(whole.box, openvdb::BBoxd(Vec3d(-1, -2, 0), Vec3d(1, 1, 1)));
  const TileCount swapped[] = {some[1], some[0], some[2]};
  EXPECT_NE(addedUp(swapped).sha256, whole.sha256);
  const TileCount tooMany[] = {{1, std::numeric_limits<std::uint64_t>::max(), left, std::string(64, 'a')}, some[0]};
  EXPECT_THROW(addedUp(tooMany), DataError);
}

// Promise: With `--make count`, "The numbers ..."
TEST(TileCount, ATextThatIsNoneIsRefused) {
  const std::string good = encodeTileCount({1, 2, openvdb::BBoxd(Vec3d(0), Vec3d(1)), std::string(64, 'a')});
  EXPECT_NO_THROW(parseTileCount(good));
  for (std::size_t size = 0; size + 1 < good.size(); ++size)
    EXPECT_THROW(parseTileCount(good.substr(0, size)), DataError);
  for (const auto& [from, to] : {std::pair("\"points\":1", "\"points\":-1"),
                                 {"\"points\":1", "\"points\":0"},
                                 {"\"triangles\":2", "\"triangles\":2.5"},
                                 {"aaaa\"", "AAAA\""},
                                 {"[0.0,", "["}}) {
    std::string bad = good;
    ASSERT_NE(bad.find(from), bad.npos) << from;
    bad.replace(bad.find(from), std::string(from).size(), to);
    EXPECT_THROW(parseTileCount(bad), DataError) << bad;
  }
}

TEST_F(Tiles, PlansThatCannotBeAreRefused) {
  const Recipe recipe = shape({});
  const auto plan = [&](const Recipe& given, const TilePlanOptions& cut) {
    return planTiles(parseFractalOptions(given), given, cut, mFolder.path() / "refused", mMonitor);
  };
  EXPECT_THROW(plan(recipe, {.makes = {"ply"}}), std::invalid_argument);
  EXPECT_THROW(plan(recipe, {.tiles = 3, .tileNodes = 8, .makes = {"ply"}}), std::invalid_argument);
  EXPECT_THROW(plan(recipe, {.tiles = 3}), std::invalid_argument);
  EXPECT_THROW(plan(recipe, {.tiles = 3, .makes = {"ply", "foo"}}), std::invalid_argument);
  EXPECT_THROW(plan(recipe, {.tiles = 0, .makes = {"ply"}}), std::invalid_argument);
  EXPECT_THROW(plan(shape({{"follow", "true"}}), {.tiles = 3, .makes = {"ply"}}), std::invalid_argument);
  EXPECT_THROW(plan(shape({{"attributes", "mask"}}), {.tiles = 3, .makes = {"ply"}}), std::invalid_argument);
  EXPECT_FALSE(fs::exists(mFolder.path() / "refused"));
}

std::vector<CoordBBox> randomWork(std::mt19937& random, const CoordBBox& domain, int count) {
  std::vector<CoordBBox> work;
  for (int i = 0; i < count; ++i) {
    Coord low, high;
    for (int axis = 0; axis < 3; ++axis) {
      const int side = domain.dim()[axis];
      low[axis] = domain.min()[axis] + static_cast<int>(random() % static_cast<unsigned>(side));
      high[axis] = std::min(domain.max()[axis], low[axis] + static_cast<int>(random() % 20));
    }
    work.emplace_back(low, high);
  }
  return work;
}

double volumeOf(const CoordBBox& box) { return box.empty() ? 0 : double(box.volume()); }

TEST(TileCuts, TilesDoNotOverlapAndHoldAllWork) {
  std::mt19937 random(11);
  const CoordBBox domain(Coord(-37, -100, 5), Coord(90, 61, 203));
  for (int round = 0; round < 30; ++round) {
    const std::vector<CoordBBox> work = randomWork(random, domain, 1 + static_cast<int>(random() % 60));
    const int count = 1 + static_cast<int>(random() % 64), side = 3 + static_cast<int>(random() % 60);
    const auto even = cutEvenly(domain, work, count);
    EXPECT_LE(even.size(), static_cast<std::size_t>(count));
    for (const auto& tiles : {even, cutIntoCubes(domain, work, side, 0)}) {
      double all = 0, held = 0;
      for (const CoordBBox& box : work) all += volumeOf(box);
      for (const TileBox& tile : tiles) {
        EXPECT_TRUE(domain.isInside(tile.nodes));
        double own = 0;
        for (CoordBBox box : work) {
          box.intersect(tile.nodes);
          own += volumeOf(box);
        }
        EXPECT_GT(own, 0);
        EXPECT_NEAR(tile.work, own, 1e-6 * all);
        held += own;
        for (const TileBox& other : tiles) EXPECT_EQ(other.nodes.hasOverlap(tile.nodes), &other == &tile);
      }
      EXPECT_NEAR(held, all, 1e-6 * all);
    }
  }
}

TEST(TileCuts, EvenTilesShareTheWork) {
  // As much as blocks allow: a plane of work, far thinner than the tiles.
  const CoordBBox domain(Coord(0), Coord(511));
  const std::vector<CoordBBox> work = {CoordBBox(Coord(0, 0, 200), Coord(511, 511, 203))};
  const auto tiles = cutEvenly(domain, work, 24);
  ASSERT_EQ(tiles.size(), 24U);
  for (const TileBox& tile : tiles) EXPECT_NEAR(tile.work, 512.0 * 512 * 4 / 24, 0.15 * 512 * 512 * 4 / 24);
}

}  // namespace
