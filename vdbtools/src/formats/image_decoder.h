// SPDX-License-Identifier: Apache-2.0
/// @file image_decoder.h
/// Decodes pictures through OpenImageIO, in the module of files/image_module.h. Of the formats that are read this way
/// (JPEG, TIFF, EXR), OpenImageIO keeps all messages to itself; see png_decoder.h for the other one.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vdbtools {

/// Row by row from the top left, the channels of a pixel one after the other.
struct DecodedImage {
  int width = 0, height = 0, channels = 0;
  int alphaChannel = -1;  ///< -1: none
  bool isLinear = false;  ///< in linear light, as OpenEXR keeps colours; others are meant as sRGB
  std::vector<float> values;
};

/// Of a picture: 4 GB. A damaged header can announce anything.
inline constexpr std::uint64_t kMostPictureValues = std::uint64_t{1} << 30;

/// Why a picture is refused that has too many values, or none.
inline std::string unusableSize(int width, int height, int channels) {
  return "a picture of " + std::to_string(width) + " x " + std::to_string(height) + " pixels and " +
         std::to_string(channels) + " channels cannot be used";
}

/// @param bytes    of a file
/// @param format   how OpenImageIO calls it
/// @param threads  that decoding may use
/// @param room     bytes that the values may take
/// @param reason   where it returns false, why; empty: there is no room, and @a image has the size without the values
using ImageDecoder = bool(std::string_view bytes, std::string_view format, int threads, double room,
                          DecodedImage& image, std::string& reason);

}  // namespace vdbtools

extern "C" vdbtools::ImageDecoder juliavdbDecodeImage;
