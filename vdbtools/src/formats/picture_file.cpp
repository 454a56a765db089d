// SPDX-License-Identifier: Apache-2.0
#include "formats/picture_file.h"

#include "files/image_module.h"
#include "formats/exr_header.h"
#include "formats/png_decoder.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/files/file_bytes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>

namespace vdbtools {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view kExr = "openexr", kPng = "png";

ImageDecoder* findDecoder() {
#ifdef JULIAVDB_IMAGE_MODULE
  return reinterpret_cast<ImageDecoder*>(imageFunction("juliavdbDecodeImage"));
#else
  return juliavdbDecodeImage;
#endif
}

bool decode(std::string_view bytes, std::string_view format, double room, DecodedImage& image, std::string& reason) {
  if (format == kPng) return decodePng(bytes, room, image, reason);
  static ImageDecoder* const decodeOther = findDecoder();
  return decodeOther(bytes, format, imageThreads(), room, image, reason);
}

/// OpenImageIO's name of the format with which a file begins; empty for formats other than those for which it uses
/// widespread libraries. Its own decoders of other formats trust the file.
std::string_view formatOf(std::string_view bytes) {
  struct Beginning {
    std::string_view bytes, format;
  };
  constexpr std::array kBeginnings = {Beginning{"\x89PNG\r\n\x1a\n"sv, kPng}, Beginning{"\xff\xd8\xff"sv, "jpeg"},
                                      Beginning{"II*\0"sv, "tiff"},           Beginning{"MM\0*"sv, "tiff"},
                                      Beginning{"II+\0"sv, "tiff"},           Beginning{"MM\0+"sv, "tiff"},
                                      Beginning{"\x76\x2f\x31\x01"sv, kExr}};
  const auto it = std::find_if(kBeginnings.begin(), kBeginnings.end(),
                               [&](const Beginning& beginning) { return bytes.starts_with(beginning.bytes); });
  return it == kBeginnings.end() ? std::string_view() : it->format;
}

}  // namespace

DecodedImage readPicture(const std::filesystem::path& path) {
  std::error_code error;  // a device may have no end
  if (!std::filesystem::is_regular_file(path, error))
    throw MissingInputError(path.string() + ": no such file; check its name");
  const auto refuse = [&](const std::string& why) {
    throw DataError(path.string() + ": it cannot be read as a picture (" + why +
                    "); save it as PNG, JPEG, TIFF or EXR");
  };
  // The checked bytes are the decoded ones, whatever happens to the file meanwhile.
  const std::string bytes = readWholeFile(path);
  const std::string_view format = formatOf(bytes);
  if (format.empty()) refuse("it is of another format");
  if (format == kExr && !isExrHeaderSound(bytes)) refuse("its header is damaged");
  DecodedImage image{.isLinear = format == kExr};
  std::string reason;
  const MemoryLeft left = memoryLeft();
  if (!decode(bytes, format, left.bytes, image, reason)) {
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
