// SPDX-License-Identifier: Apache-2.0
#include "picture/png_text.h"

#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <stdexcept>

namespace vdbtools {
namespace {

constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n", kHeader = "IHDR", kText = "tEXt";
/// Sizes of the parts of a chunk: its length, its type, and its checksum after the data.
constexpr std::size_t kLength = 4, kType = 4, kChecksum = 4;

std::string bigEndian(std::uint32_t number) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(number >> shift & 0xff);
  return bytes;
}

std::uint32_t numberAt(std::string_view bytes) {
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < kLength; ++i) number = number << 8 | static_cast<std::uint8_t>(bytes[i]);
  return number;
}

std::uint32_t checksumOf(std::string_view bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

struct Chunk {
  std::string_view type, data;  ///< both empty: there is no chunk, or it is broken
  std::size_t size = 0;         ///< size of the whole chunk
};

Chunk chunkAt(std::string_view bytes) {
  if (bytes.size() < kLength + kType + kChecksum) return {};
  const std::size_t length = numberAt(bytes);
  if (length > bytes.size() - kLength - kType - kChecksum) return {};
  const std::string_view checked = bytes.substr(kLength, kType + length);
  if (numberAt(bytes.substr(kLength + kType + length)) != checksumOf(checked)) return {};
  return {checked.substr(0, kType), checked.substr(kType), kLength + kType + length + kChecksum};
}

}  // namespace

std::string withPngText(std::string_view png, std::string_view key, std::string_view text) {
  const Chunk header = png.starts_with(kSignature) ? chunkAt(png.substr(kSignature.size())) : Chunk();
  if (header.type != kHeader) throw std::invalid_argument("a text is to go into bytes that are no PNG; give it a PNG");
  const std::string checked = std::string(kText) + std::string(key) + '\0' + std::string(text);
  const std::size_t end = kSignature.size() + header.size;
  return std::string(png.substr(0, end)) + bigEndian(static_cast<std::uint32_t>(checked.size() - kType)) + checked +
         bigEndian(checksumOf(checked)) + std::string(png.substr(end));
}

std::string pngText(std::string_view png, std::string_view key) {
  if (!png.starts_with(kSignature)) return {};
  png.remove_prefix(kSignature.size());
  for (Chunk chunk = chunkAt(png); chunk.size != 0; chunk = chunkAt(png)) {
    const std::string_view data = chunk.data;
    if (chunk.type == kText && data.size() > key.size() && data.starts_with(key) && data[key.size()] == '\0')
      return std::string(data.substr(key.size() + 1));
    png.remove_prefix(chunk.size);
  }
  return {};
}

}  // namespace vdbtools
