// SPDX-License-Identifier: Apache-2.0
// Islands over tiles: however a lattice is cut, the same islands are found, and what is merged has the bytes of one
// run.
#include "farm/tile_islands.h"
#include "support/temporary_folder.h"
#include "support/test_fields.h"
#include "support/test_meshes.h"

#include "mesh_files/mesh_file.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/farm/manifest.h"
#include "vdbtools/farm/merge.h"
#include "vdbtools/farm/plans.h"
#include "vdbtools/farm/task.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/mesh_files/mesh_writer.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <random>
#include <sstream>

namespace {

using namespace vdbtools;
using namespace vdbtools::farm;
namespace fs = std::filesystem;
using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::Vec3d;
using test_meshes::makeBox;
using test_meshes::makeSphere;
using test_meshes::merged;

class TilesOfIslands : public testing::Test {
 protected:
  /// Two balls joined by a thin rod along z, a ball and a rod by themselves, and crumbs.
  TilesOfIslands() {
    Mesh mesh = merged(makeSphere(0.4, 3, Vec3d(0.1, 0.2, -1)), makeSphere(0.3, 3, Vec3d(0.13, 0.16, 0.9)));
    mesh = merged(mesh, makeBox(Vec3d(0.05, 0.1, -0.8), Vec3d(0.21, 0.26, 0.8)));
    mesh = merged(mesh, makeSphere(0.45, 3, Vec3d(1.2, -0.1, 0.1)));
    mesh = merged(mesh, makeBox(Vec3d(-0.5, -0.7, -0.9), Vec3d(1.6, -0.52, -0.7)));
    for (int i = 0; i < 5; ++i)
      mesh = merged(mesh, makeSphere(0.07 + 0.015 * i, 2, Vec3d(-0.5 + 0.1 * i, 0.1 + 0.02 * i, -0.8 + 0.42 * i)));
    mShape = written("shape.obj", mesh);
  }

  std::string written(const std::string& name, const Mesh& mesh) {
    std::ostringstream stream;
    writeMesh(stream, mesh, {.format = &meshFormat(".obj")});
    return mFolder.write(name, stream.str()).string();
  }

  Recipe shape(const Recipe& others) const {
    Recipe recipe = {
        {"input", mShape}, {"sdf-resolution", "50"}, {"resolution", "44"}, {"alpha", "60"}, {"crumbs", "keep"}};
    for (const auto& [name, value] : others) recipe[name] = value;
    return completeRecipe(recipe, fractalOptionTable());
  }

  /// Plans, makes every task, and gives the folder.
  fs::path made(const Recipe& recipe, const TilePlanOptions& cut) {
    const fs::path folder = mFolder.path() / ("plan" + std::to_string(++mPlans));
    mPlan = planTiles(parseFractalOptions(recipe), recipe, cut, folder, mMonitor);
    writePlan(folder, mPlan.manifest);
    TaskRunner runner(folder);
    for (std::uint64_t index = mPlan.manifest.tasks.size(); index >= 1; --index) runner.run(index, mMonitor);
    return folder;
  }

  std::string inFolder(const std::string& name) const { return (mFolder.path() / name).string(); }

  FractalResult makeOneRun(const Recipe& recipe) {
    AtomicFile vdb(inFolder("one.vdb")), mesh(inFolder("one.ply"));
    const Scene scene = makeScene(parseFractalOptions(recipe), mMonitor);
    FractalResult result =
        writeFractal(scene, recipe, {.files = {{&vdb, findFormat(".vdb")}, {&mesh, findFormat(".ply")}}}, mMonitor);
    vdb.commit();
    mesh.commit();
    return result;
  }

  void expectSame(const char* extension) {
    EXPECT_TRUE(readWholeFile(inFolder(std::string("all") + extension)) ==
                readWholeFile(inFolder(std::string("one") + extension)))
        << extension;
  }

  /// @return what one run says of its islands
  IslandReport expectOneRun(const Recipe& recipe, const std::vector<TilePlanOptions>& cuts) {
    const IslandReport one = makeOneRun(recipe).islands.value();
    EXPECT_LT(one.keptIslands, one.islands) << "nothing was dropped";
    for (TilePlanOptions cut : cuts) {
      SCOPED_TRACE(cut.tiles ? "tiles " + std::to_string(*cut.tiles) : "nodes " + std::to_string(*cut.tileNodes));
      cut.makes = {"vdb", "ply"};
      const fs::path folder = made(recipe, cut);
      const MergeResult result = mergePlan(folder, readManifest(folder),
                                           {.grids = inFolder("all.vdb"), .mesh = inFolder("all.ply")}, mMonitor);
      EXPECT_EQ(result.islands->islands, one.islands);
      EXPECT_EQ(result.islands->keptIslands, one.keptIslands);
      EXPECT_EQ(result.islands->droppedNodes, one.droppedNodes);
      expectSame(".vdb");
      expectSame(".ply");
    }
    return one;
  }

