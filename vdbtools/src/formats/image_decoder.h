// SPDX-License-Identifier: Apache-2.0
/// @file image_decoder.h
/// Decodes pictures through OpenImageIO, in the module of files/image_module.h. For the formats that are read this way
/// (JPEG, TIFF, EXR), OpenImageIO prints no messages; see png_decoder.h for PNG.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vdbtools {

/// Pixels row by row from the top left, with interleaved channels.
struct DecodedImage {
  int width = 0, height = 0, channels = 0;
  int alphaChannel = -1;  ///< -1: none
  bool isLinear = false;  ///< in linear light, as in OpenEXR; others are assumed to be sRGB
  std::vector<float> values;
};

/// The maximum number of values in a picture: 4 GB. A damaged header can state any size.
inline constexpr std::uint64_t kMostPictureValues = std::uint64_t{1} << 30;

/// The reason for refusing a picture with too many values, or with none.
inline std::string unusableSize(int width, int height, int channels) {
  return "a picture of " + std::to_string(width) + " x " + std::to_string(height) + " pixels and " +
         std::to_string(channels) + " channels cannot be used";
}

/// @param bytes    the bytes of a file
/// @param format   its name in OpenImageIO
/// @param threads  number of threads that decoding may use
/// @param room     bytes that the values may take
/// @param reason   set if the result is false; empty: the room is insufficient, and @a image has the size without the
///                 values
using ImageDecoder = bool(std::string_view bytes, std::string_view format, int threads, double room,
                          DecodedImage& image, std::string& reason);

}  // namespace vdbtools

extern "C" vdbtools::ImageDecoder juliavdbDecodeImage;
