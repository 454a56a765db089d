// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/farm/manifest.h"

#include "base/json_text.h"
#include "farm/tile_task.h"
#include "farm/variant_plan.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/atomic_file.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/recipe/recipe.h"
#include "vdbtools/scene/fractal_options.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

namespace vdbtools::farm {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFile = "plan";
constexpr int kFormat = 1;

constexpr const char* kFileKey = "juliavdb";
constexpr const char* kFormatKey = "version";
constexpr const char* kProgramKey = "program";
constexpr const char* kHashKey = "hash";

constexpr std::array<std::pair<PlanKind, const char*>, 3> kKinds = {
    {{PlanKind::Tiles, "tiles"}, {PlanKind::Frames, "frames"}, {PlanKind::Sheet, "sheet"}}};

const char* nameOf(PlanKind kind) {
  for (const auto& [other, name] : kKinds)
    if (kind == other) return name;
  throw std::logic_error("a kind of plan has no name");
}

Json jsonOf(const std::map<std::string, std::string>& entries) {
  Json json = Json::object();
  for (const auto& [name, value] : entries) json[name] = value;
  return json;
}

Json jsonOf(const openvdb::CoordBBox& box) {
  const auto corner = [](const openvdb::Coord& c) { return Json::array({c.x(), c.y(), c.z()}); };
  return Json::array({corner(box.min()), corner(box.max())});
}

Json jsonOf(const TileLattice& lattice) {
  return {{"domain", jsonOf(lattice.domain)}, {"bounded", lattice.bounded}, {"voxelSize", lattice.voxelSize}};
}

Json jsonOf(const PlannedTask& task) {
  Json json = Json::object();
  if (!task.recipe.empty()) json["recipe"] = jsonOf(task.recipe);
  if (task.box) json["box"] = jsonOf(*task.box);
  json["writes"] = task.writes;
  return json;
}

/// All of a plan except its hash.
Json jsonOf(const Manifest& manifest) {
  Json json{{kFileKey, kFile},
            {kFormatKey, kFormat},
            {kProgramKey, JULIAVDB_VERSION},
            {"kind", nameOf(manifest.kind)},
            {"makes", manifest.makes},
            {"recipe", jsonOf(manifest.recipe)}};
  if (!manifest.metadata.empty()) json["facts"] = jsonOf(manifest.metadata);
  if (manifest.lattice) json["lattice"] = jsonOf(*manifest.lattice);
  json["inputs"] = Json::array();
  for (const PlannedInput& input : manifest.inputs)
    json["inputs"].push_back({{"path", input.path}, {"sha256", input.sha256}});
  json["tasks"] = Json::array();
  for (const PlannedTask& task : manifest.tasks) json["tasks"].push_back(jsonOf(task));
  return json;
}

/// Becomes a DataError that names the file.
[[noreturn]] void refusePlan(const std::string& why) { throw std::invalid_argument(why); }

/// A loop over JSON of another kind would treat it as a single element.
const Json& arrayOf(const Json& json, const char* name) {
  const Json& array = json.at(name);
  if (!array.is_array()) refusePlan(std::string("'") + name + "' is no list");
  return array;
}

std::map<std::string, std::string> entriesFrom(const Json& json, const char* name) {
  const Json& object = json.at(name);
  if (!object.is_object()) refusePlan(std::string("'") + name + "' is no list of names and values");
  std::map<std::string, std::string> entries;
  for (const auto& [entry, value] : object.items()) entries[entry] = value.get<std::string>();
  return entries;
}

Recipe recipeFrom(const Json& json) {
  Recipe recipe;
  for (const auto& [option, value] : entriesFrom(json, "recipe")) recipe[currentName(option)] = value;
  return recipe;
}

openvdb::CoordBBox boxFrom(const Json& json) {
  const auto corner = [](const Json& c) {
    if (c.size() != 3) refusePlan("the corner of a box has " + std::to_string(c.size()) + " numbers and not 3");
    return openvdb::Coord(wholeOf<int>(c.at(0)), wholeOf<int>(c.at(1)), wholeOf<int>(c.at(2)));
  };
  if (json.size() != 2) refusePlan("a box has " + std::to_string(json.size()) + " corners and not 2");
  return {corner(json.at(0)), corner(json.at(1))};
}

PlanKind kindFrom(const std::string& text) {
  for (const auto& [kind, name] : kKinds)
    if (text == name) return kind;
  refusePlan("it is of the unknown kind '" + inOneLine(text) + "'");
}

bool hasNul(const std::string& text) { return text.find('\0') != std::string::npos; }

/// A plan may come from anywhere; its tasks must write only into its folder.
void requireInside(const std::filesystem::path& name) {
  const bool leaves = std::find(name.begin(), name.end(), "..") != name.end();
  if (!name.has_filename() || name.is_absolute() || leaves || hasNul(name.native()))
    refusePlan("a task would write '" + inOneLine(name.native()) + "', which is no file in the plan's folder");
}

Manifest manifestFrom(const Json& json) {
  Manifest manifest;
  manifest.version = json.at(kProgramKey).get<std::string>();
  manifest.kind = kindFrom(json.at("kind").get<std::string>());
  manifest.makes = json.at("makes").get<std::vector<std::string>>();
  manifest.recipe = recipeFrom(json);
  if (json.contains("facts")) manifest.metadata = entriesFrom(json, "facts");
  if (json.contains("lattice")) {
    const Json& lattice = json.at("lattice");
    manifest.lattice = {boxFrom(lattice.at("domain")), lattice.at("bounded").get<bool>(),
                        lattice.at("voxelSize").get<double>()};
  }
  for (const Json& input : arrayOf(json, "inputs"))
    manifest.inputs.push_back({input.at("path").get<std::string>(), input.at("sha256").get<std::string>()});
  for (const Json& entry : arrayOf(json, "tasks")) {
    PlannedTask task;
    if (entry.contains("recipe")) task.recipe = recipeFrom(entry);
    if (entry.contains("box")) task.box = boxFrom(entry.at("box"));
    task.writes = entry.at("writes").get<std::vector<std::string>>();
    manifest.tasks.push_back(std::move(task));
  }
  return manifest;
}

/// Checks a plan of tiles: that the lattice is valid, that each tile is a part of it, and that the recipe makes these
/// files.
void requireSoundTiles(const Manifest& manifest) {
  if (!manifest.lattice) refusePlan("a plan of tiles has no lattice");
  const TileLattice& lattice = *manifest.lattice;
  if (!(lattice.voxelSize > 0) || !std::isfinite(lattice.voxelSize))
    refusePlan("the voxel size of the lattice is " + std::to_string(lattice.voxelSize));
  // Half of the coordinate range leaves room for the halo of a tile, and for differences.
  constexpr int kFarthest = 1 << 30;
  const openvdb::CoordBBox all(openvdb::Coord(-kFarthest), openvdb::Coord(kFarthest));
  if (lattice.domain.empty() || !all.isInside(lattice.domain))
    refusePlan("the domain of the lattice is no box of nodes");
  const FractalOptions options = parseFractalOptions(manifest.recipe);
  requireCuttable(options, manifest.makes);
  const TileFiles files = tileFiles(manifest, options);
  for (std::uint64_t index = 1; index <= manifest.tasks.size(); ++index) {
    const PlannedTask& task = manifest.tasks[index - 1];
    const std::string name = "tile " + std::to_string(index);
    if (!task.box) refusePlan(name + " has no box");
    if (task.box->empty() || !lattice.domain.isInside(*task.box))
      refusePlan("the box of " + name + " is not in the lattice");
    if (task.writes != tileNames(files, index)) refusePlan(name + " has other files than its recipe makes");
  }
}

/// Checks a plan of whole fractals: that each task has its own file for every product of the plan.
void requireSoundVariants(const Manifest& manifest) {
  const auto folder = manifest.metadata.find(kFolderFact);
  if (folder == manifest.metadata.end() || !std::filesystem::path(folder->second).is_absolute() ||
      hasNul(folder->second))
    refusePlan("the folder from which the names of its files are meant is missing");
  std::set<std::string> names;
  for (const PlannedTask& task : manifest.tasks) {
    bool fits = task.writes.size() == manifest.makes.size();
    for (std::size_t i = 0; fits && i < task.writes.size(); ++i)
      fits = lowerExtension(task.writes[i]) == '.' + manifest.makes[i];
    if (!fits) refusePlan("a task has other files than the plan makes");
    for (const std::string& name : task.writes)
      if (!names.insert(name).second) refusePlan("two tasks would write '" + inOneLine(name) + "'");
  }
}

/// Checks everything on which its tasks and its merging rely and that can be checked without its files.
void requireSoundPlan(const Manifest& manifest) {
  requireMakes(manifest.kind, manifest.makes);
  if (manifest.tasks.empty()) refusePlan("there is no task in it");
  for (const PlannedTask& task : manifest.tasks)
    for (const std::string& name : task.writes) requireInside(name);
  for (const PlannedInput& input : manifest.inputs)
    if (input.path.empty() || hasNul(input.path)) refusePlan("the name of an input is empty, or none");
  if (manifest.kind == PlanKind::Tiles)
    requireSoundTiles(manifest);
  else
    requireSoundVariants(manifest);
}

/// One line for each entry, and for each element of entries that are long lists.
std::string laidOut(const Json& json) {
  std::string text = "{";
  bool first = true;
  for (const auto& [key, value] : json.items()) {
    text += std::string(first ? "" : ",") + "\n \"" + key + "\": ";
    first = false;
    const bool list = key == "inputs" || key == "tasks";
    if (!list && key != "recipe" && key != "facts") {
      text += value.dump();
      continue;
    }
    text += list ? '[' : '{';
    bool inner = false;
    for (const auto& [name, element] : value.items()) {
      text += std::string(inner ? "," : "") + "\n  ";
      if (!list) text += Json(name).dump() + ": ";
      text += element.dump();
      inner = true;
    }
    text += list ? "\n ]" : "\n }";
  }
  return text + "\n}\n";
}

const PlannedTask& taskOf(const Manifest& manifest, std::uint64_t index) {
  if (index >= 1 && index <= manifest.tasks.size()) return manifest.tasks[index - 1];
  throw std::out_of_range("there is no task " + std::to_string(index) + "; the plan has the tasks 1 to " +
                          std::to_string(manifest.tasks.size()));
}

}  // namespace

