// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/image.h"

#include "vdbtools/errors.h"
#include "vdbtools/file_bytes.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

namespace vdbtools {
namespace {

constexpr int kChannels = 3;
constexpr float kLargestHalf = 65504;  ///< beyond it a half float is infinite

constexpr const char* kNoDate = "1970:01:01 00:00:00";

enum class Kind { Png, Exr };

Kind kindOf(const std::string& extension) {
  const std::string name = lowerCase(extension.substr(extension.starts_with('.') ? 1 : 0));
  if (name == "png") return Kind::Png;
  if (name == "exr") return Kind::Exr;
  throw std::invalid_argument("no picture is written as \"" + extension + "\"; use png or exr");
}

float finiteOrZero(float value) { return std::isfinite(value) ? value : 0.0F; }

/// The transfer function of IEC 61966-2-1, as an 8-bit code.
std::uint8_t srgbCode(float linear) {
  const float v = std::clamp(finiteOrZero(linear), 0.0F, 1.0F);
  const float encoded = v <= 0.0031308F ? 12.92F * v : 1.055F * std::pow(v, 1 / 2.4F) - 0.055F;
  return static_cast<std::uint8_t>(std::lround(255 * encoded));
}

template <typename Value, typename Convert>
std::vector<Value> converted(const Image& image, Convert convert) {
  std::vector<Value> values;
  values.reserve(image.pixels.size() * kChannels);
  for (const auto& pixel : image.pixels) {
    for (const float channel : pixel) values.push_back(convert(channel));
  }
  return values;
}

std::string write(const char* format, const OIIO::ImageSpec& spec, OIIO::TypeDesc type, const void* values) {
  const auto output = OIIO::ImageOutput::create(format);
  if (!output) throw IoError(std::string("OpenImageIO was built without ") + format + ": " + OIIO::geterror());

  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput sink(bytes);
  output->set_ioproxy(&sink);
  // The name only tells the format; the bytes go to the sink.
  const bool written = output->open(std::string("picture.") + format, spec) && output->write_image(type, values);
  if (!output->close() || !written) throw IoError(std::string("cannot encode the picture: ") + output->geterror());
  return {bytes.begin(), bytes.end()};
}

}  // namespace

std::string encodeImage(const Image& image, const std::string& extension) {
  const Kind kind = kindOf(extension);
  if (image.width < 1 || image.height < 1 ||
      image.pixels.size() != static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height)) {
    throw std::invalid_argument("a picture of " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                                " with " + std::to_string(image.pixels.size()) + " pixels cannot be written");
  }

  if (kind == Kind::Png) {
    OIIO::ImageSpec spec(image.width, image.height, kChannels, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    return write("png", spec, OIIO::TypeDesc::UINT8, converted<std::uint8_t>(image, srgbCode).data());
  }
  OIIO::ImageSpec spec(image.width, image.height, kChannels, OIIO::TypeDesc::HALF);
  spec.attribute("oiio:ColorSpace", "Linear");
  spec.attribute("compression", "zip");
  // OpenImageIO writes the time of day where no date is given; the same picture shall give the same bytes.
  spec.attribute("DateTime", kNoDate);
  const auto toHalfRange = [](float v) { return std::clamp(finiteOrZero(v), -kLargestHalf, kLargestHalf); };
  return write("exr", spec, OIIO::TypeDesc::FLOAT, converted<float>(image, toHalfRange).data());
}

}  // namespace vdbtools