  TemporaryFolder mFolder;
  Monitor mMonitor;
  std::string mShape;
  TilePlan mPlan;
  int mPlans = 0;
};

// Promise of farm.md: With `--largest` or `--min-size` `merge` "drops the islands that one run would drop"
TEST_F(TilesOfIslands, TheLargestAreThoseOfOneRun) {
  // Cuts between blocks of 8 nodes, and through them; the island of two balls reaches over four tiles and more.
  EXPECT_GE(expectOneRun(shape({{"largest", "1"}}), {{.tiles = 2}, {.tileNodes = 11}}).islands, 8U);
  expectOneRun(shape({{"largest", "3"}}), {{.tiles = 19}, {.tileNodes = 16}});
}

// Promise: With `--largest` or `--min-size` ...
TEST_F(TilesOfIslands, TheSmallOnesAreThoseOfOneRun) {
  EXPECT_GT(expectOneRun(shape({{"min-size", "0.25"}}), {{.tiles = 7}, {.tileNodes = 13}}).keptIslands, 1U);
  expectOneRun(shape({{"min-size", "0.2"}, {"largest", "4"}}), {{.tileNodes = 17}});
}

// Promise: With `--largest` or `--min-size` ...
TEST_F(TilesOfIslands, RandomCutsOfManySpecksAreThoseOfOneRun) {
  std::mt19937 random(20261122);
  if (!test_meshes::hasBunny()) GTEST_SKIP() << "needs glmark2-data";
  mShape = test_meshes::bunnyPath();
  const Recipe recipe = shape({{"alpha", "20"}, {"beta", "-0.01"}, {"origin", "centre"}, {"largest", "6"}});
  std::vector<TilePlanOptions> cuts;
  for (int i = 0; i < 2; ++i) cuts.push_back({.tiles = 2 + static_cast<int>(random() % 63)});
  for (int i = 0; i < 2; ++i) cuts.push_back({.tileNodes = 16 + static_cast<int>(random() % 30)});
  EXPECT_GT(expectOneRun(recipe, cuts).islands, 20U);
}

TEST_F(TilesOfIslands, ABoxIsThatOfOneRunWithItsCapsOrWithout) {
  Recipe box = {{"box", "-0.3,-0.9,-0.85,1.3,0.3,0.7"}, {"largest", "2"}};
  expectOneRun(shape(box), {{.tiles = 5}, {.tileNodes = 14}});
  box["cap"] = "true";
  expectOneRun(shape(box), {{.tiles = 5}, {.tileNodes = 14}});
}

TEST_F(TilesOfIslands, EveryGridIsThatOfOneRun) {
  Recipe grids = {{"grids", "iterations,versor,surface,density,logmodulus"}, {"largest", "2"}};
  expectOneRun(shape(grids), {{.tileNodes = 19}});
  grids["box"] = "-0.3,-0.9,-0.85,1.3,0.3,0.7";
  expectOneRun(shape(grids), {{.tileNodes = 19}});
  grids["grids"] = "logmodulus";
  expectOneRun(shape(grids), {{.tiles = 3}});
}

// Islands are joined through tiles in which there is nothing to do, and these belong to their size.
TEST_F(TilesOfIslands, TilesWithinASolidCount) {
  // The ball is dropped, for the rod is longer.
  mShape =
      written("ball_and_rod.obj", merged(makeSphere(1, 4), makeBox(Vec3d(-1.2, 1.15, -0.2), Vec3d(1.8, 1.5, 0.2))));
  const Recipe recipe = shape({{"min-size", "2.6"}, {"alpha", "200"}, {"sdf-resolution", "60"}, {"resolution", "100"}});
  const FractalOptions options = parseFractalOptions(recipe);
  const TilePlan plan =
      planTiles(options, recipe, {.tileNodes = 9, .makes = {"ply"}}, mFolder.path() / "plan", mMonitor);
  const Scene scene = makeScene(options, mMonitor);
  FractalField one = evaluateField(planScene(scene), scene.source(), {}, mMonitor);
  const IslandReport report = dropIslands(one, options.surface.islands, mMonitor);
  EXPECT_EQ(report.keptIslands, 1U);
  EXPECT_GT(report.droppedNodes, 100000U);

  std::vector<TileIslandsReader> tiles;
  std::size_t within = 0;
  for (const PlannedTask& task : plan.manifest.tasks) {
    CoordBBox window = task.box.value();
    window.expand(5);
    const FractalField field = evaluateField(planScene(scene, window), scene.source(), {}, mMonitor);
    const TileIslands islands(field, scene.source(), *task.box, mMonitor);
    std::ostringstream stream;
    islands.write(stream);
    tiles.emplace_back(mFolder.write("a.islands", stream.str()));
    if (field.field->tree().leafCount() == 0 && !islands.parts().empty()) ++within;
  }
  EXPECT_GT(within, 0U) << "no tile lies within the solid, so nothing was tested";
  const JoinedIslands joined = joinIslands(tiles, options.surface.islands, scene.voxelSize, mMonitor);
  EXPECT_EQ(joined.report.islands, report.islands);
  EXPECT_EQ(joined.report.keptIslands, report.keptIslands);
  EXPECT_EQ(joined.report.droppedNodes, report.droppedNodes);
}

TEST_F(TilesOfIslands, AMeshAloneIsThatOfOneRun) {
  Recipe recipe = shape({{"largest", "2"}, {"box", "-0.3,-0.9,-0.85,1.3,0.3,0.7"}});
  const FractalResult one = makeOneRun(recipe);
  const fs::path folder = made(recipe, {.tileNodes = 17, .makes = {"ply"}});
  // What is dropped does not count: the mesh stays in one file.
  const MergeOptions whole{.mesh = inFolder("all.ply"), .mostPoints = one.mesh.points};
  EXPECT_EQ(mergePlan(folder, readManifest(folder), whole, mMonitor).mesh.points, one.mesh.points);
  expectSame(".ply");
  // The pieces add up.
  const MergeResult pieces = writeTileFiles(folder, readManifest(folder), inFolder("pieces.json"), mMonitor);
  EXPECT_EQ(pieces.mesh.triangles, one.mesh.triangles);
  const auto index = nlohmann::json::parse(readWholeFile(inFolder("pieces.json")));
  std::uint64_t triangles = 0;
  for (const auto& tile : index.at("tiles")) {
    const auto count = tile.at("triangles").get<std::uint64_t>();
    EXPECT_EQ(tile.at("files").size(), count > 0 ? 1U : 0U);
    triangles += count;
  }
  EXPECT_EQ(triangles, one.mesh.triangles);
}

TEST_F(TilesOfIslands, WhereNothingIsLeftTheErrorIsThatOfOneRun) {
  const Recipe recipe = shape({{"min-size", "50"}});
  const auto textOf = [](const auto& work) {
    try {
      work();
    } catch (const DataError& error) {
      EXPECT_EQ(error.remedy(), Remedy::SmallerIslands);
      return std::string(error.what());
    }
    return std::string("nothing was thrown");
  };
  const std::string one = textOf([&] { makeOneRun(recipe); });
  EXPECT_NE(one.find("no island is left"), std::string::npos) << one;
  const fs::path folder = made(recipe, {.tiles = 4, .makes = {"vdb", "ply"}});
  EXPECT_EQ(textOf([&] { mergePlan(folder, readManifest(folder), {.mesh = inFolder("all.ply")}, mMonitor); }), one);
  EXPECT_EQ(textOf([&] { mergePlan(folder, readManifest(folder), {.grids = inFolder("all.vdb")}, mMonitor); }), one);
  EXPECT_FALSE(fs::exists(inFolder("all.ply")));
  EXPECT_THROW(writeTileFiles(folder, readManifest(folder), inFolder("pieces.json"), mMonitor), std::invalid_argument);
}

/// Noise in a box, and the islands of it as one field has them.
class NoiseTiles : public testing::Test {
 protected:
  NoiseTiles() {
    const openvdb::BBoxd box(mDomain.min().asVec3d(), mDomain.max().asVec3d());
    mField = fractalFieldEverywhere({mNoise, {}}, {.voxelSize = 1, .box = box}, mMonitor);
  }

