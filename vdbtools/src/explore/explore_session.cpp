// SPDX-License-Identifier: Apache-2.0
#include "explore/explore_session.h"

#include "base/json_text.h"
#include "explore/export_page.h"
#include "explore/failure_answer.h"
#include "explore/look_data.h"
#include "explore/made_picture.h"
#include "explore/made_recipe.h"
#include "explore/scene_data.h"
#include "explore/shell_command.h"
#include "explore/start_data.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/fractal_space.h"
#include "vdbtools/farm/plans.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/recipe/recipe.h"
#include "vdbtools/records/recorded_recipe.h"
#include "vdbtools/scene/voxel_advice.h"
#include "vdbtools/surface/level_set.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

namespace vdbtools::explore {
namespace {

using nlohmann::json;

constexpr std::size_t kMostBody = 64 << 10, kMostFile = std::size_t(256) << 20;  // bytes
constexpr std::size_t kMostVolumes = 8, kMostEntries = 300, kMostKeys = 100;
constexpr std::size_t kMostTargetTriangles = 100'000;

/// There is nothing at this path.
class NoSuchPath : public std::runtime_error {
 public:
  NoSuchPath() : std::runtime_error("there is nothing here") {}
};

json objectOf(const std::string& body) {
  json object = parsedJson<json>(body);
  if (!object.is_object()) throw std::invalid_argument("the body of the request is not a JSON object");
  return object;
}

std::string textOf(const json& object, const char* name, const std::string& usual = {}) {
  const auto entry = object.find(name);
  if (entry == object.end() || entry->is_null()) return usual;
  if (!entry->is_string()) throw std::invalid_argument("'" + std::string(name) + "' must be a text");
  return entry->get<std::string>();
}

bool flagOf(const json& object, const char* name) {
  const auto entry = object.find(name);
  if (entry == object.end() || entry->is_null()) return false;
  if (!entry->is_boolean()) throw std::invalid_argument("'" + std::string(name) + "' must be true or false");
  return entry->get<bool>();
}

/// The maximum number of nodes of a scene's volume along an axis: a small picture needs fewer than a large one.
SceneDataOptions volumeOf(const json& object) {
  SceneDataOptions options;
  const auto entry = object.find("side");
  if (entry == object.end() || entry->is_null()) return options;
  if (!entry->is_number_unsigned() || *entry < 16 || *entry > options.side)
    throw std::invalid_argument("'side' must be a whole number of nodes from 16 to 256");
  options.side = entry->get<int>();
  return options;
}

Recipe recipeOf(const json& body) {
  const auto entry = body.find("recipe");
  if (entry == body.end() || !entry->is_object() || entry->size() > kMostEntries)
    throw std::invalid_argument("'recipe' must be an object of options");
  Recipe recipe;
  for (const auto& [name, value] : entry->items()) {
    if (!value.is_string()) throw std::invalid_argument("the option '" + inOneLine(name) + "' must be a text");
    recipe[currentName(name)] = value.get<std::string>();
  }
  return recipe;
}

std::vector<std::string> formatsOf(const json& body) {
  const auto entry = body.find("formats");
  if (entry == body.end()) return {"vdb"};
  std::vector<std::string> formats;
  for (const json& format : entry->is_array() ? *entry : json::array()) {
    if (!format.is_string()) throw std::invalid_argument("'formats' must be a list of names");
    formats.push_back(format.get<std::string>());
  }
  return formats;
}

int frameOf(const json& object) {
  const auto frame = object.find("frame");
  if (frame == object.end() || !frame->is_number_unsigned() || *frame >= farm::kMostFrames)
    throw std::invalid_argument("'frame' must be a whole number from 0 to " + std::to_string(farm::kMostFrames - 1));
  return frame->get<int>();
}

/// The entries that are equal in the recipes of all keys, whether they were given or follow from the rest of the
/// recipe.
Recipe sharedBy(const std::map<int, const Recipe*>& given, const std::map<int, const Recipe*>& completed) {
  Recipe shared;
  for (const auto& [frame, recipe] : given)
    for (const Recipe::value_type& said : *recipe)
      if (std::all_of(completed.begin(), completed.end(), [&](const auto& key) {
            const auto entry = key.second->find(said.first);
            return entry != key.second->end() && *entry == said;
          }))
        shared.insert(said);
  return shared;
}

/// Whether an option may have values between those of two keys. The seed, a whole number, may not.
bool isSmooth(const farm::KeyedOption& option, const Recipe& recipe) {
  constexpr int kSpan = 1'000'003;  // a prime, so no frame in between lies at a round fraction
  for (auto key = option.keys.begin(); std::next(key) != option.keys.end(); ++key) {
    Recipe between = recipe;
    between[option.name] = farm::valueAt({option.name, {{0, key->second}, {kSpan, std::next(key)->second}}}, kSpan / 3);
    try {
      parseFractalOptions(between);
    } catch (const std::invalid_argument&) {
      return false;
    }
  }
  return true;
}

/// An option with its keys. It changes in steps if it cannot change gradually.
farm::KeyedOption keyedOption(const std::string& name, const std::map<int, const Recipe*>& recipes,
                              const std::string& ease, const OptionTable& table) {
  std::vector<std::string> keys;
  for (const auto& [frame, recipe] : recipes) {
    const auto entry = recipe->find(name);
    if (entry == recipe->end())
      throw std::invalid_argument("the look of frame " + std::to_string(frame) + " has no --" + name +
                                  ", which those of other keys have; give it to all of them or to none");
    keys.push_back(name + '@' + std::to_string(frame) + '=' + entry->second);
  }
  farm::KeyedOption option = farm::parseKeys(keys, {"step"}, table).front();
  if (ease == "step") return option;
  try {
    option = farm::parseKeys(keys, {ease}, table).front();
    if (!isSmooth(option, *recipes.begin()->second)) option.ease = farm::Ease::Step;
  } catch (const std::invalid_argument&) {
    if (ease != "linear" && ease != "smooth") throw;
  }
  return option;
}

void appendNumber(std::string& bytes, std::uint32_t number) {
  static_assert(std::endian::native == std::endian::little);
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

/// The bytes of a mesh, relative to the middle of @a box and in units of its longest side.
std::string meshBytes(const Mesh& mesh, const openvdb::BBoxd& box) {
  const openvdb::Vec3d middle = box.getCenter();
  const double unit = longestSide(box);
  std::string bytes;
  bytes.reserve(8 + 12 * (mesh.points.size() + mesh.triangles.size()));
  appendNumber(bytes, static_cast<std::uint32_t>(mesh.points.size()));
  appendNumber(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const openvdb::Vec3d& point : mesh.points)
    for (int axis = 0; axis < 3; ++axis)
      appendNumber(bytes, std::bit_cast<std::uint32_t>(static_cast<float>((point[axis] - middle[axis]) / unit)));
  for (const openvdb::Vec3I& triangle : mesh.triangles)
    for (int corner = 0; corner < 3; ++corner) appendNumber(bytes, triangle[corner]);
  return bytes;
}

ExploreAnswer jsonAnswer(const json& value, int status = 200) {
  // Names of files may contain bytes that are not UTF-8.
  return {status, "application/json", value.dump(-1, ' ', false, json::error_handler_t::replace)};
}

/// The folder for files. Refuses, before any work, a folder that does not exist and cannot be created.
std::filesystem::path folderOf(const std::filesystem::path& folder) {
  std::error_code error;
  if (folder.empty() || std::filesystem::is_directory(folder, error)) return folder;
  const std::filesystem::path parent = folder.has_parent_path() ? folder.parent_path() : ".";
  if (std::filesystem::exists(folder, error) || !std::filesystem::is_directory(parent, error))
    throw CreateError("there is no folder '" + folder.string() + "' to make files in, and none can be made there");
  return folder;
}

void makeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  if (!folder.empty() && !std::filesystem::create_directory(folder, error) && error)
    throw CreateError("cannot make the folder '" + folder.string() + "': " + error.message());
}

const char* nameOf(JobState state) {
  switch (state) {
    case JobState::Queued: return "queued";
    case JobState::Running: return "running";
    case JobState::Done: return "done";
    case JobState::Failed: return "failed";
    case JobState::Cancelled: return "cancelled";
  }
  return "";
}

InputFiles inputsOf(const ExploreOptions& options) {
  InputFiles inputs = options.inputs;
  inputs.add(inputsOf(parseFractalOptions(options.given)));
  return withRecordedFiles(std::move(inputs));
}

}  // namespace

ExploreSession::ExploreSession(const ExploreOptions& options, Monitor& monitor)
    : mTable(fractalOptionTable()),
      mGiven(options.given),
      mFolder(folderOf(options.folder)),
      mAccess(parseFractalOptions(options.given)),
      mJobs(mFolder, inputsOf(options), options.makeShare) {
  const Recipe completed = completeRecipe(mGiven, mTable);
  const FractalOptions shown = shownOptions(parseFractalOptions(completed));
  requireShown(mScenes.get(completed, shown, SceneStore::Turn::Waits, monitor)->scene());
  makeFolder(mFolder);
}

std::size_t ExploreSession::mostBytes(const std::string& path) { return path == "recipe" ? kMostFile : kMostBody; }

ExploreSession::Look ExploreSession::lookOf(const json& body) const {
  Look look{.given = recipeOf(body)};
  look.completed = completeRecipe(look.given, mTable);
  const FractalOptions options = parseFractalOptions(look.completed);
  mAccess.require(options);
  look.options = shownOptions(options);
  return look;
}

ExploreSession::Look ExploreSession::lookToMake(const json& body) const {
  const auto resolution = body.find("resolution");
  if (resolution == body.end() || resolution->is_null()) return lookOf(body);
  json with = body;
  with["recipe"] = overridden(recipeOf(body), {{"resolution", numberText(*resolution, "resolution")}}, mTable);
  return lookOf(with);
}

std::shared_ptr<KeptScene> ExploreSession::sceneOf(const Look& look, SceneStore::Turn turn, Monitor& monitor) {
  return mScenes.get(look.completed, look.options, turn, monitor);
}

json ExploreSession::target() {
  const std::shared_ptr<const TargetInput> input = mScenes.target();
  const auto name = mGiven.find("input");
  if (!input || name == mGiven.end()) return {};
  const openvdb::BBoxd& box = input->box();
  json data = {{"name", std::filesystem::path(name->second).filename().string()},
               {"box", {box.min()[0], box.min()[1], box.min()[2], box.max()[0], box.max()[1], box.max()[2]}},
               {"longestSide", longestSide(box)},
               {"atRest", hasRest(mGiven)},
               {"attributes", json::array()}};
  if (const std::shared_ptr<const Mesh> mesh = input->mesh()) {
    data["triangles"] = mesh->triangles.size();
    for (const VertexAttribute& attribute : mesh->attributes) data["attributes"].push_back(attribute.name);
  }
  return data;
}

json ExploreSession::start() {
  json data = programData();
  data["recipe"] = mGiven;
  data["target"] = target();
  data["folder"] = (mFolder.empty() ? std::filesystem::current_path() : std::filesystem::absolute(mFolder)).string();
  return data;
}

json ExploreSession::scene(const json& body, Monitor& monitor) {
  const auto turn = flagOf(body, "wait") ? SceneStore::Turn::Waits : SceneStore::Turn::Latest;
  const SceneDataOptions volume = volumeOf(body);
  const std::shared_ptr<KeptScene> kept = sceneOf(lookOf(body), turn, monitor);
  SceneData data = sceneData(kept->scene(), volume, monitor);
  const std::lock_guard lock(mMutex);
  for (const auto& [entry, bytes] : {std::pair("exponent", &data.volume), std::pair("grain", &data.grain)}) {
    if (bytes->empty()) continue;
    const std::string id = data.description.at(entry).at("id").get<std::string>();
    mVolumes.remove_if([&](const Volume& volume) { return volume.id == id; });
    mVolumes.push_front({id, std::make_shared<const std::string>(std::move(*bytes))});
    if (mVolumes.size() > kMostVolumes) mVolumes.pop_back();
  }
  return std::move(data.description);
}

std::string ExploreSession::volume(const std::string& id) {
  std::shared_ptr<const std::string> bytes;
  {
    const std::lock_guard lock(mMutex);
    for (const Volume& volume : mVolumes)
      if (volume.id == id) bytes = volume.bytes;
  }
  if (!bytes) throw NoSuchPath();
  return *bytes;
}

std::string ExploreSession::targetMesh(Monitor& monitor) {
  const std::shared_ptr<const TargetInput> input = mScenes.target();
  if (!input) throw NoSuchPath();
  const std::lock_guard lock(mTargetMutex);
  if (mMeshOf == input) return mTargetMesh;
  const std::shared_ptr<const Mesh> mesh = input->mesh();
  // A mesh too fine for a browser is replaced by the surface of its distances, which is the shape that the fractal
  // follows.
  if (mesh && mesh->triangles.size() <= kMostTargetTriangles)
    mTargetMesh = meshBytes(*mesh, input->box());
  else
    mTargetMesh = meshBytes(meshOfLevelSet(*input->coarseDistances(monitor).phi, monitor), input->box());
  mMeshOf = input;
  return mTargetMesh;
}

std::string ExploreSession::picture(const json& body, Monitor& monitor) {
  const FieldPicture picture = pictureOf(body);
  if (picture.colour && picture.colour->picture) mAccess.require(*picture.colour->picture);
  if (flagOf(body, "mesh")) {
    Look look = lookToMake(body);
    look.options.picture = false;
    return pictureOfMesh(sceneOf(look, SceneStore::Turn::Waits, monitor)->scene(), picture, monitor);
  }
  return sceneOf(lookOf(body), SceneStore::Turn::Waits, monitor)->picture(picture, monitor);
}

/// The numbers of a look, from which the page makes its live picture.
json ExploreSession::look(const json& body) { return lookData(lookTexts(body)); }

/// How a recipe colours its scene.
json ExploreSession::colouring(const json& body, Monitor& monitor) {
  const Look look = lookOf(body);
  const std::shared_ptr<KeptScene> kept = sceneOf(look, SceneStore::Turn::Waits, monitor);
  return colouringData(kept->scene(),
                       look.options.output.attributes.colour.value_or(ColourChoice{.by = FieldColour::Clay}), monitor);
}

/// Says which details of a recipe are finer than its voxels.
json ExploreSession::advice(const json& body, Monitor& monitor) {
  const std::shared_ptr<KeptScene> kept = sceneOf(lookToMake(body), SceneStore::Turn::Waits, monitor);
  return {{"finer", finerThanVoxelsText(kept->scene())}};
}

std::string ExploreSession::made(const json& body, Monitor& monitor) {
  const auto number = body.find("job");
  const std::optional<MadeFiles> files =
      number != body.end() && number->is_number_integer() ? mJobs.madeFiles(number->get<int>()) : std::nullopt;
  if (!files) throw NoSuchPath();
  return pictureOfMade(*files, pictureOf(body), monitor);
}

json ExploreSession::make(const json& body) {
  Look look = lookToMake(body);
  const JobRequest request{.recipe = std::move(look.completed),
                           .given = std::move(look.given),
                           .name = textOf(body, "name"),
                           .formats = formatsOf(body),
                           .overwrite = flagOf(body, "overwrite")};
  return {{"job", mJobs.add(request)}};
}

json ExploreSession::jobs() {
  json all = json::array();
  for (const JobStatus& status : mJobs.list()) {
    json job = {{"job", status.number},          {"name", status.request.name},
                {"state", nameOf(status.state)}, {"phase", status.phase},
                {"share", status.share},         {"files", status.files},
                {"warnings", status.warnings},   {"formats", status.request.formats},
                {"recipe", status.request.given}};
    job["left"] = status.left < 0 ? json() : json(status.left);
    job["error"] = status.error.empty() ? json() : json(status.error);
    all.push_back(std::move(job));
  }
  return all;
}

json ExploreSession::recipe(const std::string& name, const std::string& bytes) {
  Recipe recorded = recipeOfMadeFile(name, bytes);
  json note;
  const auto hash = recorded.find("source-sha256"), input = recorded.find("input");
  const auto target = mGiven.find("input");
  const bool same = hash != recorded.end() && target != mGiven.end() && hash->second == sha256OfFile(target->second);
  if (input != recorded.end() && !mGiven.contains("input"))
    throw DataError("'" + inOneLine(name) + "' was made of a target, '" + inOneLine(input->second) +
                    "'; start 'juliavdb explore' with it");
  if (same) {
    // The same file, perhaps under another name.
    recorded["input"] = target->second;
  } else if (input != recorded.end()) {
    note = "it was made of '" + inOneLine(input->second) + "'; this is the same recipe over the target at hand";
    recorded = overTarget(std::move(recorded), mGiven);
  }
  // With a hash, a file could not be used after it has changed; without it, the recipe is only a look.
  for (const std::string& entry : mTable.hashNames()) recorded.erase(entry);
  recorded = shortestRecipe(recorded, mTable);
  mAccess.require(parseFractalOptions(recorded));
  return {{"recipe", recorded}, {"note", note}};
}

json ExploreSession::command(const json& body) {
  const Look look = lookToMake(body);
  const std::string name = textOf(body, "name", "look");
  requireFileName(name);
  // A command writes one file of grids and one mesh; each further file takes a command of its own.
  std::vector<std::vector<std::pair<std::string, std::string>>> outputs(1);
  const std::vector<std::string> known = writtenFormats();
  for (const std::string& format : formatsOf(body)) {
    if (std::find(known.begin(), known.end(), format) == known.end())
      throw std::invalid_argument("there is no format '" + inOneLine(format) + "' for files");
    const std::string option = findFormat('.' + format)->writesMesh ? "--mesh" : "-o";
    const auto free = std::ranges::find_if(outputs, [&](const auto& files) {
      return std::ranges::none_of(files, [&](const auto& file) { return file.first == option; });
    });
    (free == outputs.end() ? outputs.emplace_back() : *free)
        .emplace_back(option, (mFolder / (name + '.' + format)).string());
  }
  std::string commands;
  for (const auto& files : outputs)
    commands += (commands.empty() ? "" : "\n") + fractalCommand(look.given, mTable, files);
  if (!body.contains("view")) return {{"command", commands}};
  pictureOf(body);  // checks the options
  return {{"command", commands},
          {"picture", pictureCommand(look.given, mTable, pictureTexts(body), (mFolder / (name + ".png")).string())}};
}

/// The command of a sequence between looks, and the look at one of its frames.
json ExploreSession::sequence(const json& body) {
  const auto keys = body.find("keys");
  if (keys == body.end() || !keys->is_array() || keys->size() < 2 || keys->size() > kMostKeys)
    throw std::invalid_argument("'keys' must be a list of 2 to 100 keys");
  std::map<int, Look> looks;
  for (const json& key : *keys) {
    if (!key.is_object()) throw std::invalid_argument("a key must be an object");
    if (!looks.emplace(frameOf(key), lookOf(key)).second)
      throw std::invalid_argument("frame " + std::to_string(frameOf(key)) + " has two keys");
  }
  const int first = looks.begin()->first, last = looks.rbegin()->first;
  const std::string frames = std::to_string(first) + '-' + std::to_string(last);
  farm::FramePlanOptions options{.frames = farm::parseFrames(frames), .name = textOf(body, "name")};
  if (!options.name.empty()) requireFileName(options.name);
  std::map<int, const Recipe*> given, completed;
  for (const auto& [frame, look] : looks) {
    given[frame] = &look.given;
    completed[frame] = &look.completed;
  }
  options.base = sharedBy(given, completed);
  std::set<std::string> changing;
  for (const auto& [frame, recipe] : given)
    for (const auto& [name, value] : *recipe)
      if (!options.base.contains(name)) changing.insert(name);
  if (changing.empty()) throw std::invalid_argument("all keys have the same look; change it between two of them");
  const std::string ease = textOf(body, "ease", "linear");
  for (const std::string& name : changing) options.keys.push_back(keyedOption(name, completed, ease, mTable));
  if (const auto resolution = body.find("resolution"); resolution != body.end() && !resolution->is_null())
    options.base = overridden(options.base, {{"resolution", numberText(*resolution, "resolution")}}, mTable);
  for (const auto& [frame, recipe] : given) parseFractalOptions(completeRecipe(farm::recipeAt(options, frame), mTable));
  const std::string folder = (options.name.empty() ? "look" : options.name) + "-frames";
  json answer = {{"frames", frames}, {"command", framesCommand(options, frames, mTable, (mFolder / folder).string())}};
  if (body.contains("frame")) answer["recipe"] = farm::recipeAt(options, frameOf(body));
  return answer;
}

std::string ExploreSession::exported(const json& body, Monitor& monitor) {
  const Look look = lookOf(body);
  const std::shared_ptr<KeptScene> kept = sceneOf(look, SceneStore::Turn::Waits, monitor);
  return exportPage(kept->scene(), look.given, body.value("look", json()), monitor);
}

ExploreAnswer ExploreSession::answer(const ExploreRequest& request, Monitor& monitor) {
  const std::string& path = request.path;
  const bool get = request.method == "GET", post = request.method == "POST";
  const auto below = [&](std::string_view folder) {
    return path.starts_with(folder) ? std::optional(path.substr(folder.size())) : std::nullopt;
  };
  constexpr const char* kBytes = "application/octet-stream";
  try {
    if (get && path == "start") return jsonAnswer(start());
    if (get && path == "target") return {200, kBytes, targetMesh(monitor)};
    if (get && path == "jobs") return jsonAnswer(jobs());
    if (const auto id = below("volume/"); get && id) return {200, kBytes, volume(*id)};
    if (const auto number = below("jobs/"); request.method == "DELETE" && number) {
      const std::optional<int> job = wholeFromText<int>(*number);
      if (!job || !mJobs.cancel(*job)) throw NoSuchPath();
      return jsonAnswer(json::object());
    }
    if (post && path == "recipe") return jsonAnswer(recipe(request.name, request.body));
    if (post && path == "scene") return jsonAnswer(scene(objectOf(request.body), monitor));
    if (post && path == "picture") return {200, "image/png", picture(objectOf(request.body), monitor)};
    if (post && path == "look") return jsonAnswer(this->look(objectOf(request.body)));
    if (post && path == "colouring") return jsonAnswer(colouring(objectOf(request.body), monitor));
    if (post && path == "advice") return jsonAnswer(advice(objectOf(request.body), monitor));
    if (post && path == "made") return {200, "image/png", made(objectOf(request.body), monitor)};
    if (post && path == "make") return jsonAnswer(make(objectOf(request.body)));
    if (post && path == "command") return jsonAnswer(command(objectOf(request.body)));
    if (post && path == "sequence") return jsonAnswer(sequence(objectOf(request.body)));
    if (post && path == "export") return {200, "text/html; charset=utf-8", exported(objectOf(request.body), monitor)};
    throw NoSuchPath();
  } catch (const NoSuchPath& error) {
    return jsonAnswer({{"error", error.what()}}, 404);
  } catch (...) {
    const FailureAnswer failure = currentFailureAnswer();
    return jsonAnswer({{"error", failure.text}}, failure.status);
  }
}

}  // namespace vdbtools::explore
