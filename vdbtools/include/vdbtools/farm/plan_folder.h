// SPDX-License-Identifier: Apache-2.0
/// @file plan_folder.h
/// The folder of a new plan.
#pragma once

#include "vdbtools/farm/manifest.h"

#include <filesystem>

namespace vdbtools::farm {

/// Checks that a plan can be written there: the folder does not exist, or is empty and writable. writePlan() creates
/// it; whatever this check creates is removed again.
/// @throw CreateError
void requireNewPlanFolder(const std::filesystem::path& folder);

/// Creates the folder if necessary and writes the manifest, the last file of a plan. If that fails, a folder that was
/// created for it is removed again, together with what was prepared for its tasks.
/// @throw CreateError  also if another plan was created there meanwhile
/// @throw IoError
void writePlan(const std::filesystem::path& folder, const Manifest& manifest);

}  // namespace vdbtools::farm
