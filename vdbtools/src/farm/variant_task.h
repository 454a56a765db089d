// SPDX-License-Identifier: Apache-2.0
/// @file variant_task.h
/// Makes one fractal of PlanKind::Frames or PlanKind::Sheet.
#pragma once

#include "vdbtools/farm/task.h"

#include <stdexcept>

namespace vdbtools {

inline TaskCounts makeVariant(const std::filesystem::path&, const Manifest&, std::uint64_t, Monitor&) {
  throw std::logic_error("variants are not made yet");
}

}  // namespace vdbtools
