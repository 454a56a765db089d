// SPDX-License-Identifier: Apache-2.0
/// @file file_hash.h
/// SHA-256 (FIPS 180-4) of inputs, by which a recipe identifies its files. Digests are 64 lower-case hexadecimal
/// digits.
#pragma once

#include <filesystem>
#include <memory>
#include <ostream>
#include <string>
#include <string_view>

namespace vdbtools {

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

}  // namespace vdbtools
