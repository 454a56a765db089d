// SPDX-License-Identifier: Apache-2.0
/// @file tile_task.h
/// Makes one tile of PlanKind::Tiles.
#pragma once

#include "vdbtools/farm/task.h"

#include <stdexcept>

namespace vdbtools {

inline TaskCounts makeTile(const std::filesystem::path&, const Manifest&, std::uint64_t, Monitor&) {
  throw std::logic_error("tiles are not made yet");
}

}  // namespace vdbtools
