// SPDX-License-Identifier: Apache-2.0
#include "formats/vdb_values.h"

#include <openvdb/io/Compression.h>

#include <algorithm>
#include <limits>
#include <sstream>

namespace vdbtools {
namespace {

using namespace openvdb::io;

/// The number at an offset into bytes that are known to contain it.
std::uint32_t numberAt(std::string_view bytes, std::size_t offset) {
  std::uint32_t value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

}  // namespace

std::size_t countOn(std::string_view mask) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < mask.size(); i += sizeof(std::uint64_t)) {
    std::uint64_t word;
    std::memcpy(&word, mask.data() + i, sizeof word);
    count += static_cast<std::size_t>(std::popcount(word));
  }
  return count;
}

VdbValueWalk::VdbValueWalk(VdbCursor& cursor, const VdbValueType& type, const VdbStorage& storage)
    : mCursor(cursor), mType(type), mStorage(storage) {
  constexpr std::uint32_t kKnown = COMPRESS_ZIP | COMPRESS_ACTIVE_MASK | COMPRESS_BLOSC;
  if ((storage.compression & ~kKnown) != 0)
    cursor.refuse("is compressed in a way that is not known, " + std::to_string(storage.compression));
}

void VdbValueWalk::node(std::string_view active, std::size_t count, Payload payload) {
  const auto kind = mCursor.number<std::int8_t>();
  if (kind < NO_MASK_OR_INACTIVE_VALS || kind > NO_MASK_AND_ALL_VALS)
    mCursor.refuse("has a node whose inactive values are stored in a way that is not known, " + std::to_string(kind));
  if (kind == NO_MASK_AND_ONE_INACTIVE_VAL || kind == MASK_AND_ONE_INACTIVE_VAL || kind == MASK_AND_TWO_INACTIVE_VALS)
    value();
  if (kind == MASK_AND_TWO_INACTIVE_VALS) value();
  if (kind == MASK_AND_NO_INACTIVE_VALS || kind == MASK_AND_ONE_INACTIVE_VAL || kind == MASK_AND_TWO_INACTIVE_VALS)
    mCursor.bytes(active.size());
  const bool activeOnly = (mStorage.compression & COMPRESS_ACTIVE_MASK) != 0 && kind != NO_MASK_AND_ALL_VALS;
  stored(activeOnly ? countOn(active) : count, payload);
}

void VdbValueWalk::background() {
  const std::string_view bytes = mCursor.bytes(mType.size);
  requireTruth(bytes);
  if (!mType.isInteger()) return;
  const auto requireNegative = [&](auto number) {
    for (std::size_t i = 0; i + sizeof number <= bytes.size(); i += sizeof number) {
      std::memcpy(&number, bytes.data() + i, sizeof number);
      if (number == std::numeric_limits<decltype(number)>::min())
        mCursor.refuse("has a background of " + std::to_string(number) + ", which has no negative");
    }
  };
  if (mType.size == sizeof(std::int64_t))
    requireNegative(std::int64_t{});
  else
    requireNegative(std::int32_t{});
}

void VdbValueWalk::stored(std::size_t count, Payload payload) {
  const bool half = mStorage.half && mType.isReal();
  if (half && count == 0) return;  // OpenVDB writes nothing in this case
  const std::size_t size = count * (half ? mType.halfSize : mType.size);
  const bool blosc = (mStorage.compression & COMPRESS_BLOSC) != 0;
  if (!blosc && (mStorage.compression & COMPRESS_ZIP) == 0) return requireTruth(mCursor.bytes(size));
  const auto chunkSize = mCursor.number<std::int64_t>();
  if (chunkSize <= 0) {
    // A negative sign means that compression did not help.
    if (chunkSize != -static_cast<std::int64_t>(size))
      mCursor.refuse("has a node with values of " + std::to_string(chunkSize) + " bytes where " + std::to_string(size) +
                     " are needed");
    return requireTruth(mCursor.bytes(size));
  }
  const std::string_view chunk = mCursor.bytes(static_cast<std::uint64_t>(chunkSize));
  if (blosc) requireBlosc(chunk, size);
  if (payload == Payload::Decode) requireTruth(decoded(chunk, size));
}

void VdbValueWalk::requireTruth(std::string_view values) const {
  if (mType.truth && std::any_of(values.begin(), values.end(), [](char c) { return c != 0 && c != 1; }))
    mCursor.refuse("has a value that is neither true nor false");
}

/// Blosc's decompressor knows the size of its output, but takes that of its input from a header in the input. This
/// function checks that header, and the following table of block offsets. The blocks themselves are LZ4, whose
/// decompressor knows both sizes; OpenVDB has never written any other compression.
void VdbValueWalk::requireBlosc(std::string_view chunk, std::size_t size) const {
  constexpr std::size_t kHeader = 16, kWord = sizeof(std::uint32_t);
  constexpr unsigned kFormat = 2, kMemcpyed = 0x2, kBitShuffle = 0x4, kReserved = 0x8, kCodecShift = 5, kLz4 = 1;
  const auto require = [&](bool right) {
    if (!right) mCursor.refuse("has a node whose compressed values are broken");
  };
  require(chunk.size() >= kHeader);
  const auto byteAt = [&](std::size_t i) { return static_cast<unsigned char>(chunk[i]); };
  const unsigned format = byteAt(0), flags = byteAt(2), typeSize = byteAt(3);
  const std::uint32_t decodedSize = numberAt(chunk, 4), blockSize = numberAt(chunk, 8), chunkSize = numberAt(chunk, 12);
  require(format == kFormat && decodedSize == size && chunkSize == chunk.size());
  require((flags & (kReserved | kBitShuffle)) == 0);
  if (size == 0) return;
  require(typeSize > 0 && blockSize > 0 && blockSize <= decodedSize);
  if ((flags & kMemcpyed) != 0) return require(chunk.size() == kHeader + size);
  require(flags >> kCodecShift == kLz4);
  const std::size_t blocks = (size + blockSize - 1) / blockSize;
  require(blocks <= (chunk.size() - kHeader) / kWord);
  const std::size_t first = kHeader + blocks * kWord;
  for (std::size_t block = 0; block < blocks; ++block) {
    const std::size_t at = numberAt(chunk, kHeader + block * kWord);
    require(at >= first && at <= chunk.size() - kWord);
  }
}

std::string VdbValueWalk::decoded(std::string_view chunk, std::size_t size) const {
  const auto chunkSize = static_cast<std::int64_t>(chunk.size());
  std::string framed(reinterpret_cast<const char*>(&chunkSize), sizeof chunkSize);
  framed += chunk;
  std::istringstream stream(framed, std::ios::binary);
  std::string values(size, '\0');
  try {
    if ((mStorage.compression & COMPRESS_BLOSC) != 0)
      bloscFromStream(stream, values.data(), size);
    else
      unzipFromStream(stream, values.data(), size);
  } catch (const openvdb::Exception&) {
    mCursor.refuse("has a node whose compressed values are broken");
  }
  return values;
}

}  // namespace vdbtools
