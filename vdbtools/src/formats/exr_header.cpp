// SPDX-License-Identifier: Apache-2.0
#include "formats/exr_header.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

namespace vdbtools {
namespace {

struct Kind {
  std::string_view name;
  std::int64_t size;
};

/// Types with the same number of bytes in every file.
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

/// The rest of a file. Reads beyond its end return 0 and make it invalid.
class Cursor {
 public:
  explicit Cursor(std::string_view bytes) : mLeft(bytes) {}

  std::int64_t left() const { return std::ssize(mLeft); }
  explicit operator bool() const { return mGood; }
  bool atZero() const { return mLeft.starts_with('\0'); }

  /// Little-endian, like all numbers of the format.
  std::int32_t number() {
    const std::string_view bytes = take(4);
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i)
      value |= std::uint32_t{static_cast<std::uint8_t>(bytes[i])} << (8 * i);
    return static_cast<std::int32_t>(value);
  }
  std::string_view text() {
    const std::string_view text = take(static_cast<std::int64_t>(mLeft.find('\0')));
    skip(1);
    return text;
  }
  /// @return whether there are enough bytes
  bool skip(std::int64_t bytes) {
    take(bytes);
    return mGood;
  }

 private:
  std::string_view take(std::int64_t count) {
    mGood = mGood && count >= 0 && count <= left();
    if (!mGood) return {};
    const std::string_view taken = mLeft.substr(0, static_cast<std::size_t>(count));
    mLeft.remove_prefix(taken.size());
    return taken;
  }

  std::string_view mLeft;
  bool mGood = true;
};

/// Names, each with 16 bytes, up to an empty one.
bool skipChannels(Cursor& cursor) {
  while (!cursor.text().empty())
    if (!cursor.skip(16)) return false;
  return bool(cursor);
}

/// @return whether the value matches what readers assume for its type
bool skipValue(Cursor& cursor, std::string_view kind, std::int32_t size) {
  const std::int64_t after = cursor.left() - size;
  if (size < 0 || after < 0) return false;
  const auto fixed =
      std::find_if(kFixedKinds.begin(), kFixedKinds.end(), [&](const Kind& k) { return k.name == kind; });
  if (fixed != kFixedKinds.end()) {
    if (size != fixed->size) return false;
  } else if (kind == "chlist") {
    return skipChannels(cursor) && cursor.left() == after;
  } else if (kind == "preview") {
    const std::int64_t width = cursor.number(), height = cursor.number();
    return width >= 0 && height >= 0 && width * height <= size && 8 + 4 * width * height == size &&
           cursor.skip(size - 8);
  } else if (kind == "stringvector") {
    while (cursor && cursor.left() > after)
      if (!cursor.skip(cursor.number())) return false;
    return cursor && cursor.left() == after;
  } else if (kind == "idmanifest") {
    return false;  // for deep pictures, which are not supported; compressed, so its size says nothing
  }
  return cursor.skip(size);
}

}  // namespace

bool isExrHeaderSound(std::string_view bytes) {
  constexpr std::int32_t kManyParts = 0x1000;
  Cursor cursor(bytes);
  cursor.skip(4);  // the magic number
  const bool manyParts = (cursor.number() & kManyParts) != 0;
  while (cursor) {
    if (cursor.text().empty()) {  // the end of a header; if there may be several, an empty one is the last
      if (cursor && (!manyParts || cursor.atZero())) return true;
      continue;
    }
    const std::string_view kind = cursor.text();
    const std::int32_t size = cursor.number();
    if (!cursor || !skipValue(cursor, kind, size)) return false;
  }
  return false;
}

}  // namespace vdbtools