  /// The boxes of a domain that is cut at random, whose sides are three nodes or more.
  std::vector<CoordBBox> randomBoxes(unsigned seed, int cuts) const {
    std::mt19937 random(seed);
    std::vector<CoordBBox> boxes = {mDomain};
    for (int i = 0; i < cuts; ++i) {
      const std::size_t which = random() % boxes.size();
      const int axis = static_cast<int>(random() % 3), side = boxes[which].dim()[axis];
      if (side < 6) continue;
      CoordBBox low = boxes[which], high = low;
      const int at = low.min()[axis] + 3 + static_cast<int>(random() % static_cast<unsigned>(side - 5));
      low.max()[axis] = at - 1;
      high.min()[axis] = at;
      boxes[which] = low;
      boxes.push_back(high);
    }
    return boxes;
  }

  struct Tiles {
    std::vector<TileIslands> made;
    std::vector<TileIslandsReader> read;
  };
  Tiles tilesOf(const std::vector<CoordBBox>& boxes) {
    Tiles tiles;
    for (const CoordBBox& box : boxes) {
      tiles.made.emplace_back(mField, FieldSource{mNoise, {}}, box, mMonitor);
      std::ostringstream stream;
      tiles.made.back().write(stream);
      tiles.read.emplace_back(mFolder.write(std::to_string(tiles.read.size()) + ".islands", stream.str()));
    }
    return tiles;
  }

