// SPDX-License-Identifier: Apache-2.0
/// @file left_out_text.h
/// The message about points of a target that cannot be used.
#pragma once

#include <map>
#include <string>

namespace cli {

/// A line, or an empty text if no point was left out. @param metadata  the metadata of a job
inline std::string leftOutText(const std::map<std::string, std::string>& metadata) {
  const auto found = metadata.find("julia_points_left_out");
  if (found == metadata.end()) return {};
  if (found->second == "1")
    return "1 point of the target is left out: its coordinates are not finite, and no face uses it\n";
  return found->second +
         " points of the target are left out: their coordinates are not finite, and no face uses them\n";
}

}  // namespace cli
