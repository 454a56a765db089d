// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/picture/image.h"

#include "base/srgb.h"
#include "files/image_module.h"
#include "picture/image_encoder.h"
#include "picture/png_encoder.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/picture/gradient.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

namespace vdbtools {
namespace {

constexpr float kLargestHalf = 65504;  ///< the largest finite half float

enum class Kind { Png, Exr };

Kind kindOf(const std::string& extension) {
  const std::string name = lowerCase(extension.substr(extension.starts_with('.') ? 1 : 0));
  if (name == "png") return Kind::Png;
  if (name == "exr") return Kind::Exr;
  throw std::invalid_argument("images cannot be written as \"" + extension + "\"; use png or exr");
}

float finiteOrZero(float value) { return std::isfinite(value) ? value : 0.0F; }

template <typename Value, typename Convert>
std::vector<Value> converted(const Image& image, Convert convert) {
  std::vector<Value> values;
  values.reserve(image.pixels.size() * kImageChannels);
  for (const auto& pixel : image.pixels) {
    for (const float channel : pixel) values.push_back(convert(channel));
  }
  return values;
}

ImageEncoder* findEncoder() {
#ifdef JULIAVDB_IMAGE_MODULE
  return reinterpret_cast<ImageEncoder*>(imageFunction("juliavdbEncodeImage"));
#else
  return juliavdbEncodeImage;
#endif
}

std::string write(Picture picture) {
  static ImageEncoder* const encode = findEncoder();
  picture.threads = imageThreads();
  std::string result;
  if (!encode(picture, result)) throw IoError(result);
  return result;
}

float inHalfRange(float value) { return std::clamp(finiteOrZero(value), -kLargestHalf, kLargestHalf); }

void requirePixels(const Image& image) {
  if (image.width < 1 || image.height < 1 ||
      image.pixels.size() != static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height)) {
    throw std::invalid_argument(
        "an image of " + std::to_string(image.width) + " x " + std::to_string(image.height) + " with " +
        std::to_string(image.pixels.size()) +
        " pixels cannot be written; it needs at least 1 x 1, and as many pixels as its size says");
  }
}

void requireValues(const std::string& channel, std::size_t count, const Image& image) {
  if (count != image.pixels.size())
    throw std::invalid_argument("the channel \"" + channel + "\" has " + std::to_string(count) + " values for " +
                                std::to_string(image.pixels.size()) + " pixels");
}

}  // namespace

std::vector<std::uint8_t> screenCodes(const Image& image) { return converted<std::uint8_t>(image, srgbCode); }

std::string encodeImage(const Image& image, const std::string& extension) {
  const Kind kind = kindOf(extension);
  requirePixels(image);
  if (kind == Kind::Png) {
    return encodePng(image.width, image.height, screenCodes(image).data());
  }
  const auto values = converted<float>(image, inHalfRange);
  return write({.width = image.width, .height = image.height, .linear = values.data()});
}

std::string encodePngWithAlpha(const Image& premultiplied, std::span<const float> coverage) {
  requirePixels(premultiplied);
  requireValues("coverage", coverage.size(), premultiplied);
  constexpr float kLargestCode = 255;
  std::vector<std::uint8_t> codes;
  codes.reserve(4 * coverage.size());
  for (std::size_t i = 0; i < coverage.size(); ++i) {
    const float alpha = std::clamp(finiteOrZero(coverage[i]), 0.0F, 1.0F);
    for (const float channel : premultiplied.pixels[i]) codes.push_back(srgbCode(alpha > 0 ? channel / alpha : 0));
    codes.push_back(static_cast<std::uint8_t>(kLargestCode * alpha + 0.5F));
  }
  return encodePng(premultiplied.width, premultiplied.height, codes.data(), true);
}

std::string encodeExr(const Image& image, std::span<const Channel> channels) {
  requirePixels(image);
  std::vector<const char*> names;
  for (const Channel& channel : channels) {
    requireValues(channel.name, channel.values.size(), image);
    names.push_back(channel.name.c_str());
  }
  std::vector<float> values;
  values.reserve(image.pixels.size() * (kImageChannels + channels.size()));
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    for (const float channel : image.pixels[i]) values.push_back(inHalfRange(channel));
    for (const Channel& channel : channels) values.push_back(finiteOrZero(channel.values[i]));
  }
  return write({.width = image.width,
                .height = image.height,
                .linear = values.data(),
                .channels = kImageChannels + static_cast<int>(channels.size()),
                .names = names.data()});
}

}  // namespace vdbtools
