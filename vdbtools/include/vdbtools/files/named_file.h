// SPDX-License-Identifier: Apache-2.0
/// @file named_file.h
/// Files that a recipe names, and the check that their content is the same as when the recipe was made.
#pragma once

#include <compare>
#include <filesystem>
#include <map>
#include <memory>
#include <ostream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vdbtools {

// SHA-256 (FIPS 180-4) of inputs, by which a recipe identifies its files. Digests are 64 lower-case hexadecimal
// digits.

std::string sha256Hex(std::string_view bytes);

/// Reads the file in pieces, so it need not fit into memory.
/// @throw MissingInputError  the file does not exist, is a directory, or may not be opened
/// @throw IoError            reading failed midway
std::string sha256OfFile(const std::filesystem::path& path);

/// A stream that hashes what is written to it and keeps nothing else.
class HashStream final : public std::ostream {
 public:
  HashStream();
  ~HashStream() override;

  /// The SHA-256 of everything that was written. Call it once, at the end.
  std::string sha256Hex();

 private:
  class Buffer;
  std::unique_ptr<Buffer> mBuffer;
};

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
