// SPDX-License-Identifier: Apache-2.0
#include "picture/png_encoder.h"

#include <png.h>

#include <new>
#include <stdexcept>

namespace vdbtools {
namespace {

constexpr double kMostBytes = 4e9;  ///< libpng counts a picture's bytes in 32 bits

}  // namespace

std::string encodePng(int width, int height, const std::uint8_t* codes, bool alpha) {
  if ((alpha ? 4.0 : 3.0) * width * height > kMostBytes)
    throw std::invalid_argument("a picture of " + std::to_string(width) + " x " + std::to_string(height) +
                                " pixels is too large for a PNG; make it smaller, or write an EXR");
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = alpha ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  // The size is known to fit, so it can only fail for lack of memory.
  if (!png_image_write_to_memory(&image, bytes.data(), &size, 0, codes, 0, nullptr)) throw std::bad_alloc();
  bytes.resize(size);
  return bytes;
}

}  // namespace vdbtools
