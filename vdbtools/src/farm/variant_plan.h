// SPDX-License-Identifier: Apache-2.0
/// @file variant_plan.h
/// Plans whose tasks are whole fractals: the common part of frames and cells of a sheet.
#pragma once

#include "vdbtools/farm/manifest.h"

#include <filesystem>
#include <string>
#include <vector>

namespace vdbtools::farm {

struct Variant {
  int number = 1;      ///< in the names of its files
  std::string called;  ///< name in error messages, such as "frame 7"
  Recipe recipe;       ///< not completed
};

struct VariantNames {
  std::string name;                ///< the part of all names that precedes the number
  std::vector<std::string> makes;  ///< extensions without a dot
};

/// Makes the plan of these variants. Its recipe has the entries that all of them share, and each task's recipe has the
/// others. taskRecipe() is the variant's recipe, completed and with the hashes of its files.
/// @throw std::invalid_argument  an option or a name is refused; DataError, MissingInputError, IoError
Manifest planVariants(PlanKind kind, const std::vector<Variant>& variants, const VariantNames& names);

/// The name of the fact of a plan that folderOfNames() returns.
inline constexpr const char* kFolderFact = "folder";

/// Checks what the tasks of a plan make, Manifest::makes. @throw std::invalid_argument  unknown, duplicate, or empty
void requireMakes(PlanKind kind, const std::vector<std::string>& makes);

/// The folder to which relative file names in the recipes of this plan refer.
std::filesystem::path folderOfNames(const Manifest& manifest);

/// @a recipe with the relative names of its files made absolute. @throw std::invalid_argument  this fails
Recipe withAbsoluteNames(const Recipe& recipe, const std::filesystem::path& folder);

}  // namespace vdbtools::farm