bool makes(const Manifest& manifest, std::string_view product) {
  return std::find(manifest.makes.begin(), manifest.makes.end(), product) != manifest.makes.end();
}

std::vector<const FileFormat*> formatsOf(const std::vector<std::string>& products) {
  std::vector<const FileFormat*> formats;
  for (const std::string& product : products)
    if (const FileFormat* const format = findFormat('.' + product)) formats.push_back(format);
  return formats;
}

bool makesGrids(const Manifest& manifest) {
  return std::ranges::any_of(formatsOf(manifest.makes), &FileFormat::writesGrids);
}

bool makesMesh(const Manifest& manifest) {
  return std::ranges::any_of(formatsOf(manifest.makes), &FileFormat::writesMesh);
}

std::string encodeManifest(const Manifest& manifest) {
  try {
    const Json content = jsonOf(manifest);
    const std::string hash = sha256Hex(content.dump());
    Json json = Json::object();
    for (const auto& [key, value] : content.items()) {
      json[key] = value;
      if (key == kProgramKey) json[kHashKey] = hash;
    }
    return laidOut(json);
  } catch (const Json::type_error&) {
    // A name with replacement characters would name another file.
    throw DataError("a name or a value of the plan is not UTF-8, as a manifest must be; rename the file");
  }
}

