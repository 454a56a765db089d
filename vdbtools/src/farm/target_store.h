// SPDX-License-Identifier: Apache-2.0
/// @file target_store.h
/// Distances that the tasks of a plan share: whoever needs them first makes them and leaves them in the plan's folder,
/// DIR/targets, with one band for all tasks of a target. Each task gets those that it would make by itself, to the bit,
/// so that nothing depends on who did, or how wide the band is that is kept.
#pragma once

#include "vdbtools/scene/scene.h"

#include <filesystem>
#include <functional>
#include <set>
#include <string>

namespace vdbtools::farm {

inline constexpr const char* kTargetsName = "targets";

/// By what the distances of a target are kept: the same for all recipes that make them of the same mesh in the same
/// way. "" if they are not kept: those of a VDB, and of a mesh whose SHA-256 the recipe does not have.
std::string targetKey(const TargetOptions& options);

/// Opens targets whose distances are kept in @a folder. A band is made up to 1.4 times as wide as it is wanted, and
/// where that does not suffice for a later task, at least twice as wide again; narrower ones are cut out of it. A file
/// that is broken is made again; where none can be written, each task makes its own.
/// @param keeps  whether anybody else will want the distances of this key, which are written only then
TargetOpener targetsKeptIn(std::filesystem::path folder, std::function<bool(const std::string& key)> keeps);

/// The keys whose distances are in @a folder.
std::set<std::string> keptTargets(const std::filesystem::path& folder);

/// Removes what is kept of these keys, and the folder once it is empty. Whoever reads them meanwhile makes them again.
void removeKeptTargets(const std::filesystem::path& folder, const std::set<std::string>& keys);

}  // namespace vdbtools::farm
