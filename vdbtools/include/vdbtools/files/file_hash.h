// SPDX-License-Identifier: Apache-2.0
/// @file file_hash.h
/// SHA-256 (FIPS 180-4) of inputs, so that a recipe names its files by content. Digests are 64 lower-case hexadecimal
/// digits.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace vdbtools {

std::string sha256Hex(std::string_view bytes);

/// Reads the file in pieces; it need not fit into memory.
/// @throw MissingInputError  there is no such file, it is a directory, or it may not be opened
/// @throw IoError            reading broke off
std::string sha256OfFile(const std::filesystem::path& path);

}  // namespace vdbtools
