// SPDX-License-Identifier: Apache-2.0
#include "formats/vdb_head.h"

#include "vdbtools/base/errors.h"

#include <bit>
#include <cstdint>
#include <cstring>

namespace vdbtools {
namespace {

static_assert(std::endian::native == std::endian::little, "the numbers are read as they lie in the file");

class HeadReader {
 public:
  explicit HeadReader(std::string_view bytes) : mLeft(bytes) {}

  std::string_view bytes(std::size_t count) {
    if (count > mLeft.size()) throw DataError("the VDB ends before its metadata do");
    const std::string_view part = mLeft.substr(0, count);
    mLeft.remove_prefix(count);
    return part;
  }
  std::uint32_t number() {
    std::uint32_t value;
    std::memcpy(&value, bytes(sizeof value).data(), sizeof value);
    return value;
  }
  /// A length and as many bytes.
  std::string_view text() { return bytes(number()); }

 private:
  std::string_view mLeft;
};

}  // namespace

std::map<std::string, std::string> vdbHeadMetadata(std::string_view bytes) {
  constexpr std::string_view kMagic(" BDV\0\0\0\0", 8);
  constexpr std::uint32_t kOldest = 222;         // before, a flag for compression stood in the head
  constexpr std::size_t kIdentifierLength = 36;  // characters
  if (!bytes.starts_with(kMagic)) throw DataError("this is not a VDB file: it does not begin as one does");
  HeadReader reader(bytes.substr(kMagic.size()));
  const std::uint32_t version = reader.number();
  if (version < kOldest)
    throw DataError("the VDB has version " + std::to_string(version) + " of the format, which is too old");
  reader.number();  // of the library, major
  reader.number();  // and minor
  reader.bytes(1);  // whether there are offsets to grids
  reader.bytes(kIdentifierLength);
  std::map<std::string, std::string> metadata;
  const std::uint32_t count = reader.number();
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::string_view name = reader.text(), type = reader.text(), value = reader.text();
    if (type == "string") metadata[std::string(name)] = value;
  }
  return metadata;
}

}  // namespace vdbtools
