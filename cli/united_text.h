// SPDX-License-Identifier: Apache-2.0
/// @file united_text.h
/// What to say of a target whose parts run into each other.
#pragma once

#include <map>
#include <string>

namespace cli {

/// A line; empty if no parts do. @param facts  of a job
inline std::string unitedText(const std::map<std::string, std::string>& metadata) {
  const auto found = metadata.find("julia_united_parts");
  if (found == metadata.end()) return {};
  if (found->second == "1") return "the target runs into itself; its outer surface is what counts\n";
  return found->second + " parts of the target run into each other; the outer surface of their union is what counts\n";
}

}  // namespace cli
