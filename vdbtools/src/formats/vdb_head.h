// SPDX-License-Identifier: Apache-2.0
/// @file vdb_head.h
/// The head of a VDB and its metadata, from bytes that nobody vouches for. OpenVDB trusts the sizes in a file; these
/// readers check each one against the bytes that are there, and allocate nothing that they do not hold.
#pragma once

#include "formats/vdb_cursor.h"

#include <map>
#include <string>
#include <string_view>

namespace vdbtools {

struct VdbHead {
  std::uint32_t version = 0;  ///< of the format, 222 to 224
  bool hasOffsets = false;    ///< each grid says where it ends
};

/// What comes before the metadata. The cursor is at the beginning of the bytes.
/// @throw DataError  it is not a VDB, one of a version before 222 (2013) or one that OpenVDB does not know yet, or the
///                   identifier is none
VdbHead readVdbHead(VdbCursor& cursor);

/// One entry of metadata.
struct VdbMetaEntry {
  std::string_view name, type, value;
};

/// @throw VdbEnds  the bytes end within it
VdbMetaEntry readVdbMetaEntry(VdbCursor& cursor);

/// The text entries of the metadata of the file, not of its grids.
/// @param bytes  of the file's beginning, at least as far as the metadata go
/// @throw DataError  as readVdbHead(), or the bytes end before the metadata do
std::map<std::string, std::string> vdbHeadMetadata(std::string_view bytes);

}  // namespace vdbtools
