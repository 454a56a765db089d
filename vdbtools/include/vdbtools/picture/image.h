// SPDX-License-Identifier: Apache-2.0
/// @file image.h
/// A plain RGB picture in memory and its way into a file through OpenImageIO.
#pragma once

#include <array>
#include <cstddef>
#include <span>
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

/// A channel beyond RGB, a value a pixel in the image's order.
struct Channel {
  std::string name;  ///< as compositors know it: A, Z, N.x
  std::vector<float> values;
};

/// The same as an EXR with further channels, in 32 bits each.
/// @throw std::invalid_argument  an empty picture, or a channel of another size; IoError
std::string encodeExr(const Image& image, std::span<const Channel> channels);

}  // namespace vdbtools
