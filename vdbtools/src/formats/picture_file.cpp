// SPDX-License-Identifier: Apache-2.0
#include "formats/picture_file.h"

#include "files/image_module.h"
#include "vdbtools/base/errors.h"
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
  DecodedImage image;
  std::string reason;
  if (!decode(path.string(), image, reason))
    throw DataError(path.string() + ": it cannot be read as a picture (" + inOneLine(reason) +
                    "); save it as PNG, JPEG, TIFF or EXR");
  if (!std::all_of(image.values.begin(), image.values.end(), [](float value) { return std::isfinite(value); }))
    throw DataError(path.string() + ": the picture has a value that is not finite; save it again without it");
  return image;
}

}  // namespace vdbtools
