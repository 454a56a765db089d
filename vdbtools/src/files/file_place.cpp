// SPDX-License-Identifier: Apache-2.0
#include "files/file_place.h"

namespace vdbtools {

namespace fs = std::filesystem;

fs::path followLinks(const fs::path& path, std::error_code& error) {
  constexpr int kMostLinks = 40;  // the limit of Linux
  fs::path target = path;
  for (int i = 0; i < kMostLinks; ++i) {
    std::error_code ignored;
    if (!fs::is_symlink(fs::symlink_status(target, ignored))) return target;
    const fs::path next = fs::read_symlink(target, error);
    if (error) return path;
    target = target.parent_path() / next;
  }
  error = std::make_error_code(std::errc::too_many_symbolic_link_levels);
  return path;
}

fs::path placeOfFile(const fs::path& file) {
  std::error_code error;
  fs::path place = followLinks(fs::absolute(file, error), error);
  if (!error) place = fs::weakly_canonical(place, error);
  return error ? file.lexically_normal() : place;
}

bool isNoOrdinaryFile(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  return fs::exists(status) && !fs::is_regular_file(status);
}

}  // namespace vdbtools
