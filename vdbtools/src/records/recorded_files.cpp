// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/records/recorded_recipe.h"

#include "records/file_names.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/files/standard_streams.h"
#include "vdbtools/formats/file_formats.h"
#include "vdbtools/job/sdf_job.h"
#include "vdbtools/recipe/option_value.h"
#include "vdbtools/scene/fractal_options.h"
#include "vdbtools/scene/scene.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string_view>
#include <system_error>

namespace vdbtools {
namespace {

namespace fs = std::filesystem;

bool isFile(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(pathToOpen(path), error);
}

bool holds(const fs::path& path, const std::string& hash) {
  try {
    return isFile(path) && sha256OfFile(path) == hash;
  } catch (const std::runtime_error&) {
    return false;  // it cannot be read, or it was removed in between
  }
}

/// Whether a recorded name is that of the standard input, whose content is no longer available.
bool wasPiped(const fs::path& recorded) { return recorded == kStandardStream; }

/// The files in a folder and below whose extension allows them to be the recorded one, in the order of their names. A
/// file that came through a pipe has no extension.
std::vector<fs::path> filesBelow(const fs::path& folder, const fs::path& recorded) {
  const std::string extension = lowerExtension(recorded);
  const auto fits = [&](const fs::path& file) {
    if (!wasPiped(recorded)) return lowerExtension(file) == extension;
    const FileFormat* const format = findFormat(file.native());
    return format && format->piped;
  };
  std::vector<fs::path> files;
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, fs::directory_options::skip_permission_denied, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error))
    if (fits(entry->path()) && isFile(entry->path())) files.push_back(entry->path());
  std::sort(files.begin(), files.end());
  return files;
}

/// The places where a file of a recipe is looked for without a search.
std::vector<fs::path> usualPlaces(const fs::path& recorded, const fs::path& holder) {
  const fs::path beside = holder.parent_path();
  return {recorded, beside / recorded, beside / recorded.filename()};
}

std::optional<fs::path> find(const fs::path& recorded, const std::string& hash, const FileSearch& search) {
  const fs::path name = recorded.filename();
  std::vector<fs::path> candidates = usualPlaces(recorded, search.holder);
  for (const fs::path& folder : search.folders) {
    if (recorded.is_relative()) candidates.push_back(folder / recorded);
    candidates.push_back(folder / name);
  }
  for (const fs::path& candidate : candidates)
    if (holds(candidate, hash)) return candidate.lexically_normal();
  for (const fs::path& folder : search.folders)
    for (const fs::path& candidate : filesBelow(folder, recorded))
      if (holds(candidate, hash)) return candidate.lexically_normal();
  return std::nullopt;
}

[[noreturn]] void refuseMissing(const fs::path& recorded, const std::string& hash, const FileSearch& search) {
  constexpr std::size_t kDigits = 12;
  if (wasPiped(recorded))
    throw MissingInputError("the target of the recipe in '" + search.holder.string() +
                            "' came through a pipe (SHA-256 " + hash.substr(0, kDigits) +
                            "...); name the file that it came from in its place, or that file's folder with --search "
                            "DIR" +
                            search.wayOut);
  std::string places = "where the recipe says, nor beside '" + search.holder.string() + "'";
  for (const fs::path& folder : search.folders) places += ", nor in '" + folder.string() + "'";
  throw MissingInputError("'" + recorded.string() + "' (SHA-256 " + hash.substr(0, kDigits) + "...) is neither " +
                          places + "; name its folder with --search DIR" + search.wayOut);
}

/// The files of which a recipe has hashes, each with its hash.
std::vector<std::pair<fs::path, std::string>> hashedFiles(const Recipe& recipe, const MapRegistry& maps) {
  std::map<std::string, std::vector<NamedFile>> byEntry;
  for (const NamedFile& file : filesOf(parseFractalOptions(recipe, maps)))
    if (!file.expectedHash.empty()) byEntry[file.recordedAs].push_back(file);
  std::vector<std::pair<fs::path, std::string>> result;
  for (const auto& [entry, files] : byEntry) {
    const std::vector<std::string> hashes = split(files.front().expectedHash, ',');
    for (std::size_t i = 0; i < files.size() && hashes.size() == files.size(); ++i)
      result.emplace_back(files[i].path, hashes[i]);
  }
  return result;
}

/// The files that the recipe in a file names; empty if no recipe can be read.
std::vector<fs::path> recordedNames(const fs::path& file, const MapRegistry& maps) {
  if (!isFile(file)) return {};
  if (const FileFormat* const format = findFormat(file.native()); !(format && format->recipe) && !isRecipeFile(file))
    return {};
  std::vector<fs::path> names;
  try {
    const auto [command, recipe] = readRecordedRecipe(file, maps);
    if (command == "sdf") names.push_back(parseSdfOptions(recipe).input);
    if (command == "fractal")
      for (const NamedFile& named : filesOf(parseFractalOptions(recipe, maps))) names.push_back(named.path);
  } catch (const DataError&) {
  } catch (const MissingInputError&) {
  }
  return names;
}

}  // namespace

FoundFiles findRecordedFiles(const Recipe& recipe, const FileSearch& search, const MapRegistry& maps) {
  for (const fs::path& folder : search.folders) {
    std::error_code error;
    if (!fs::is_directory(folder, error)) refuse("search", folder.string(), "a folder");
  }
  const OptionTable table = fractalOptionTable(maps);
  FoundFiles result;
  std::map<std::string, std::string> names;
  for (const auto& [recorded, hash] : hashedFiles(completeRecipe(recipe, table), maps)) {
    if (names.contains(recorded.string())) continue;
    const std::optional<fs::path> found = find(recorded, hash, search);
    if (!found && !isFile(recorded)) refuseMissing(recorded, hash, search);
    if (!found || *found == recorded.lexically_normal()) continue;
    names[recorded.string()] = found->string();
    result.elsewhere.push_back({recorded, *found});
  }
  result.recipe = names.empty() ? recipe : withFileNames(recipe, names, table);
  const std::vector<NamedFile> opened = filesOf(parseFractalOptions(completeRecipe(result.recipe, table), maps));
  for (const auto& [recorded, found] : result.elsewhere)
    if (std::none_of(opened.begin(), opened.end(),
                     [&, &where = found](const NamedFile& file) { return file.path == where; }))
      throw std::invalid_argument(
          "'" + recorded.string() + "' was found as '" + found.string() +
          "', which cannot stand in the value of an option; move it to a folder without colons");
  return result;
}

InputFiles withRecordedFiles(InputFiles inputs, const MapRegistry& maps) {
  std::vector<fs::path> left = inputs.files();
  std::set<fs::path> seen;
  while (!left.empty()) {
    const fs::path holder = std::move(left.back());
    left.pop_back();
    if (!seen.insert(holder.lexically_normal()).second) continue;
    for (const fs::path& recorded : recordedNames(holder, maps))
      for (const fs::path& place : usualPlaces(recorded, holder)) {
        if (!isFile(place)) continue;
        inputs.add(place.lexically_normal());
        left.push_back(place);
      }
  }
  return inputs;
}

}  // namespace vdbtools