  CoordBBox mDomain{Coord(-13, 2, -9), Coord(17, 31, 22)};
  test_fields::NodeEvaluator mNoise{[](const Coord& node) { return test_fields::noise(node, 5) + 1 - 2 * 0.29; }};
  Monitor mMonitor;
  TemporaryFolder mFolder;
  FractalField mField;
};

TEST_F(NoiseTiles, EveryNodeIsKeptOrDroppedAsInOneField) {
  for (const IslandOptions& options :
       {IslandOptions{.largest = 1}, {.largest = 40}, {.largest = 30, .minSize = 3}, {.minSize = 5}}) {
    FractalField one = mField;
    one.field = mField.field->deepCopy();
    const IslandReport report = dropIslands(one, options, mMonitor);
    ASSERT_GT(report.islands, 100U);
    for (const unsigned seed : {1u, 2u, 3u}) {
      const std::vector<CoordBBox> boxes = randomBoxes(seed, seed == 1 ? 3 : 60);
      const Tiles tiles = tilesOf(boxes);
      const JoinedIslands joined = joinIslands(tiles.read, options, 1, mMonitor);
      EXPECT_EQ(joined.report.islands, report.islands);
      EXPECT_EQ(joined.report.keptIslands, report.keptIslands);
      EXPECT_EQ(joined.report.droppedNodes, report.droppedNodes);
      for (std::size_t i = 0; i < boxes.size(); ++i) {
        std::uint64_t own = 0;
        for (auto node = boxes[i].begin(); node; ++node) {
          const std::optional<std::uint32_t> part = tiles.made[i].partOf(*node);
          ASSERT_EQ(part.has_value(), mField.field->tree().getValue(*node) < 0) << *node;
          if (!part) continue;
          ++own;
          ASSERT_EQ(joined.keptParts[i][*part], one.field->tree().getValue(*node) < 0) << *node;
        }
        tiles.read[i].forEachOwn([&](std::span<const InsideRun> runs) {
          for (const InsideRun& run : runs)
            for (int z = run.first; z <= run.last; ++z, --own)
              ASSERT_EQ(tiles.made[i].partOf({run.x, run.y, z}), run.part);
        });
        EXPECT_EQ(own, 0U) << "runs that are read are not those that were written";
      }
    }
  }
}

TEST_F(NoiseTiles, TilesThatDoNotFitAreRefused) {
  const Tiles tiles = tilesOf(randomBoxes(4, 9));
  EXPECT_NO_THROW(joinIslands(tiles.read, {.largest = 1}, 1, mMonitor));
  // Without the last one, some other tile has neighbours that nobody owns.
  EXPECT_THROW(joinIslands(std::span(tiles.read).first(tiles.read.size() - 1), {.largest = 1}, 1, mMonitor), DataError);
}

TEST_F(NoiseTiles, BrokenFilesAreRefused) {
  tilesOf({mDomain});
  const std::string bytes = readWholeFile(mFolder.path() / "0.islands");
  const auto read = [&](const std::string& content) {
    const TileIslandsReader reader(mFolder.write("broken.islands", content));
    reader.forEachOwn([](std::span<const InsideRun>) {});
  };
  EXPECT_NO_THROW(read(bytes));
  for (std::size_t size = 0; size < bytes.size(); size += 1 + bytes.size() / 97)
    EXPECT_THROW(read(bytes.substr(0, size)), DataError) << size;
  std::string magic = bytes;
  magic[2] = '?';
  EXPECT_THROW(read(magic), DataError);
  // Counts that no memory holds, and a part that is not there.
  for (const std::size_t at : {std::size_t(16), std::size_t(24), std::size_t(32), std::size_t(40), bytes.size() - 4}) {
    std::string huge = bytes;
    for (std::size_t i = at; i < at + 4; ++i) huge[i] = '\xff';
    EXPECT_THROW(read(huge), DataError) << at;
  }
  EXPECT_THROW(TileIslandsReader(mFolder.path() / "none.islands"), MissingInputError);
}

}  // namespace
