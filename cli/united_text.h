// SPDX-License-Identifier: Apache-2.0
/// @file united_text.h
/// The message about a target whose parts intersect each other.
#pragma once

#include <map>
#include <string>

namespace cli {

/// A line, or an empty text if no parts intersect. @param metadata  the metadata of a job
inline std::string unitedText(const std::map<std::string, std::string>& metadata) {
  const auto found = metadata.find("julia_united_parts");
  if (found == metadata.end()) return {};
  if (found->second == "1") return "the target runs into itself; its outer surface is what counts\n";
  return found->second + " parts of the target run into each other; the outer surface of their union is what counts\n";
}

}  // namespace cli
