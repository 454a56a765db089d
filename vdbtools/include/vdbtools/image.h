// SPDX-License-Identifier: Apache-2.0
/// @file image.h
/// A plain RGB picture in memory and its way into a file through OpenImageIO.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace vdbtools {

/// Linear RGB, row by row from the top left.
struct Image {
  int width = 0;   ///< pixels
  int height = 0;  ///< pixels
  std::vector<std::array<float, 3>> pixels;

  Image() = default;
  Image(int w, int h) : width(w), height(h), pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
  std::array<float, 3>& at(int x, int y) { return pixels[static_cast<std::size_t>(y) * width + x]; }
  const std::array<float, 3>& at(int x, int y) const { return pixels[static_cast<std::size_t>(y) * width + x]; }
};

/// The picture as the bytes of a file. @a extension, with or without its dot, says which kind: png (8 bits, sRGB) or
/// exr (half float, linear). Values out of range are clamped, those that are not finite become 0. The same picture
/// gives the same bytes: the date that OpenEXR insists on is always 1970.
/// @throw std::invalid_argument  another extension, or an empty picture
/// @throw IoError                OpenImageIO cannot do it
std::string encodeImage(const Image& image, const std::string& extension);

}  // namespace vdbtools
