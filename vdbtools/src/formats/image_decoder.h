// SPDX-License-Identifier: Apache-2.0
/// @file image_decoder.h
/// Decodes pictures through OpenImageIO, in the module of files/image_module.h.
#pragma once

#include <string>
#include <vector>

namespace vdbtools {

/// Row by row from the top left, the channels of a pixel one after the other.
struct DecodedImage {
  int width = 0, height = 0, channels = 0;
  int alphaChannel = -1;  ///< -1: none
  std::vector<float> values;
};

/// @param reason  where it returns false, why
using ImageDecoder = bool(const std::string& path, DecodedImage& image, std::string& reason);

}  // namespace vdbtools

extern "C" vdbtools::ImageDecoder juliavdbDecodeImage;
