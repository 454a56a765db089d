// SPDX-License-Identifier: Apache-2.0
/// @file standard_streams.h
/// The standard input and the standard output in the place of a file, under the name "-".
#pragma once

#include <filesystem>

namespace vdbtools {

inline constexpr const char* kStandardStream = "-";

/// Stores the standard input, up to its end, in an unnamed temporary file. From then on the functions of file_bytes.h
/// and those that hash files read this file under the name "-", any number of times. Before the first call, "-" is a
/// name like any other. Further calls do nothing. Call it before any other thread reads files.
/// @throw MissingInputError  the standard input is closed, a folder, or a terminal, at which nobody types a mesh
/// @throw CreateError        no temporary file can be created
/// @throw IoError            reading or storing failed midway
void takeStandardInput();

/// Whether @a path is "-" and the standard input was taken.
bool isStandardInput(const std::filesystem::path& path);

/// The path by which the system opens a file: @a path itself, or that of the stored standard input.
std::filesystem::path pathToOpen(const std::filesystem::path& path);

}  // namespace vdbtools
