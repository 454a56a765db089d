// SPDX-License-Identifier: Apache-2.0
// Plans, the side-cars of their tasks, tiles, and contact sheets.
#include "farm/task_files.h"
#include "farm/tile_file.h"
#include "farm/tile_islands.h"
#include "fuzz_plan.h"
#include "harness.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/farm/job_template.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/job/sheet_job.h"
#include "vdbtools/records/recorded_recipe.h"

#include <nlohmann/json.hpp>

#include <array>
#include <stdexcept>
#include <string>

namespace fuzz {
namespace {

using namespace vdbtools;
using namespace vdbtools::farm;

/// The text with the hash that belongs to it: changed plans would all be refused for theirs.
std::string withItsHash(std::string_view text) {
  // A parser of JSON can be given nests of any depth, but what is done with them here takes a frame for each.
  constexpr std::ptrdiff_t kMostBrackets = 10'000;
  if (std::count_if(text.begin(), text.end(), [](char c) { return c == '[' || c == '{'; }) > kMostBrackets)
    return std::string(text);
  nlohmann::ordered_json json = nlohmann::ordered_json::parse(text, nullptr, false);
  if (!json.is_object()) return std::string(text);
  try {
    json.erase("hash");
    json["hash"] = sha256Hex(json.dump());
    return json.dump();
  } catch (const nlohmann::json::exception&) {
    return std::string(text);  // it is not UTF-8
  }
}

void readPlan(std::string_view bytes) {
  const bool raw = takeChoice(bytes, 2) == 1;
  scratchFile(kManifestName, raw ? std::string(bytes) : withItsHash(bytes));
  const Manifest manifest = readManifest(scratchFolder());
  encodeManifest(manifest);
  for (std::uint64_t task = 1; task <= std::min<std::uint64_t>(manifest.tasks.size(), 3); ++task) {
    taskHash(manifest, task);
    taskRecipe(manifest, task);
  }
}

/// The files of a task: its record, its mark while it runs, and what is left of a failure.
void readSideCar(std::string_view bytes) {
  static const Manifest manifest = plan();
  const std::filesystem::path folder = scratchFolder();
  std::filesystem::create_directories(tasksFolder(folder));
  const std::array paths = {sideCarPath(folder, 1), runningPath(folder, 1), failedPath(folder, 1)};
  for (const std::filesystem::path& path : paths) std::filesystem::remove(path);
  const std::filesystem::path path = paths[takeChoice(bytes, paths.size())];
  scratchFile(path.lexically_relative(folder).string(), bytes);
  const TaskStatus status = taskStatus(folder, manifest, 1, FileCheck::Quick);
  if (status.error.find('\n') != std::string::npos) throw std::logic_error("an error has more than one line");
  finishedTask(folder, manifest, 1, FileCheck::Content);
}

void readTile(std::string_view bytes) {
  const std::filesystem::path path = scratchFile("file.tile", bytes);
  for (const bool filtered : {false, true}) {
    TileReader reader(path);
    if (filtered) reader.setFilter({.keptParts = {true, false, true}});
    while (reader.nextX()) reader.next();
  }
}

void readIslands(std::string_view bytes) {
  const TileIslandsReader reader(scratchFile("file.islands", bytes));
  reader.forEachOwn([](std::span<const InsideRun>) {});
}

void readSheet(std::string_view bytes) {
  const std::filesystem::path path = scratchFile("sheet.json", bytes);
  isSheetFile(path);
  if (readSheetCells(path).empty()) return;  // without a cell, which one is wanted is the user's mistake
  readRecordedRecipe(path.string() + "#1");
}

void readRecipeFile(std::string_view bytes) {
  const std::filesystem::path path = scratchFile("recipe.json", bytes);
  if (!isRecipeFile(path)) throw DataError("no recipe");
  const RecordedRecipe recorded = readRecordedRecipe(path);
  const std::filesystem::path again = scratchFile("again.json", encodeRecipe(recorded));
  if (readRecordedRecipe(again).recipe != recorded.recipe) throw std::logic_error("a recipe does not survive its file");
}

void readTemplate(std::string_view bytes) {
  const JobTemplate jobTemplate("template.sh", bytes);
  JobFields fields{.name = "a 'farm'", .folder = "/a \"farm\"", .program = "/bin/juliavdb", .tasks = {1, 2, 5}};
  fields.taskArguments = {"task", fields.folder};
  jobTemplate.fill(fields);
  fields.mergeArguments = {"merge", "it's", "$HOME"};
  fields.arguments = {"--more"};
  jobTemplate.fill(fields);
}

constexpr std::array<Harness, 7> kFarmHarnesses = {{
    {"plan", readPlan},
    {"side_car", readSideCar, Refusal::None},
    {"tile", readTile},
    {"tile_islands", readIslands},
    {"sheet", readSheet},
    {"recipe_file", readRecipeFile},
    {"job_template", readTemplate},
}};

}  // namespace

std::span<const Harness> farmHarnesses() { return kFarmHarnesses; }

}  // namespace fuzz
