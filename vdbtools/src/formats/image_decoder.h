// SPDX-License-Identifier: Apache-2.0
/// @file image_decoder.h
/// Decodes pictures through OpenImageIO, in the module of files/image_module.h.
#pragma once

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

/// @param bytes    of a file
/// @param format   how OpenImageIO calls it
/// @param threads  that decoding may use
/// @param room     bytes that the values may take
/// @param reason   where it returns false, why; empty: there is no room, and @a image has the size without the values
using ImageDecoder = bool(std::string_view bytes, std::string_view format, int threads, double room,
                          DecodedImage& image, std::string& reason);

}  // namespace vdbtools

extern "C" vdbtools::ImageDecoder juliavdbDecodeImage;
