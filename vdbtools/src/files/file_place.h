// SPDX-License-Identifier: Apache-2.0
/// @file file_place.h
/// Resolves file names.
#pragma once

#include <filesystem>
#include <system_error>

namespace vdbtools {

/// Follows the symbolic links at the end of a path, which need not lead to anything that exists.
/// @param error  set if they cannot be followed
std::filesystem::path followLinks(const std::filesystem::path& path, std::error_code& error);

/// The canonical spelling of a name, with all links followed. Parts that do not exist are kept as they are.
std::filesystem::path placeOfFile(const std::filesystem::path& file);

/// Whether the file exists and is a device, a pipe, a folder or the like.
bool isNoOrdinaryFile(const std::filesystem::path& file);

}  // namespace vdbtools
