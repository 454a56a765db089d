// SPDX-License-Identifier: Apache-2.0
// Plans of frames and of cells, and their tasks: the files are those of the jobs that are done one by one.
#include "farm/variant_task.h"
#include "farm/variant_plan.h"
#include "support/temporary_folder.h"
#include "support/test_meshes.h"

#include "vdbtools/farm/manifest.h"
#include "vdbtools/farm/plans.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/job/sheet_job.h"
#include "vdbtools/mesh_files/mesh_writer.h"

#include <gtest/gtest.h>

#include <set>
#include <sstream>
#include <stdexcept>

namespace {

using namespace vdbtools;
using namespace vdbtools::farm;
namespace fs = std::filesystem;

class Variants : public testing::Test {
 protected:
  Variants() { mBall = writeBall("ball.obj", 1); }

  std::string writeBall(const std::string& name, double radius) {
    return writeObj(name, test_meshes::makeSphere(radius, 2));
  }
  std::string writeObj(const std::string& name, const Mesh& mesh) {
    std::ostringstream stream;
    writeMesh(stream, mesh, {.format = &meshFormat(".obj")});
    return mFolder.write(name, stream.str()).string();
  }

  Recipe base(const std::string& input) const {
    return {{"input", input}, {"sdf-resolution", "16"}, {"resolution", "16"}, {"alpha", "40"}};
  }

  FramePlanOptions frames(const std::string& input, const std::vector<std::string>& keys, int first, int last) const {
    return {.base = base(input),
            .keys = parseKeys(keys, {}, fractalOptionTable()),
            .frames = parseFrames(std::to_string(first) + '-' + std::to_string(last))};
  }

  /// The manifest as a task reads it.
  Manifest written(const Manifest& manifest, const std::string& name = "plan") {
    writePlan(mFolder.path() / name, manifest);
    return readManifest(mFolder.path() / name);
  }
  std::string made(const std::string& file, const std::string& plan = "plan") const {
    return readWholeFile(mFolder.path() / plan / file);
  }

  /// Step by step, without any of the farm.
  std::pair<std::string, std::string> vdbAndPly(const Recipe& given) {
    const Recipe recipe = completeRecipe(given, fractalOptionTable());
    const Scene scene = makeScene(parseFractalOptions(recipe), mMonitor);
    const FractalPlan plan = planFractal(scene, {.grids = true, .mesh = true});
    const auto metadata = sceneMetadata(scene, recipe);
    Mesh mesh;
    MeshCollector sink(mesh);
    const FractalResult result = runFractal(scene, plan, &sink, mMonitor);
    std::ostringstream ply;
    MeshWriteOptions options = meshWriteOptions(meshFormat(".ply"), scene.options.output, metadata);
    options.voxelSize = scene.voxelSize;
    options.box = meshBox(plan.nodes);
    writeMesh(ply, mesh, options);
    return {encodeVdb(result.grids, vdbWriteOptions(scene.options.output, metadata)), ply.str()};
  }

  static TaskCounts makeVariant(const fs::path& folder, const Manifest& manifest, std::uint64_t index,
                                Monitor& monitor) {
    return VariantMaker(folder, manifest).make(index, monitor);
  }

