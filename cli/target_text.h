// SPDX-License-Identifier: Apache-2.0
/// @file target_text.h
/// Reports to the user how the target was read.
#pragma once

#include <map>
#include <string>

namespace cli {

/// Prints lines about points that cannot be used, about parts that intersect or enclose each other, and about a VDB
/// whose grid is no signed distance in cubes. A line that holds for several frames or cells is printed once.
/// @param metadata  the metadata of a job
void tellTarget(const std::map<std::string, std::string>& metadata);

}  // namespace cli
