// SPDX-License-Identifier: Apache-2.0
/// @file file_place.h
/// Where a name leads to.
#pragma once

#include <filesystem>
#include <system_error>

namespace vdbtools {

/// What a name leads to through the links that it names itself, which need not lead to anything that exists.
/// @param error  set where they cannot be followed
std::filesystem::path followLinks(const std::filesystem::path& path, std::error_code& error);

/// The one spelling of a name, once all links in it are followed. What does not exist is spelled as it stands.
std::filesystem::path placeOfFile(const std::filesystem::path& file);

/// Whether it is there and a device, a pipe, a folder or the like.
bool isNoOrdinaryFile(const std::filesystem::path& file);

}  // namespace vdbtools
