// SPDX-License-Identifier: Apache-2.0
/// @file target_store.h
/// Distances that the tasks of a plan share: whoever needs them first makes them and leaves them in the plan's folder,
/// DIR/targets. They are those that each task would make, so that nothing depends on who did.
#pragma once

#include "vdbtools/job/scene.h"

#include <filesystem>

namespace vdbtools {

inline constexpr const char* kTargetsName = "targets";

/// Opens targets whose distances are kept in @a folder. A mesh whose SHA-256 the recipe has is kept, and others are
/// not. Bands are made up to 1.4 times as wide as they are wanted, so that frames of different widths find them. A file
/// that is broken is made again; where none can be written, each task makes its own.
TargetOpener targetsKeptIn(std::filesystem::path folder);

}  // namespace vdbtools
