// SPDX-License-Identifier: Apache-2.0
#include "explore/file_access.h"

#include "vdbtools/files/file_bytes.h"
#include "vdbtools/scene/scene.h"

#include <algorithm>
#include <string_view>

namespace vdbtools::explore {

FileAccess::FileAccess(const FractalOptions& given) {
  for (const NamedFile& file : filesOf(given)) mAllowed.insert(file.path);
}

void FileAccess::require(const FractalOptions& options) const {
  for (const NamedFile& file : filesOf(options)) require(file);
}

void FileAccess::require(const NamedFile& file) const {
  if (!mAllowed.contains(file.path))
    throw FileRefused("the page may not read '" + inOneLine(file.path.string()) +
                      "': only files that the command line of 'juliavdb explore' names can be used");
}

void requireFileName(const std::string& name) {
  constexpr std::size_t kMost = 100;
  constexpr std::string_view kOthers = " ._-";
  const auto allowed = [&](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           kOthers.find(c) != kOthers.npos;
  };
  if (name.empty() || name.size() > kMost || !std::all_of(name.begin(), name.end(), allowed) ||
      name.find_first_of(" .-") == 0)
    throw std::invalid_argument("the name is '" + inOneLine(name) +
                                "'; it must have 1 to 100 letters, digits, spaces, dots, dashes or underscores, and "
                                "begin with a letter, a digit or an underscore");
}

}  // namespace vdbtools::explore
