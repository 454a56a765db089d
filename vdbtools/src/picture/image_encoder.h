// SPDX-License-Identifier: Apache-2.0
/// @file image_encoder.h
/// Pictures through OpenImageIO. It brings some 200 libraries, which took longer to load than many a job to run; so
/// what needs it is a module of its own, loaded with the first picture. In static builds it is a part of the library.
#pragma once

#include <cstdint>
#include <string>

namespace vdbtools {

inline constexpr int kImageChannels = 3;

/// One of the two arrays is given, row by row from the top left.
struct Picture {
  int width = 0, height = 0;            ///< pixels
  const std::uint8_t* codes = nullptr;  ///< sRGB, for a PNG
  const float* linear = nullptr;        ///< for an EXR; RGB within the range of half floats
  int channels = kImageChannels;        ///< of the linear array, pixel by pixel; those beyond RGB are kept as floats
  const char* const* names = nullptr;   ///< of those beyond RGB
};

/// @param result  the file's bytes; why there are none, where it returns false
using ImageEncoder = bool(const Picture& picture, std::string& result);

}  // namespace vdbtools

extern "C" vdbtools::ImageEncoder juliavdbEncodeImage;
