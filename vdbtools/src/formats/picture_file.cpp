// SPDX-License-Identifier: Apache-2.0
#include "formats/picture_file.h"

#include "files/image_module.h"
#include "formats/exr_header.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/files/file_bytes.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace vdbtools {
namespace {

ImageDecoder* findDecoder() {
#ifdef JULIAVDB_IMAGE_MODULE
  return reinterpret_cast<ImageDecoder*>(imageFunction("juliavdbDecodeImage"));
#else
  return juliavdbDecodeImage;
#endif
}

}  // namespace

DecodedImage readPicture(const std::filesystem::path& path) {
  static ImageDecoder* const decode = findDecoder();
  // Whether it is there and may be opened is not for OpenImageIO to say.
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    throw MissingInputError(path.string() + ": no such file; check its name");
  const auto refuse = [&](const std::string& why) {
    throw DataError(path.string() + ": it cannot be read as a picture (" + why +
                    "); save it as PNG, JPEG, TIFF or EXR");
  };
  if (!isExrHeaderSound(path)) refuse("its header is damaged");
  DecodedImage image;
  std::string reason;
  const MemoryLeft left = memoryLeft();
  if (!decode(path.string(), left.bytes, image, reason)) {
    if (reason.empty())
      throw MemoryError(path.string() + ": the picture of " + std::to_string(image.width) + " x " +
                            std::to_string(image.height) + " pixels would take " +
                            memoryText(double{sizeof(float)} * image.width * image.height * image.channels) +
                            " of memory, but " + left.limit + " leaves " + memoryText(left.bytes),
                        MemoryUse::Texture);
    refuse(inOneLine(reason));
  }
  if (!std::all_of(image.values.begin(), image.values.end(), [](float value) { return std::isfinite(value); }))
    throw DataError(path.string() + ": the picture has a value that is not finite; save it again without it");
  return image;
}

}  // namespace vdbtools