Manifest readManifest(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / kManifestName;
  const std::string name = "'" + inOneLine(path.native()) + "'";
  if (!std::filesystem::exists(path))
    throw MissingInputError("there is no " + name + "; '" + inOneLine(folder.native()) +
                            "' is not the folder of a plan");
  const std::string broken = name + " is a broken plan";
  Json json = parsedJson<Json>(readWholeFile(path));
  if (!json.is_object()) throw DataError(broken + ": it is not valid JSON; plan again");
  try {
    if (json.value(kFileKey, Json()) != kFile) throw DataError(name + " is no plan of juliavdb");
    const std::string program = json.at(kProgramKey).get<std::string>();
    if (program != JULIAVDB_VERSION || json.at(kFormatKey) != kFormat)
      throw DataError(name + " was written by version " + inOneLine(program) + " of juliavdb, and this is version " +
                      JULIAVDB_VERSION + "; use that version for its tasks, or plan again");
    const std::string hash = json.at(kHashKey).get<std::string>();
    json.erase(kHashKey);
    if (sha256Hex(json.dump()) != hash)
      throw DataError(name + " was changed after it was written, so that finished tasks might not belong to it; " +
                      "restore it, or plan again");
    Manifest manifest = manifestFrom(json);
    requireSoundPlan(manifest);
    return manifest;
  } catch (const nlohmann::json::exception&) {
    throw DataError(broken + ": an entry is missing or of the wrong kind; plan again");
  } catch (const std::invalid_argument& error) {
    // The file is at fault, not the request.
    throw DataError(broken + ": " + error.what() + "; plan again");
  }
}

