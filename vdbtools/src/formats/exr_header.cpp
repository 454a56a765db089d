// SPDX-License-Identifier: Apache-2.0
#include "formats/exr_header.h"

#include "vdbtools/files/file_bytes.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>

namespace vdbtools {
namespace {

struct Kind {
  std::string_view name;
  std::int64_t size;
};

/// Those that have the same number of bytes in every file.
constexpr std::array kFixedKinds = {Kind{"box2i", 16},
                                    Kind{"box2f", 16},
                                    Kind{"chromaticities", 32},
                                    Kind{"compression", 1},
                                    Kind{"deepImageState", 1},
                                    Kind{"double", 8},
                                    Kind{"envmap", 1},
                                    Kind{"float", 4},
                                    Kind{"int", 4},
                                    Kind{"keycode", 28},
                                    Kind{"lineOrder", 1},
                                    Kind{"m33f", 36},
                                    Kind{"m33d", 72},
                                    Kind{"m44f", 64},
                                    Kind{"m44d", 128},
                                    Kind{"rational", 8},
                                    Kind{"tiledesc", 9},
                                    Kind{"timecode", 8},
                                    Kind{"v2i", 8},
                                    Kind{"v2f", 8},
                                    Kind{"v2d", 16},
                                    Kind{"v3i", 12},
                                    Kind{"v3f", 12},
                                    Kind{"v3d", 24}};

/// A place in a file that never lies behind its end.
class Cursor {
 public:
  explicit Cursor(const std::filesystem::path& path) : mStream(openToRead(path)) {
    mSize = mStream.seekg(0, std::ios::end).tellg();
    mStream.seekg(0);
  }

  std::int64_t position() { return mStream.tellg(); }
  std::int64_t left() { return mSize - mStream.tellg(); }
  explicit operator bool() const { return bool(mStream); }

  std::uint8_t byte() { return static_cast<std::uint8_t>(mStream.get()); }
  /// Little-endian, as all numbers of the format.
  std::int32_t number() {
    std::uint32_t value = 0;
    for (int i = 0; i < 4; ++i) value |= std::uint32_t{byte()} << (8 * i);
    return static_cast<std::int32_t>(value);
  }
  std::string text() {
    std::string text;
    std::getline(mStream, text, '\0');
    if (mStream.eof()) mStream.setstate(std::ios::failbit);
    return text;
  }
  /// @return whether there are so many
  bool skip(std::int64_t bytes) {
    return mStream && bytes >= 0 && bytes <= left() && mStream.seekg(bytes, std::ios::cur);
  }
  bool atZero() { return mStream.peek() == 0; }

 private:
  std::ifstream mStream;
  std::int64_t mSize = 0;
};

/// Names, each with 16 bytes, up to an empty one.
bool skipChannels(Cursor& cursor) {
  while (!cursor.text().empty())
    if (!cursor.skip(16)) return false;
  return bool(cursor);
}

/// @return whether the value is what readers of its kind take it for
bool skipValue(Cursor& cursor, const std::string& kind, std::int32_t size) {
  const std::int64_t end = cursor.position() + size;
  if (size < 0 || size > cursor.left()) return false;
  const auto fixed =
      std::find_if(kFixedKinds.begin(), kFixedKinds.end(), [&](const Kind& k) { return k.name == kind; });
  if (fixed != kFixedKinds.end()) {
    if (size != fixed->size) return false;
  } else if (kind == "chlist") {
    return skipChannels(cursor) && cursor.position() == end;
  } else if (kind == "preview") {
    const std::int64_t width = cursor.number(), height = cursor.number();
    return width >= 0 && height >= 0 && width * height <= size && 8 + 4 * width * height == size &&
           cursor.skip(size - 8);
  } else if (kind == "stringvector") {
    while (cursor && cursor.position() < end)
      if (!cursor.skip(cursor.number())) return false;
    return cursor && cursor.position() == end;
  } else if (kind == "idmanifest") {
    return false;  // of deep pictures, which have no use here; compressed, so that its size says nothing
  }
  return cursor.skip(size);
}

}  // namespace

bool isExrHeaderSound(const std::filesystem::path& path) {
  constexpr std::int32_t kMagic = 20000630;
  constexpr std::int32_t kManyParts = 0x1000;
  Cursor cursor(path);
  if (cursor.number() != kMagic) return true;
  const bool manyParts = (cursor.number() & kManyParts) != 0;
  while (cursor) {
    if (cursor.text().empty()) {  // the end of a header; where there may be several, an empty one is the last
      if (cursor && (!manyParts || cursor.atZero())) return true;
      continue;
    }
    const std::string kind = cursor.text();
    const std::int32_t size = cursor.number();
    if (!cursor || !skipValue(cursor, kind, size)) return false;
  }
  return false;
}

}  // namespace vdbtools
