// SPDX-License-Identifier: Apache-2.0
#include "formats/png_decoder.h"

#include <png.h>

#include <bit>
#include <csetjmp>
#include <cstdint>
#include <cstring>
#include <limits>
#include <new>
#include <vector>

namespace vdbtools {
namespace {

/// The source of bytes for libpng, and the first error that it found. Nothing in here may throw: libpng is written in
/// C.
struct PngSource {
  std::string_view bytes;
  std::size_t at = 0;
  char error[256] = {};
};

void readBytes(png_structp png, png_bytep to, std::size_t size) {
  auto& source = *static_cast<PngSource*>(png_get_io_ptr(png));
  if (size > source.bytes.size() - source.at) png_error(png, "the file ends too early");
  std::memcpy(to, source.bytes.data() + source.at, size);
  source.at += size;
}

[[noreturn]] void keepError(png_structp png, png_const_charp text) {
  auto& source = *static_cast<PngSource*>(png_get_error_ptr(png));
  std::strncpy(source.error, text, sizeof source.error - 1);
  png_longjmp(png, 1);
}

/// Ignores warnings, e.g. about an unused colour profile.
void dropWarning(png_structp, png_const_charp) {}

/// libpng's state. Its functions return by longjmp(), past which no object may need to be destroyed; the functions
/// below have no such objects.
class PngReader {
 public:
  explicit PngReader(std::string_view bytes) : mSource{bytes} {
    mPng = png_create_read_struct(PNG_LIBPNG_VER_STRING, &mSource, keepError, dropWarning);
    mInfo = mPng ? png_create_info_struct(mPng) : nullptr;
    if (mInfo) png_set_read_fn(mPng, &mSource, readBytes);
  }
  ~PngReader() { png_destroy_read_struct(&mPng, &mInfo, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  /// Whether there was enough memory to begin.
  bool ready() const { return mInfo != nullptr; }

  /// Sets the output to bytes, or 16-bit numbers in the byte order of this machine, with one to four channels.
  bool readHead() {
    if (setjmp(png_jmpbuf(mPng)) != 0) return false;
    png_read_info(mPng, mInfo);
    png_set_expand(mPng);
    if constexpr (std::endian::native == std::endian::little) png_set_swap(mPng);
    mPasses = png_set_interlace_handling(mPng);
    png_read_update_info(mPng, mInfo);
    return true;
  }

  int width() const { return static_cast<int>(png_get_image_width(mPng, mInfo)); }
  int height() const { return static_cast<int>(png_get_image_height(mPng, mInfo)); }
  int channels() const { return png_get_channels(mPng, mInfo); }
  int bytesOfValue() const { return png_get_bit_depth(mPng, mInfo) == 16 ? 2 : 1; }
  bool hasAlpha() const { return (png_get_color_type(mPng, mInfo) & PNG_COLOR_MASK_ALPHA) != 0; }
  std::size_t bytesOfRow() const { return png_get_rowbytes(mPng, mInfo); }

  /// @param rows  room for height() rows
  bool readRows(std::uint8_t* rows) {
    if (setjmp(png_jmpbuf(mPng)) != 0) return false;
    const std::size_t stride = bytesOfRow();
    const int last = height();
    for (int pass = 0; pass < mPasses; ++pass)
      for (int y = 0; y < last; ++y) png_read_row(mPng, rows + static_cast<std::size_t>(y) * stride, nullptr);
    return true;
  }

  std::string error() const { return mSource.error; }

 private:
  PngSource mSource;
  png_structp mPng = nullptr;
  png_infop mInfo = nullptr;
  int mPasses = 1;
};

template <class Code>
void toShares(const std::vector<std::uint8_t>& rows, std::vector<float>& values) {
  constexpr float kScale = 1.0f / static_cast<float>(std::numeric_limits<Code>::max());
  for (std::size_t i = 0; i < values.size(); ++i) {
    Code code;
    std::memcpy(&code, rows.data() + i * sizeof code, sizeof code);
    values[i] = static_cast<float>(code) * kScale;
  }
}

}  // namespace

bool decodePng(std::string_view bytes, double room, DecodedImage& image, std::string& reason) {
  PngReader reader(bytes);
  if (!reader.ready()) throw std::bad_alloc();
  if (!reader.readHead()) {
    reason = reader.error();
    return false;
  }
  image.width = reader.width();
  image.height = reader.height();
  image.channels = reader.channels();
  image.alphaChannel = reader.hasAlpha() ? image.channels - 1 : -1;
  const double rowBytes = static_cast<double>(reader.bytesOfRow()) * image.height;
  const double values = static_cast<double>(image.width) * image.height * image.channels;
  if (values > static_cast<double>(kMostPictureValues)) {
    reason = unusableSize(image.width, image.height, image.channels);
    return false;
  }
  if (values * sizeof(float) + rowBytes > room) {
    reason.clear();
    return false;
  }
  std::vector<std::uint8_t> rows(reader.bytesOfRow() * static_cast<std::size_t>(image.height));
  if (!reader.readRows(rows.data())) {
    reason = reader.error();
    return false;
  }
  image.values.resize(static_cast<std::size_t>(values));
  if (reader.bytesOfValue() == 2)
    toShares<std::uint16_t>(rows, image.values);
  else
    toShares<std::uint8_t>(rows, image.values);
  return true;
}

}  // namespace vdbtools
