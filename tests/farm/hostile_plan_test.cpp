// SPDX-License-Identifier: Apache-2.0
// Plans that somebody has changed, with the hashes that belong to the changes: they are refused as bad data, or work.
#include "support/temporary_folder.h"
#include "support/test_meshes.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/farm/manifest.h"
#include "vdbtools/farm/merge.h"
#include "vdbtools/farm/plans.h"
#include "vdbtools/farm/task.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/sheet_job.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/scene/fractal_options.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <functional>
#include <sstream>

namespace {

using namespace vdbtools;
using namespace vdbtools::farm;
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// What a file that nobody vouches for may have in the place of any value; the first stands for nothing at all.
const std::vector<Json> kOthers = {Json(Json::value_t::discarded),
                                   nullptr,
                                   -1,
                                   0,
                                   3'000'000'000,
                                   1e308,
                                   "",
                                   "-1",
                                   "../x",
                                   Json::array(),
                                   Json::object(),
                                   Json::parse("[[1,2,3],[0,0,0]]")};

/// @return false if there is nothing to change
bool change(Json& json, const Json::json_pointer& at, const Json& to) {
  if (!to.is_discarded()) {
    if (json[at] == to) return false;
    json[at] = to;
    return true;
  }
  Json& holder = json[at.parent_pointer()];
  if (holder.is_array())
    holder.erase(static_cast<std::size_t>(std::stoul(at.back())));
  else
    holder.erase(at.back());
  return true;
}

/// Of every value in it, those that hold others, too.
std::vector<Json::json_pointer> pointersOf(const Json& json, const Json::json_pointer& root = Json::json_pointer()) {
  std::vector<Json::json_pointer> all;
  if (!json.is_structured()) return all;
  for (const auto& [name, value] : json.items()) {
    const Json::json_pointer at = json.is_array() ? root / static_cast<std::size_t>(std::stoul(name)) : root / name;
    all.push_back(at);
    for (const Json::json_pointer& inner : pointersOf(value, at)) all.push_back(inner);
  }
  return all;
}

class HostilePlan : public testing::Test {
 protected:
  HostilePlan() {
    std::ostringstream stream;
    writeMesh(stream, test_meshes::makeSphere(1, 2), {.format = &meshFormat(".obj")});
    mBase = {{"input", mFolder.write("ball.obj", stream.str()).string()},
             {"sdf-resolution", "10"},
             {"resolution", "8"},
             {"alpha", "40"}};
  }

  fs::path tiles(const Recipe& more, const std::vector<std::string>& makes = {"vdb", "ply"}) {
    Recipe recipe = mBase;
    for (const auto& [name, value] : more) recipe[name] = value;
    recipe = completeRecipe(recipe, fractalOptionTable());
    const fs::path folder = mFolder.path() / "tiles";
    TilePlan plan = planTiles(parseFractalOptions(recipe), recipe, {.tiles = 2, .makes = makes}, folder, mMonitor);
    writePlan(folder, plan.manifest);
    return folder;
  }

  void putManifest(const fs::path& folder, Json json) const {
    json.erase("hash");
    json["hash"] = sha256Hex(json.dump());
    writeText(folder / kManifestName, json.dump());
  }

  static void writeText(const fs::path& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
  }

  /// All that the commands status, submit, task and merge do with a plan.
  void use(const fs::path& folder) {
    for (const char* made : {"tasks", "tiles", "out", "targets"}) fs::remove_all(folder / made);
    const Manifest manifest = readManifest(folder);
    for (std::uint64_t index = 1; index <= manifest.tasks.size(); ++index)
      taskStatus(folder, manifest, index, FileCheck::Quick);
    const MergeOptions merged{.grids = mFolder.path() / "m.vdb", .mesh = mFolder.path() / "m.ply"};
    const bool isMerged = manifest.kind == PlanKind::Tiles;
    if (isMerged && makes(manifest, "vdb") && makes(manifest, "ply")) requireMergeable(folder, manifest, merged);
    TaskRunner runner(folder);
    for (std::uint64_t index = 1; index <= manifest.tasks.size(); ++index) runner.run(index, mMonitor);
    if (isMerged && makes(manifest, "vdb") && makes(manifest, "ply")) mergePlan(folder, manifest, merged, mMonitor);
    if (isMerged && makes(manifest, "count")) mergeCounts(folder, manifest, mFolder.path() / "m.json", mMonitor);
  }

  /// @return whether it was refused
  bool isRefused(const fs::path& folder, const std::string& what) {
    try {
      use(folder);
      return false;
    } catch (const DataError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << what;
    } catch (const MissingInputError&) {
      // An input of another name.
    } catch (const std::exception& error) {
      ADD_FAILURE() << what << " ends in: " << error.what();
    }
    return true;
  }

