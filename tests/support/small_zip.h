// SPDX-License-Identifier: Apache-2.0
/// @file small_zip.h
/// Zips of a few files, for tests of what reads them.
#pragma once

#include <zlib.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace small_zip {

inline void append(std::string& bytes, std::uint32_t value, int size) {
  for (int i = 0; i < size; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xff);
}

inline std::string deflated(std::string_view text) {
  z_stream stream{};
  constexpr int kRaw = -15, kMemory = 8;
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, kRaw, kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("no deflate");
  std::string bytes(deflateBound(&stream, text.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_out = static_cast<uInt>(bytes.size());
  deflate(&stream, Z_FINISH);
  bytes.resize(stream.total_out);
  deflateEnd(&stream);
  return bytes;
}

/// @param files  names and contents
inline std::string zipOf(const std::vector<std::pair<std::string, std::string>>& files, bool isDeflated = false) {
  std::string bytes, directory;
  for (const auto& [name, content] : files) {
    const std::string packed = isDeflated ? deflated(content) : content;
    std::string head;
    append(head, 20, 2);  // the version that is needed
    append(head, 0, 2);
    append(head, isDeflated ? 8 : 0, 2);
    append(head, 0x00210000, 4);  // 1 January 1980
    append(head,
           static_cast<std::uint32_t>(
               crc32(0, reinterpret_cast<const Bytef*>(content.data()), static_cast<uInt>(content.size()))),
           4);
    append(head, static_cast<std::uint32_t>(packed.size()), 4);
    append(head, static_cast<std::uint32_t>(content.size()), 4);
    append(head, static_cast<std::uint32_t>(name.size()), 2);
    append(head, 0, 2);
    directory += "PK\1\2";
    append(directory, 20, 2);
    directory += head;
    append(directory, 0, 2);  // comment
    append(directory, 0, 4);
    append(directory, 0, 4);
    append(directory, static_cast<std::uint32_t>(bytes.size()), 4);
    directory += name;
    bytes += "PK\3\4" + head + name + packed;
  }
  const auto start = static_cast<std::uint32_t>(bytes.size());
  bytes += directory + "PK\5\6";
  append(bytes, 0, 4);
  append(bytes, static_cast<std::uint32_t>(files.size()), 2);
  append(bytes, static_cast<std::uint32_t>(files.size()), 2);
  append(bytes, static_cast<std::uint32_t>(directory.size()), 4);
  append(bytes, start, 4);
  append(bytes, 0, 2);
  return bytes;
}

/// The parts of a 3MF whose model is the given XML, before others.
inline std::vector<std::pair<std::string, std::string>> partsOf3mf(const std::string& model) {
  return {{"_rels/.rels",
           "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship "
           "Id=\"r\" Target=\"/3D/3dmodel.model\" "
           "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>"},
          {"3D/3dmodel.model", model}};
}

}  // namespace small_zip
