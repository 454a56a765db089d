// SPDX-License-Identifier: Apache-2.0
/// @file named_file.h
/// Files that a recipe names, and the proof that they still hold what they held when the recipe was made.
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
  std::string expectedHash;  ///< what that entry says; empty if the recipe has none

  auto operator<=>(const NamedFile&) const = default;
};

/// The SHA-256 of each file by the name that it is recorded under; of several files under one name, joined by commas in
/// their order.
/// @throw DataError          a file is not the one that the recipe was made with
/// @throw MissingInputError, IoError  as sha256OfFile()
/// @throw MemoryError        a file is larger than what is left of the memory
std::map<std::string, std::string> verifiedHashes(std::span<const NamedFile> files);

}  // namespace vdbtools