  TemporaryFolder mFolder;
  Monitor mMonitor;
  std::string mBall;
};

/// Remembers the phases of the work.
class Phases final : public Monitor {
 public:
  void begin(const Phase& phase, std::uint64_t) override { names.insert(phase.text()); }
  std::set<std::string> names;
};

// Distances are made once for all frames of a mesh, and again where what was kept is broken.
// Promise: "What was made before changes ..."
TEST_F(Variants, FramesShareDistancesAndKeepTheirBytes) {
  FramePlanOptions options = frames(mBall, {"texture-translate@1=0,0,0", "texture-translate@4=0.2,0,0"}, 1, 4);
  const Manifest manifest = written(planFrames(options));
  const fs::path folder = mFolder.path() / "plan";
  for (std::uint64_t index = 1; index <= 4; ++index) {
    if (index == 4)
      for (const auto& entry : fs::directory_iterator(folder / "targets"))
        if (isVdbPath(entry.path())) mFolder.write("plan/targets/" + entry.path().filename().string(), "broken");
    Phases phases;
    makeVariant(folder, manifest, index, phases);
    EXPECT_EQ(phases.names.contains("distance field"), index == 1 || index == 4) << "frame " << index;
    EXPECT_EQ(this->made("out/ball.000" + std::to_string(index) + ".vdb"),
              vdbAndPly(taskRecipe(manifest, index)).first);
  }
}

// Each frame wants a band of another width. Whoever needs a wider one replaces the one that is there.
// Promise of design.md: "one band for all tasks of a mesh, made by the first task that needs it and removed with the
//   last one"
TEST_F(Variants, OneBandServesFramesOfAllWidths) {
  Mesh open = test_meshes::makeSphere(1, 2);
  open.triangles.resize(open.triangles.size() - 8);
  writeObj("open.obj", open);
  for (const char* mend : {"", "true"}) {
    const std::string name = *mend ? "open" : "ball";
    FramePlanOptions options =
        frames((mFolder.path() / (name + ".obj")).string(), {"detail@1=0.1", "detail@5=0.6"}, 1, 5);
    options.base.erase("alpha");
    if (*mend) options.base["repair"] = mend;
    const Manifest manifest = written(planFrames(options), name);
    const fs::path folder = mFolder.path() / name;
    for (const std::uint64_t index : {2, 5, 1, 4, 3}) {
      makeVariant(folder, manifest, index, mMonitor);
      const std::string vdb = made("out/" + name + ".000" + std::to_string(index) + ".vdb", name);
      EXPECT_TRUE(vdb == vdbAndPly(taskRecipe(manifest, index)).first) << "frame " << index;
      EXPECT_EQ(vdb.find("julia_repair_moved") != std::string::npos, *mend != 0);
      int bands = 0;
      for (const auto& entry : fs::directory_iterator(folder / "targets"))
        bands += entry.path().filename().string().find(".band.vdb") != std::string::npos;
      EXPECT_EQ(bands, 1);
    }
  }
}

// Voxels that are too small for OpenVDB's transforms are kept too.
TEST_F(Variants, FramesOfAVerySmallMeshShareDistances) {
  FramePlanOptions options = frames(writeBall("speck.obj", 1e-6), {"alpha@1=20", "alpha@2=60"}, 1, 2);
  options.makes = {"ply"};
  const Manifest manifest = written(planFrames(options));
  for (const std::uint64_t index : {1, 2}) {
    Phases phases;
    makeVariant(mFolder.path() / "plan", manifest, index, phases);
    EXPECT_EQ(phases.names.contains("distance field"), index == 1);
    EXPECT_TRUE(made("out/speck.000" + std::to_string(index) + ".ply") ==
                vdbAndPly(taskRecipe(manifest, index)).second);
  }
}

// Promise: "one band for all tasks of a mesh, made ..."
TEST_F(Variants, WhatNoTaskNeedsAnyMoreIsRemoved) {
  const Manifest manifest = written(planFrames(frames(mBall, {"alpha@1=20", "alpha@3=60"}, 1, 3)));
  const fs::path folder = mFolder.path() / "plan", targets = folder / "targets", aside = mFolder.path() / "aside";
  // Each in a runner of its own, as processes are.
  const auto run = [&](std::uint64_t index) { return TaskRunner(folder).run(index, mMonitor); };
  for (const std::uint64_t index : {3, 1}) {
    EXPECT_TRUE(run(index));
    EXPECT_TRUE(fs::exists(targets)) << "others will need it";
  }
  fs::copy(targets, aside);
  EXPECT_TRUE(run(2));
  EXPECT_FALSE(fs::exists(targets));
  // What a process left that was killed before it could remove it.
  fs::copy(aside, targets);
  EXPECT_FALSE(run(3)) << "it is done";
  EXPECT_FALSE(fs::exists(targets));
  // A task that is made again makes the distances again.
  const std::string before = made("out/ball.0002.vdb");
  mFolder.write("plan/out/ball.0002.vdb", "damaged");
  EXPECT_TRUE(run(2));
  EXPECT_TRUE(made("out/ball.0002.vdb") == before);
  EXPECT_TRUE(before == vdbAndPly(taskRecipe(manifest, 2)).first);
  EXPECT_FALSE(fs::exists(targets));
}

// Promise: "one band for all tasks of a mesh, made ..."
TEST_F(Variants, WhatNoOtherTaskNeedsIsNotKept) {
  for (const int frame : {1, 2, 3}) writeBall("b.000" + std::to_string(frame) + ".obj", frame == 3 ? 1 : frame);
  written(planFrames(frames((mFolder.path() / "b.####.obj").string(), {}, 1, 3)));
  const fs::path folder = mFolder.path() / "plan";
  TaskRunner runner(folder);
  runner.run(2, mMonitor);
  EXPECT_FALSE(fs::exists(folder / "targets"));
  runner.run(1, mMonitor);
  EXPECT_TRUE(fs::exists(folder / "targets")) << "frame 3 has the same shape in a file of another name";
  Phases phases;
  TaskRunner(folder).run(3, phases);
  EXPECT_FALSE(phases.names.contains("distance field"));
  EXPECT_FALSE(fs::exists(folder / "targets"));
}

// Tasks of one process share what the target gives.
TEST_F(Variants, OneProcessMakesTheExponentOnce) {
  written(planFrames(frames(mBall, {"texture-translate@1=0,0,0", "texture-translate@3=0.2,0,0"}, 1, 3)));
  TaskRunner runner(mFolder.path() / "plan");
  for (const std::uint64_t index : {1, 2, 3}) {
    Phases phases;
    runner.run(index, phases);
    EXPECT_EQ(phases.names.contains("exponent"), index == 1);
    EXPECT_TRUE(made("out/ball.000" + std::to_string(index) + ".vdb") ==
                vdbAndPly(taskRecipe(runner.manifest(), index)).first);
  }
}

// Promise: A sequence has "the same ..."
TEST_F(Variants, AFrameIsTheFractalWithItsValues) {
  FramePlanOptions options =
      frames(mBall, {"alpha@1=20", "alpha@3=60", "origin-shift@2=0,0,0", "origin-shift@3=0.1,0,0"}, 1, 3);
  options.makes = {"vdb", "ply"};
  const Manifest manifest = written(planFrames(options));
  ASSERT_EQ(manifest.tasks.size(), 3U);
  EXPECT_EQ(manifest.kind, PlanKind::Frames);
  EXPECT_EQ(manifest.tasks[1].writes, (std::vector<std::string>{"out/ball.0002.vdb", "out/ball.0002.ply"}));
  const TaskCounts counts = makeVariant(mFolder.path() / "plan", manifest, 2, mMonitor);
  Recipe typed = base(mBall);
  typed["alpha"] = "40";
  typed["origin-shift"] = "0,0,0";
  auto [vdb, ply] = vdbAndPly(typed);
  EXPECT_TRUE(made("out/ball.0002.vdb") == vdb);
  EXPECT_TRUE(made("out/ball.0002.ply") == ply);
  EXPECT_GT(counts.counts.at("triangles"), 0u);
  EXPECT_GT(counts.counts.at("evaluatedNodes"), 0u);
  makeVariant(mFolder.path() / "plan", manifest, 3, mMonitor);
  typed["alpha"] = "60";
  typed["origin-shift"] = "0.1,0,0";
  std::tie(vdb, ply) = vdbAndPly(typed);
  EXPECT_TRUE(made("out/ball.0003.vdb") == vdb);
  EXPECT_TRUE(made("out/ball.0003.ply") == ply);
  EXPECT_NE(made("out/ball.0003.vdb"), made("out/ball.0002.vdb"));
}

TEST_F(Variants, TasksHaveCompleteRecipesWithHashes) {
  writeBall("b.0001.obj", 1);
  writeBall("b.0002.obj", 2);
  writeBall("b.0003.obj", 1);
  const std::string pattern = (mFolder.path() / "b.####.obj").string();
  // A varied map has other options in each frame, and files with one content have one hash.
  for (const auto& [options, input] : {std::pair(frames(pattern, {}, 1, 3), ""),
                                       {frames(mBall, {"texture-seed@1=1", "texture-seed@3=3"}, 1, 3), ""}}) {
    const Manifest manifest = planFrames(options);
    ASSERT_EQ(manifest.tasks.size(), 3U);
    for (int frame = 1; frame <= 3; ++frame) {
      Recipe recipe = options.base;
      for (const KeyedOption& option : options.keys) recipe[option.name] = valueAt(option, frame);
      if (recipe.at("input") == pattern)
        recipe["input"] = (mFolder.path() / ("b.000" + std::to_string(frame) + ".obj")).string();
      recipe["source-sha256"] = sha256OfFile(recipe.at("input"));
      EXPECT_EQ(taskRecipe(manifest, static_cast<std::uint64_t>(frame)), completeRecipe(recipe, fractalOptionTable()));
    }
    EXPECT_EQ(manifest.recipe.at("alpha"), "40") << "what tasks share stands in the plan once";
  }
}

TEST_F(Variants, AKeyDisplacesTheAlternativeOfItsOption) {
  FramePlanOptions options = frames(mBall, {"detail@1=0.2", "detail@2=0.4"}, 1, 2);
  const Manifest manifest = planFrames(options);
  EXPECT_FALSE(taskRecipe(manifest, 1).contains("alpha"));
  EXPECT_EQ(taskRecipe(manifest, 2).at("detail"), "0.4");
}

TEST_F(Variants, RelativeNamesAreMeantFromThePlannersFolder) {
  const fs::path before = fs::current_path();
  fs::current_path(mFolder.path());
  const Manifest manifest = written(planFrames(frames("ball.obj", {"alpha@1=20", "alpha@2=60"}, 2, 2)));
  Recipe typed = base("ball.obj");
  typed["alpha"] = "60";
  const std::string vdb = vdbAndPly(typed).first;
  fs::current_path("/");
  makeVariant(mFolder.path() / "plan", manifest, 1, mMonitor);
  fs::current_path(before);
  EXPECT_TRUE(made("out/ball.0002.vdb") == vdb) << "the recipe in the file is the one that was typed";
}

TEST_F(Variants, NamesOfFilesBecomeAbsoluteWhereverTheyStand) {
  const auto absolute = [](const std::string& option, const std::string& value) {
    return withAbsoluteNames({{"input", "/b.obj"}, {option, value}}, "/f").at(option);
  };
  EXPECT_EQ(absolute("texture", "roots.json"), "/f/roots.json");
  EXPECT_EQ(absolute("texture", "/roots.json"), "/roots.json");
  EXPECT_EQ(absolute("texture", "random"), "random");
  EXPECT_EQ(absolute("alpha", "a/b.vdb:density"), "/f/a/b.vdb:density");
  EXPECT_EQ(absolute("alpha", "texture:t.png:10:30"), "texture:/f/t.png:10:30");
  EXPECT_EQ(absolute("alpha", "40"), "40");
  EXPECT_EQ(withAbsoluteNames({{"input", "b.obj"}}, "/f").at("input"), "/f/b.obj");
  EXPECT_EQ(withAbsoluteNames({{"input", "b:c.obj"}}, "/f").at("input"), "/f/b:c.obj");
}

TEST_F(Variants, AChangedInputIsRefused) {
  const Manifest manifest = written(planFrames(frames(mBall, {"alpha@1=20", "alpha@2=60"}, 1, 2)));
  writeBall("ball.obj", 1.5);
  EXPECT_THROW(makeVariant(mFolder.path() / "plan", manifest, 1, mMonitor), DataError);
  EXPECT_FALSE(fs::exists(mFolder.path() / "plan/out/ball.0001.vdb"));
}

// Promise: If nothing changes, "the program ..."
TEST_F(Variants, FramesOfWhatDoesNotChangeAreTheSame) {
  const Manifest manifest = written(planFrames(frames(mBall, {}, -1, 1)));
  for (const std::uint64_t task : {1, 2, 3}) makeVariant(mFolder.path() / "plan", manifest, task, mMonitor);
  const std::string first = made("out/ball.-0001.vdb");
  EXPECT_FALSE(first.empty());
  EXPECT_EQ(made("out/ball.0000.vdb"), first);
  EXPECT_EQ(made("out/ball.0001.vdb"), first);
}

TEST_F(Variants, FramesAreRefusedAtPlanning) {
  const auto refused = [&](const FramePlanOptions& options, const std::string& mention) {
    try {
      planFrames(options);
      ADD_FAILURE() << "not refused: " << mention;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(mention), std::string::npos) << error.what();
    }
  };
  refused(frames("", {"alpha@1=20"}, 1, 3), "frame 1: there is no target, which the map needs");
  refused(frames(mBall, {"texture-seed@1=1", "texture-seed@3=2"}, 1, 3), "frame 2: --texture-seed is '1.5'");
  refused(frames(mBall, {"resolution@1=10", "resolution@3=-10"}, 1, 3), "frame 2: --resolution");
  refused(frames(mBall, {"alpha@1=forty"}, 1, 3), "frame 1: --alpha is 'forty'");
  refused(frames(mBall, {"power@1=8"}, 1, 3), "frame 1: --power");
  FramePlanOptions options = frames(mBall, {"alpha@1=20"}, 1, 3);
  for (const std::vector<std::string>& makes : {std::vector<std::string>{}, {""}, {"png"}, {"vdb", "vdb"}}) {
    options.makes = makes;
    refused(options, "--make");
  }
  options.makes = {"vdb"};
  for (const char* name : {"a/b", "a.####", "a.%d"}) {
    options.name = name;
    refused(options, "--name");
  }
  writeBall("b.0001.obj", 1);
  EXPECT_THROW(planFrames(frames((mFolder.path() / "b.####.obj").string(), {}, 1, 2)), MissingInputError);
  EXPECT_NO_THROW(planFrames(frames((mFolder.path() / "b.####.obj").string(), {}, 1, 1)));
}

