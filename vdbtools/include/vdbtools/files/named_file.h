// SPDX-License-Identifier: Apache-2.0
/// @file named_file.h
/// Files that a recipe names, and the check that their content is the same as when the recipe was made.
#pragma once

#include <compare>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace vdbtools {

struct NamedFile {
  std::filesystem::path path;
  std::string recordedAs;    ///< the recipe's entry for its SHA-256, such as "source-sha256"
  std::string expectedHash;  ///< the value of that entry; empty if the recipe has none

  auto operator<=>(const NamedFile&) const = default;
};

/// Returns the SHA-256 of each file by the name under which it is recorded; the hashes of several files under one name
/// are joined by commas in their order.
/// @throw DataError          a file is not the one with which the recipe was made
/// @throw MissingInputError, IoError  as sha256OfFile()
/// @throw MemoryError        a file is larger than the remaining memory
std::map<std::string, std::string> verifiedHashes(std::span<const NamedFile> files);

}  // namespace vdbtools