  /// Changes each value in turn.
  void expectRefusals(const Json& whole, const std::function<void(const Json&)>& put, const fs::path& folder) {
    put(whole);
    ASSERT_NO_THROW(use(folder)) << "what was not changed works";
    int refused = 0, cases = 0;
    for (const Json::json_pointer& at : pointersOf(whole))
      for (const Json& other : kOthers) {
        Json changed = whole;
        if (!change(changed, at, other)) continue;
        put(changed);
        ++cases;
        refused += isRefused(folder, at.to_string() + " as " + (other.is_discarded() ? "nothing" : other.dump()));
      }
    EXPECT_GT(refused, cases / 2);
  }

  void expectRefusals(const fs::path& folder) {
    expectRefusals(
        Json::parse(readWholeFile(folder / kManifestName)), [&](const Json& json) { putManifest(folder, json); },
        folder);
  }

  TemporaryFolder mFolder;
  Monitor mMonitor;
  Recipe mBase;
};

// Promise of reliability.md: "If somebody changes a plan and corrects its hash, `status`, `submit`, `task` and `merge`
//   either refuse it with 65 or work with it"
TEST_F(HostilePlan, OfTilesIsRefused) { expectRefusals(tiles({})); }

// Promise: "If somebody changes a plan ..."
TEST_F(HostilePlan, OfCountsIsRefused) {
  const fs::path folder = tiles({}, {"count"});
  Json islands = Json::parse(readWholeFile(folder / kManifestName));
  expectRefusals(folder);
  islands["recipe"]["largest"] = "1";
  putManifest(folder, islands);
  EXPECT_TRUE(isRefused(folder, "a count of islands"));
}

// Promise: "If somebody changes a plan ..."
TEST_F(HostilePlan, OfFramesIsRefused) {
  const fs::path folder = mFolder.path() / "frames";
  writePlan(folder, planFrames({.base = mBase,
                                .keys = parseKeys({"alpha@1=20", "alpha@2=60"}, {}, fractalOptionTable()),
                                .frames = {1, 2},
                                .makes = {"vdb", "ply"}}));
  expectRefusals(folder);
}

// Promise: "If somebody changes a plan ..."
TEST_F(HostilePlan, OfCellsIsRefused) {
  Recipe base = mBase;
  base.erase("alpha");
  const Sheet sheet =
      planSheet({.varied = {parseVaried("alpha=20,40", fractalOptionTable(), kMostSheetCells)}, .base = base});
  const fs::path folder = mFolder.path() / "cells";
  writePlan(folder, planSheetCells({.cells = mFolder.write("cells.json", encodeSheet(sheet)).string() + "#2"}));
  expectRefusals(folder);
}

// The hash of the file in the plan is made right as well.
// Promise: "If somebody changes a plan ..."
TEST_F(HostilePlan, APreparedSceneThatCannotBeIsRefused) {
  const fs::path folder = tiles({});
  const fs::path prepared = folder / "prepared.vdb";
  const VdbFile file = readVdb(prepared);
  const Json plan = Json::parse(readWholeFile(folder / kManifestName));
  const auto put = [&](const Json& scene) {
    VdbWriteOptions options;
    options.metadata["julia_prepared"] = scene.dump();
    const std::string bytes = encodeVdb(file.grids, options);
    writeText(prepared, bytes);
    Json changed = plan;
    for (Json& input : changed["inputs"])
      if (input["path"] == "prepared.vdb") input["sha256"] = sha256Hex(bytes);
    putManifest(folder, changed);
  };
  expectRefusals(Json::parse(file.metadata.at("julia_prepared")), put, folder);
}

// A record that does not fit is a task that is not done, whatever is in it.
// Promise: "If somebody changes a plan ..."
TEST_F(HostilePlan, ARecordThatCannotBeIsThatOfATaskToBeMade) {
  const fs::path folder = tiles({});
  use(folder);
  const Manifest manifest = readManifest(folder);
  const std::string original = readWholeFile(folder / "tasks/0001.json");
  const Json record = Json::parse(original);
  for (const Json::json_pointer& at : pointersOf(record))
    for (const Json& other : kOthers) {
      Json changed = record;
      if (!change(changed, at, other)) continue;
      const std::string what = at.to_string() + " as " + (other.is_discarded() ? "nothing" : other.dump());
      writeText(folder / "tasks/0001.json", changed.dump());
      TaskStatus status;
      ASSERT_NO_THROW(status = taskStatus(folder, manifest, 1, FileCheck::Content)) << what;
      EXPECT_EQ(status.error.find('\n'), std::string::npos) << what;
      writeText(folder / "tasks/0001.failed.json", changed.dump());
      ASSERT_NO_THROW(taskStatus(folder, manifest, 1, FileCheck::Quick)) << what;
      fs::remove(folder / "tasks/0001.failed.json");
    }
}

}  // namespace
