// SPDX-License-Identifier: Apache-2.0
/// @file image.h
/// The room `picture`: images in memory and their files (image.h), drawings with text (canvas.h), plots (plot.h) and
/// the colouring of slices (slice_image.h). It knows neither meshes nor fractals: it may use only the rooms base and
/// files, and only vectors and boxes of OpenVDB.
///
/// This header declares an RGB image and its encoding by libpng and OpenImageIO.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace vdbtools {

/// Linear RGB, with the primaries of sRGB. 0 is black, 1 is the white of the screen.
using Colour = std::array<float, 3>;

/// Pixels are stored row by row from the top left.
struct Image {
  int width = 0;   ///< pixels
  int height = 0;  ///< pixels
  std::vector<Colour> pixels;

  Image() = default;
  Image(int w, int h) : width(w), height(h), pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
  Colour& at(int x, int y) { return pixels[static_cast<std::size_t>(y) * width + x]; }
  const Colour& at(int x, int y) const { return pixels[static_cast<std::size_t>(y) * width + x]; }
};

/// Encodes the image as the bytes of a file. @a extension, with or without its dot, selects the format: png (8 bits,
/// sRGB) or exr (half floats, linear). Values out of range are clamped; values that are not finite become 0. The same
/// image gives the same bytes: the date that OpenEXR requires is always 1970.
/// @throw std::invalid_argument  another extension, an empty image, or an image that is too large for a PNG
/// @throw IoError                OpenImageIO cannot encode it
std::string encodeImage(const Image& image, const std::string& extension);

/// Encodes the image as a PNG with alpha.
/// @param premultiplied  the image, multiplied by the coverage
/// @param coverage       one value per pixel, 0 to 1
/// @throw std::invalid_argument  as encodeImage(), or the number of values differs from that of the pixels
std::string encodePngWithAlpha(const Image& premultiplied, std::span<const float> coverage);

/// A channel in addition to RGB.
struct Channel {
  std::string name;           ///< the name that compositors use: A, Z, N.x
  std::vector<float> values;  ///< one per pixel, in the order of the image
};

/// Encodes the image as an EXR with additional channels, which are stored as 32-bit floats.
/// @throw std::invalid_argument  an empty image, or a channel of another size
/// @throw IoError                OpenImageIO cannot encode it
std::string encodeExr(const Image& image, std::span<const Channel> channels);

}  // namespace vdbtools
