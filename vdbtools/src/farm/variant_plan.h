// SPDX-License-Identifier: Apache-2.0
/// @file variant_plan.h
/// Plans whose tasks are whole fractals: what frames and cells of a sheet have in common.
#pragma once

#include "vdbtools/farm/manifest.h"

#include <filesystem>
#include <string>
#include <vector>

namespace vdbtools::farm {

struct Variant {
  int number = 1;      ///< in the names of its files
  std::string called;  ///< in errors, such as "frame 7"
  Recipe recipe;       ///< not completed
};

struct VariantNames {
  std::string name;                ///< the part of all names before the number
  std::vector<std::string> makes;  ///< extensions without a dot
};

/// The plan of these variants. Its recipe has the entries that all of them share, and each task's recipe has the
/// others. taskRecipe() is the variant's recipe, completed and with the hashes of its files.
/// @throw std::invalid_argument  an option or a name is refused; DataError, MissingInputError, IoError
Manifest planVariants(PlanKind kind, const std::vector<Variant>& variants, const VariantNames& names);

/// The fact of a plan that folderOfNames() gives.
inline constexpr const char* kFolderFact = "folder";

/// What the tasks of a plan make, Manifest::makes. @throw std::invalid_argument  unknown, twice, or nothing
void requireMakes(const std::vector<std::string>& makes);

/// The folder from which relative names of files in the recipes of this plan are meant.
std::filesystem::path folderOfNames(const Manifest& manifest);

/// @a recipe with the relative names of its files made absolute. @throw std::invalid_argument  where that fails
Recipe withAbsoluteNames(const Recipe& recipe, const std::filesystem::path& folder);

}  // namespace vdbtools::farm
