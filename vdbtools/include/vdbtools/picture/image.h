// SPDX-License-Identifier: Apache-2.0
/// @file image.h
/// The room `picture`: images in memory, their files (image.h), drawings with text (canvas.h), plots (plot.h) and the
/// colouring of slices (slice_image.h). It knows neither meshes nor fractals: it may use the rooms base and files, and
/// of OpenVDB only vectors and boxes.
///
/// This header: an RGB image, and its encoding by libpng and OpenImageIO.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace vdbtools {

/// Linear RGB, with the primaries of sRGB. 0 is black, 1 is the white of the screen.
using Colour = std::array<float, 3>;

/// Row by row from the top left.
struct Image {
  int width = 0;   ///< pixels
  int height = 0;  ///< pixels
  std::vector<Colour> pixels;

  Image() = default;
  Image(int w, int h) : width(w), height(h), pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
  Colour& at(int x, int y) { return pixels[static_cast<std::size_t>(y) * width + x]; }
  const Colour& at(int x, int y) const { return pixels[static_cast<std::size_t>(y) * width + x]; }
};

/// Encodes the image as the bytes of a file. @a extension, with or without its dot, names the format: png (8 bits,
/// sRGB) or exr (half floats, linear). Values out of range are clamped; values that are not finite become 0. The same
/// image gives the same bytes: the date that OpenEXR insists on is always 1970.
/// @throw std::invalid_argument  another extension, an empty image, or one that is too large for a PNG
/// @throw IoError                OpenImageIO cannot encode it
std::string encodeImage(const Image& image, const std::string& extension);

/// Encodes the image as a PNG with alpha.
/// @param premultiplied  by the coverage, which is 0 to 1, one value for each pixel
/// @throw std::invalid_argument  as encodeImage(), or another number of values
std::string encodePngWithAlpha(const Image& premultiplied, std::span<const float> coverage);

/// A channel beyond RGB.
struct Channel {
  std::string name;           ///< as compositors know it: A, Z, N.x
  std::vector<float> values;  ///< one for each pixel, in the order of the image
};

/// Encodes the image as an EXR with further channels, which are kept as 32-bit floats.
/// @throw std::invalid_argument  an empty image, or a channel of another size
/// @throw IoError                OpenImageIO cannot encode it
std::string encodeExr(const Image& image, std::span<const Channel> channels);

}  // namespace vdbtools