std::string taskHash(const Manifest& manifest, std::uint64_t index) {
  const PlannedTask& task = taskOf(manifest, index);
  Json json{{kProgramKey, manifest.version.empty() ? JULIAVDB_VERSION : manifest.version},
            {"kind", nameOf(manifest.kind)},
            {"makes", manifest.makes},
            {"recipe", jsonOf(manifest.recipe)},
            {"inputs", Json::array()},
            {"task", jsonOf(task)}};
  if (manifest.lattice) json["lattice"] = jsonOf(*manifest.lattice);
  // A moved file is still the same file.
  for (const PlannedInput& input : manifest.inputs) json["inputs"].push_back(input.sha256);
  return sha256Hex(json.dump());
}

Recipe taskRecipe(const Manifest& manifest, std::uint64_t index) {
  const PlannedTask& task = taskOf(manifest, index);
  const OptionTable table = fractalOptionTable();
  return completeRecipe(overridden(manifest.recipe, task.recipe, table), table);
}

namespace fs = std::filesystem;

namespace {

/// Creates and removes a file where the first file of the plan would be created: the manifest, or the first missing
/// folder. It creates no folder, because another process that tests at the same time could take it for an existing one.
void requireWritable(const fs::path& folder) {
  std::error_code error;
  fs::path first = fs::absolute(folder / kManifestName).lexically_normal();
  while (!fs::exists(first.parent_path(), error) && first.parent_path().has_relative_path())
    first = first.parent_path();
  if (!fs::is_directory(first.parent_path(), error))
    throw CreateError("cannot make the folder '" + folder.string() + "': '" + first.parent_path().string() +
                      "' is not a folder");
  if (fs::is_symlink(fs::symlink_status(first, error)))
    throw CreateError("cannot make the folder '" + folder.string() + "': '" + first.string() +
                      "' is a link to what is not there");
  const AtomicFile file(first);
}

}  // namespace

void requireNewPlanFolder(const fs::path& folder) {
  if (folder.empty()) throw CreateError("the name of the plan's folder is empty");
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (status.type() == fs::file_type::not_found) return requireWritable(folder);
  if (status.type() != fs::file_type::directory)
    throw CreateError("'" + folder.string() + "' is not a folder; a plan needs one of its own");
  const bool empty = fs::is_empty(folder, error);
  if (error) throw CreateError("cannot look into '" + folder.string() + "': " + error.message());
  if (!empty)
    throw CreateError("the folder '" + folder.string() +
                      "' is not empty; a plan needs one of its own, so give another name or remove what is there");
  requireWritable(folder);
}

void writePlan(const fs::path& folder, const Manifest& manifest) {
  std::error_code error;
  if (fs::exists(folder / kManifestName, error))
    throw CreateError("another plan was made in '" + folder.string() + "' meanwhile; give another name");
  const bool made = fs::create_directories(folder, error);
  if (error) throw CreateError("cannot make the folder '" + folder.string() + "': " + error.message());
  try {
    AtomicFile file(folder / kManifestName);
    file.stream() << encodeManifest(manifest);
    file.commit();
  } catch (...) {
    // Written by a plan of tiles; with it the folder would seem to be in use.
    fs::remove(folder / kPreparedName, error);
    if (made) fs::remove(folder, error);
    throw;
  }
}

}  // namespace vdbtools::farm