// Promise: Cells of a sheet as tasks ...
TEST_F(Variants, CellsAreWhatTheirRecipesMake) {
  const auto vary = [](const std::string& text) { return parseVaried(text, fractalOptionTable(), kMostSheetCells); };
  Sheet sheet = planSheet({.varied = {vary("alpha=20,x,40,60")},
                           .base = {{"input", mBall}, {"sdf-resolution", "16"}, {"resolution", "16"}}});
  ASSERT_NE(sheet.cells[1].error, "");
  const std::string file = mFolder.write("seeds.json", encodeSheet(sheet)).string();
  const auto numbers = [](const Manifest& manifest) {
    std::vector<std::string> names;
    for (const PlannedTask& task : manifest.tasks) names.push_back(task.writes.at(0));
    return names;
  };
  EXPECT_EQ(numbers(planSheetCells({.cells = file})),
            (std::vector<std::string>{"out/seeds.0001.vdb", "out/seeds.0003.vdb", "out/seeds.0004.vdb"}));
  EXPECT_EQ(numbers(planSheetCells({.cells = file + "#4,1", .name = "n", .makes = {"stl"}})),
            (std::vector<std::string>{"out/n.0001.stl", "out/n.0004.stl"}));
  const Manifest manifest = written(planSheetCells({.cells = file + "#3-4", .given = {{"resolution", "20"}}}));
  EXPECT_EQ(manifest.kind, PlanKind::Sheet);
  makeVariant(mFolder.path() / "plan", manifest, 1, mMonitor);
  Recipe typed = base(mBall);
  typed["resolution"] = "20";
  EXPECT_TRUE(made("out/seeds.0003.vdb") ==
              vdbAndPly(overridden(sheet.cells[2].recipe, {{"resolution", "20"}}, fractalOptionTable())).first);
  EXPECT_TRUE(made("out/seeds.0003.vdb") == vdbAndPly(typed).first) << "the cell's recipe has no trace of the sheet";
  for (const char* bad : {"#", "#0", "#5", "#1,", "#1-5", "#3-2", "#1,1", "#1-3,2", "#x", "#2"})
    EXPECT_THROW(planSheetCells({.cells = file + bad}), std::invalid_argument) << bad;
  for (SheetCell& cell : sheet.cells) cell.error = "none";
  mFolder.write("none.json", encodeSheet(sheet));
  EXPECT_THROW(planSheetCells({.cells = (mFolder.path() / "none.json").string()}), DataError);
}

TEST_F(Variants, APlanNeedsAFolderOfItsOwn) {
  const Manifest manifest = planFrames(frames(mBall, {"alpha@1=20"}, 1, 2));
  EXPECT_NO_THROW(requireNewPlanFolder(mFolder.path() / "new"));
  EXPECT_NO_THROW(requireNewPlanFolder(mFolder.path() / "new/below"));
  EXPECT_THROW(requireNewPlanFolder(""), CreateError);
  EXPECT_THROW(requireNewPlanFolder(mFolder.path()), CreateError) << "it is not empty";
  EXPECT_THROW(requireNewPlanFolder(mBall), CreateError) << "it is a file";
  EXPECT_THROW(writePlan(mBall, manifest), CreateError);
  EXPECT_THROW(writePlan(mBall + "/below", manifest), CreateError);
  written(manifest, "new");
  EXPECT_THROW(requireNewPlanFolder(mFolder.path() / "new"), CreateError);
  EXPECT_EQ(std::distance(fs::directory_iterator(mFolder.path() / "new"), fs::directory_iterator()), 1);
}

}  // namespace
