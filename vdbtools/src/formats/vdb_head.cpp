// SPDX-License-Identifier: Apache-2.0
#include "formats/vdb_head.h"

namespace vdbtools {
namespace {

constexpr std::string_view kMagic(" BDV\0\0\0\0", 8);
constexpr std::uint32_t kOldest = 222;  // earlier heads contained a compression flag
constexpr std::uint32_t kNewest = 225;  // of OpenVDB 13; it has grids of another type more than 224, that of OpenVDB 10

constexpr bool isHexDigit(char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F'); }

/// "xxxxxxxx-xxxx-xxxx-xxxx-xxxxxxxxxxxx"
bool isIdentifier(std::string_view text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool dash = i == 8 || i == 13 || i == 18 || i == 23;
    if (dash ? text[i] != '-' : !isHexDigit(text[i])) return false;
  }
  return true;
}

}  // namespace

VdbHead readVdbHead(VdbCursor& cursor) {
  constexpr std::size_t kIdentifierLength = 36;  // characters
  cursor.enter("its head");
  if (cursor.left() < kMagic.size() || cursor.bytes(kMagic.size()) != kMagic)
    throw DataError("this is not a VDB file: it does not begin as one does");
  VdbHead head;
  head.version = cursor.number<std::uint32_t>();
  if (head.version < kOldest)
    throw DataError("the VDB has version " + std::to_string(head.version) + " of the format, which is too old");
  if (head.version > kNewest)
    throw DataError("the VDB has version " + std::to_string(head.version) + " of the format; the newest known is " +
                    std::to_string(kNewest));
  cursor.number<std::uint32_t>();  // major version of the library
  cursor.number<std::uint32_t>();  // minor version
  head.hasOffsets = cursor.number<std::uint8_t>() != 0;
  // OpenVDB would skip white space before an identifier, and continue reading at a different position.
  if (!isIdentifier(cursor.bytes(kIdentifierLength))) cursor.refuse("holds no identifier");
  return head;
}

VdbMetaEntry readVdbMetaEntry(VdbCursor& cursor) {
  VdbMetaEntry entry;
  entry.name = cursor.text();
  entry.type = cursor.text();
  entry.value = cursor.text();
  return entry;
}

std::map<std::string, std::string> vdbHeadMetadata(std::string_view bytes) {
  VdbCursor cursor(bytes);
  try {
    readVdbHead(cursor);
    std::map<std::string, std::string> metadata;
    const auto count = cursor.number<std::uint32_t>();
    for (std::uint32_t i = 0; i < count; ++i) {
      const VdbMetaEntry entry = readVdbMetaEntry(cursor);
      if (entry.type == "string") metadata[std::string(entry.name)] = entry.value;
    }
    return metadata;
  } catch (const VdbEnds&) {
    throw DataError("the VDB ends before its metadata do");
  }
}

}  // namespace vdbtools
