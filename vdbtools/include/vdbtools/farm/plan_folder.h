// SPDX-License-Identifier: Apache-2.0
/// @file plan_folder.h
/// The folder of a new plan.
#pragma once

#include "vdbtools/farm/manifest.h"

#include <filesystem>

namespace vdbtools::farm {

/// Makes sure that a plan can be put there: the folder does not exist, or is empty, and takes files. It is made by
/// writePlan(); what is made to try is removed again.
/// @throw CreateError
void requireNewPlanFolder(const std::filesystem::path& folder);

/// Makes the folder if there is none and writes the manifest, the last file of a plan. If that fails, a folder that
/// was made for it is removed again, and so is what was prepared for its tasks.
/// @throw CreateError  also where another plan was made there meanwhile
/// @throw IoError
void writePlan(const std::filesystem::path& folder, const Manifest& manifest);

}  // namespace vdbtools::farm
