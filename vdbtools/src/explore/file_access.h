// SPDX-License-Identifier: Apache-2.0
/// @file file_access.h
/// Decides which files a recipe from the page may read. The page may use any option, but only those files that the
/// command line names.
#pragma once

#include "vdbtools/scene/fractal_options.h"

#include <filesystem>
#include <set>
#include <stdexcept>
#include <string>

namespace vdbtools::explore {

/// A recipe names a file that the page may not read.
class FileRefused : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

class FileAccess {
 public:
  /// @param given  the options of the command line
  explicit FileAccess(const FractalOptions& given);

  /// Call it before the files are opened; parsing options opens none.
  /// @throw FileRefused  the options name another file
  void require(const FractalOptions& options) const;
  void require(const NamedFile& file) const;

 private:
  std::set<std::filesystem::path> mAllowed;
};

/// The name of a file to be made, without its extension: letters, digits, spaces and . _ - only, not beginning with a
/// dot, a dash or a space, at most 100 characters.
/// @throw std::invalid_argument
void requireFileName(const std::string& name);

}  // namespace vdbtools::explore
