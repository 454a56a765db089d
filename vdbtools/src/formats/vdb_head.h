// SPDX-License-Identifier: Apache-2.0
/// @file vdb_head.h
/// Reads the head of a VDB and its metadata from untrusted bytes. OpenVDB trusts the sizes in a file; these readers
/// check each one against the available bytes, and allocate nothing beyond these.
#pragma once

#include "formats/vdb_cursor.h"

#include <map>
#include <string>
#include <string_view>

namespace vdbtools {

struct VdbHead {
  std::uint32_t version = 0;  ///< of the format, 222 to 225
  bool hasOffsets = false;    ///< whether each grid states where it ends
};

/// Reads what precedes the metadata. The cursor must be at the beginning of the bytes.
/// @throw DataError  the bytes are not a VDB, the version is before 222 (2013) or unknown to OpenVDB, or the identifier
///                   is invalid
VdbHead readVdbHead(VdbCursor& cursor);

/// One entry of metadata.
struct VdbMetaEntry {
  std::string_view name, type, value;
};

/// @throw VdbEnds  the bytes end within the entry
VdbMetaEntry readVdbMetaEntry(VdbCursor& cursor);

/// The text entries of the metadata of the file, not of its grids.
/// @param bytes  the beginning of the file, at least up to the end of the metadata
/// @throw DataError  as readVdbHead(), or the bytes end before the metadata do
std::map<std::string, std::string> vdbHeadMetadata(std::string_view bytes);

}  // namespace vdbtools
