// SPDX-License-Identifier: Apache-2.0
/// @file target_store.h
/// Distances that the tasks of a plan share: the first task that needs them computes them and leaves them in the plan's
/// folder, DIR/targets, with one band for all tasks of a target. Each task gets bit for bit the distances that it would
/// compute by itself, so nothing depends on which task computed them, or on the width of the stored band.
#pragma once

#include "vdbtools/scene/scene.h"

#include <filesystem>
#include <functional>
#include <set>
#include <string>

namespace vdbtools::farm {

inline constexpr const char* kTargetsName = "targets";

/// The key under which the distances of a target are stored. It is the same for all recipes that compute them from the
/// same mesh in the same way. "" if they are not stored, i.e. for a VDB, or for a mesh whose SHA-256 the recipe lacks.
std::string targetKey(const TargetOptions& options);

/// Opens targets whose distances are stored in @a folder. A band is made up to 1.4 times as wide as requested and, if
/// that does not suffice for a later task, at least twice as wide again; narrower bands are cut out of it. A broken
/// file is replaced; if none can be written, each task computes its own.
/// @param keeps  whether another task will need the distances of this key; only then they are written
TargetOpener targetsKeptIn(std::filesystem::path folder, std::function<bool(const std::string& key)> keeps);

/// The keys whose distances are in @a folder.
std::set<std::string> keptTargets(const std::filesystem::path& folder);

/// Removes what is stored under these keys, and the folder once it is empty. A task that is reading it meanwhile
/// computes it again.
void removeKeptTargets(const std::filesystem::path& folder, const std::set<std::string>& keys);

}  // namespace vdbtools::farm
