// SPDX-License-Identifier: Apache-2.0
/// @file united_parts.h
/// Records the PartCounts of a target with its distances.
#pragma once

#include "vdbtools/distance/mesh_to_sdf.h"

#include <map>
#include <string>

namespace vdbtools {

/// Metadata of a grid of distances and of its file, and facts of a job: positive integers. A count of 0 is not
/// recorded.
inline constexpr const char *kUnitedParts = "julia_united_parts", *kHollowsFilled = "julia_hollows_filled",
                            *kHollowsKept = "julia_hollows_kept", *kInnerParts = "julia_inner_parts";
inline constexpr const char* kPartFacts[] = {kUnitedParts, kHollowsFilled, kHollowsKept, kInnerParts};

inline std::map<std::string, std::string> partFacts(const PartCounts& counts, Hollows hollows) {
  std::map<std::string, std::string> facts;
  const auto add = [&facts](const char* name, std::size_t count) {
    if (count > 0) facts[name] = std::to_string(count);
  };
  add(kUnitedParts, counts.intersecting);
  add(hollows == Hollows::Keep ? kHollowsKept : kHollowsFilled, counts.hollows);
  add(kInnerParts, counts.inner);
  return facts;
}

}  // namespace vdbtools
