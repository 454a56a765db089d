// SPDX-License-Identifier: Apache-2.0
/// @file merge_request.h
/// The files that 'merge' makes from a plan, and that 'submit' asks it for.
#pragma once

#include "options.h"

#include "vdbtools/farm/merge.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace cli {

struct MergeRequest {
  vdbtools::farm::MergeOptions files;
  std::optional<std::filesystem::path>
      index;  ///< instead of these: the tiles as files of their own, and this list of them
  std::optional<std::filesystem::path> counts;  ///< instead, for a plan that counts: the sums

  bool empty() const { return !index && !counts && !files.grids && !files.mesh; }
};

/// -o, --mesh, --index, --counts and --most-points.
void addMergeOptions(CommandLine& line);

/// @throw std::invalid_argument  a name of another kind of file, or files that exclude each other
MergeRequest parseMergeRequest(const CommandLine& line);

/// Refuses at once what merging would refuse once all tasks are done.
/// @throw as vdbtools::farm::requireMergeable()
void requireMergeable(const std::filesystem::path& folder, const vdbtools::farm::Manifest& manifest,
                      const MergeRequest& request);

/// The words for 'juliavdb merge DIR', with file names that are valid in any folder.
std::vector<std::string> mergeWords(const CommandLine& line);

}  // namespace cli
