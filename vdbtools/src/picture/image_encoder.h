// SPDX-License-Identifier: Apache-2.0
/// @file image_encoder.h
/// Encodes images as EXR, and numbers as PNG and TIFF, through OpenImageIO, in the module of files/image_module.h.
#pragma once

#include <string>

namespace vdbtools {

inline constexpr int kImageChannels = 3;

/// An image with pixels row by row from the top left.
struct Picture {
  int width = 0, height = 0;           ///< pixels
  const float* linear = nullptr;       ///< RGB within the range of half floats
  int channels = kImageChannels;       ///< of the linear array, interleaved; channels beyond RGB are stored as floats
  const char* const* names = nullptr;  ///< names of the channels beyond RGB
  int threads = 1;                     ///< number of threads that encoding may use
};

/// Numbers that are data, row by row from the top left.
struct CodedPicture {
  int width = 0, height = 0, channels = 1;
  int bits = 8;
  const void* codes = nullptr;           ///< bytes for 8 bits, std::uint16_t for 16
  const char* format = "png";            ///< or "tif"
  double resolution = 0;                 ///< pixels per unit; 0: not recorded
  const char* resolutionUnit = nullptr;  ///< "m", "cm" or "none"
  const char* description = nullptr;     ///< nullptr: none
  int threads = 1;
};

/// @param result  the bytes of the file or, if the result is false, the error message
using ImageEncoder = bool(const Picture& picture, std::string& result);
using SliceEncoder = bool(const CodedPicture& picture, std::string& result);

}  // namespace vdbtools

extern "C" vdbtools::ImageEncoder juliavdbEncodeImage;
extern "C" vdbtools::SliceEncoder juliavdbEncodeSlice;
