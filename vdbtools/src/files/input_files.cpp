// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/files/input_files.h"

#include "files/file_place.h"
#include "vdbtools/files/file_bytes.h"

#include <sys/stat.h>

#include <optional>
#include <stdexcept>
#include <string>

namespace vdbtools {
namespace {

namespace fs = std::filesystem;

using FileNumber = std::pair<dev_t, ino_t>;

/// The number of an existing file.
std::optional<FileNumber> numberOf(const fs::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return std::nullopt;
  return FileNumber(status.st_dev, status.st_ino);
}

[[noreturn]] void refuseOutput(const fs::path& output, const fs::path& input) {
  throw std::invalid_argument("the output '" + inOneLine(output.native()) + "' would replace the input '" +
                              inOneLine(input.native()) + "'; give the output another name");
}

}  // namespace

void InputFiles::add(const fs::path& file) {
  if (file.empty() || isNoOrdinaryFile(file)) return;
  mPlaces.try_emplace(placeOfFile(file), file);
  if (const std::optional<FileNumber> number = numberOf(file)) mFiles.try_emplace(*number, file);
}

void InputFiles::add(const InputFiles& others) {
  mPlaces.insert(others.mPlaces.begin(), others.mPlaces.end());
  mFolders.insert(others.mFolders.begin(), others.mFolders.end());
  mFiles.insert(others.mFiles.begin(), others.mFiles.end());
}

void InputFiles::addFolder(const fs::path& folder) { mFolders.try_emplace(placeOfFile(folder), folder); }

std::vector<fs::path> InputFiles::files() const {
  std::vector<fs::path> files;
  for (const auto& [place, name] : mPlaces) files.push_back(name);
  return files;
}

void InputFiles::requireNot(const fs::path& output) const {
  if (isNoOrdinaryFile(output)) return;
  const fs::path place = placeOfFile(output);
  if (const auto input = mPlaces.find(place); input != mPlaces.end()) refuseOutput(output, input->second);
  if (const std::optional<FileNumber> number = numberOf(output))
    if (const auto input = mFiles.find(*number); input != mFiles.end()) refuseOutput(output, input->second);
  for (fs::path above = place.parent_path(); above.has_relative_path(); above = above.parent_path())
    if (const auto folder = mFolders.find(above); folder != mFolders.end())
      throw std::invalid_argument("the output '" + inOneLine(output.native()) + "' lies in the folder '" +
                                  inOneLine(folder->second.native()) +
                                  "', whose files are inputs; give the output a place elsewhere");
}

}  // namespace vdbtools
