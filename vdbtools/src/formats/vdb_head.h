// SPDX-License-Identifier: Apache-2.0
/// @file vdb_head.h
/// The metadata of a VDB from bytes that nobody vouches for. OpenVDB trusts the sizes in a file; this reader checks
/// each one against the bytes that are there, and allocates nothing that they do not hold.
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace vdbtools {

/// The text entries of the metadata of the file, not of its grids.
/// @param bytes  of the file's beginning, at least as far as the metadata go
/// @throw DataError  it is not a VDB, one of a version before 222 (2013), or the bytes end before the metadata do
std::map<std::string, std::string> vdbHeadMetadata(std::string_view bytes);

}  // namespace vdbtools
