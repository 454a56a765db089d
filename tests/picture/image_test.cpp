// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/picture/image.h"

#include "picture/png_encoder.h"
#include "support/limits.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

using vdbtools::encodeImage;
using vdbtools::Image;

namespace {

using test_limits::kFloatInfinity;
using test_limits::kFloatNan;

struct Decoded {
  OIIO::ImageSpec spec;
  std::vector<float> values;  ///< as the file has them: PNG codes over 255
};

Decoded decode(const std::string& bytes, const std::string& extension) {
  OIIO::Filesystem::IOMemReader source(bytes.data(), bytes.size());
  const auto input = OIIO::ImageInput::open("picture." + extension, nullptr, &source);
  if (!input) throw std::runtime_error(OIIO::geterror());
  Decoded decoded{input->spec(), {}};
  decoded.values.resize(decoded.spec.image_pixels() * decoded.spec.nchannels);
  if (!input->read_image(0, 0, 0, decoded.spec.nchannels, OIIO::TypeDesc::FLOAT, decoded.values.data())) {
    throw std::runtime_error(input->geterror());
  }
  return decoded;
}

Image ramp(int width, int height) {
  Image image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image.at(x, y) = {x / float(width), y / float(height), 0.25F};
  }
  return image;
}

TEST(Image, PngHoldsSrgbCodes) {
  // The codes follow from the definition of sRGB: 0.18 is the photographer's grey card, 118.
  const std::vector<std::pair<float, int>> known = {{0.0F, 0},   {1.0F, 255}, {0.5F, 188}, {0.18F, 118},
                                                    {0.002F, 7}, {2.0F, 255}, {-1.0F, 0}};
  Image image(static_cast<int>(known.size()), 1);
  for (std::size_t i = 0; i < known.size(); ++i) image.pixels[i] = {known[i].first, 0, 1};

  const Decoded decoded = decode(encodeImage(image, "png"), "png");
  EXPECT_EQ(decoded.spec.format, OIIO::TypeDesc::UINT8);
  EXPECT_EQ(decoded.spec.nchannels, 3);
  EXPECT_EQ(decoded.spec.get_string_attribute("oiio:ColorSpace"), "sRGB");
  for (std::size_t i = 0; i < known.size(); ++i) {
    EXPECT_EQ(std::lround(255 * decoded.values[3 * i]), known[i].second) << "linear " << known[i].first;
    EXPECT_EQ(decoded.values[3 * i + 1], 0);
    EXPECT_EQ(decoded.values[3 * i + 2], 1);
  }
}

TEST(Image, APngOfMorePixelsThanTheFormatsLibraryCountsIsRefused) {
  EXPECT_THROW(vdbtools::encodePng(40000, 40000, nullptr), std::invalid_argument);
}

TEST(Image, ExrHoldsLinearHalves) {
  Image image(3, 2);
  image.at(0, 0) = {0.5F, -2.0F, 7.25F};
  image.at(2, 1) = {1e6F, -1e6F, 0.1F};
  const Decoded decoded = decode(encodeImage(image, "exr"), "exr");
  EXPECT_EQ(decoded.spec.format, OIIO::TypeDesc::HALF);
  EXPECT_EQ(decoded.spec.width, 3);
  EXPECT_EQ(decoded.spec.height, 2);
  EXPECT_EQ(decoded.values[0], 0.5F);
  EXPECT_EQ(decoded.values[1], -2.0F);
  EXPECT_EQ(decoded.values[2], 7.25F);
  const float* last = &decoded.values[3 * 5];
  EXPECT_EQ(last[0], 65504.0F);
  EXPECT_EQ(last[1], -65504.0F);
  EXPECT_NEAR(last[2], 0.1F, 1e-4F);
}

TEST(Image, ExrTakesFurtherChannelsAsFloats) {
  const Image image = ramp(3, 2);
  const vdbtools::Channel depth{"Z", {1e10F, 0.1F, kFloatNan, -3, 70000, 1e-7F}},
      alpha{"A", {0, 0.25F, 0.5F, 0.75F, 1, 1}};
  const std::vector<vdbtools::Channel> channels = {depth, alpha};
  const std::string bytes = vdbtools::encodeExr(image, channels);
  EXPECT_EQ(bytes, vdbtools::encodeExr(image, channels));
  const Decoded decoded = decode(bytes, "exr");
  ASSERT_EQ(decoded.spec.nchannels, 5);
  const auto value = [&](const char* name, std::size_t pixel) {
    return decoded.values[pixel * 5 + static_cast<std::size_t>(decoded.spec.channelindex(name))];
  };
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(value("Z", i), i == 2 ? 0 : depth.values[i]);
    EXPECT_EQ(value("A", i), alpha.values[i]);
    EXPECT_NEAR(value("R", i), image.pixels[i][0], 1e-3F);
  }
  EXPECT_THROW(vdbtools::encodeExr(image, std::vector<vdbtools::Channel>{{"A", {1, 2}}}), std::invalid_argument);
  EXPECT_THROW(vdbtools::encodeExr(Image(), {}), std::invalid_argument);
}

TEST(Image, RowsRunFromTheTopLeft) {
  const Image image = ramp(9, 5);
  for (const char* extension : {"png", "exr"}) {
    const Decoded decoded = decode(encodeImage(image, extension), extension);
    ASSERT_EQ(decoded.spec.width, 9);
    ASSERT_EQ(decoded.spec.height, 5);
    const auto red = [&](int x, int y) { return decoded.values[3 * (y * 9 + x)]; };
    const auto green = [&](int x, int y) { return decoded.values[3 * (y * 9 + x) + 1]; };
    EXPECT_LT(red(0, 0), red(8, 0)) << extension;
    EXPECT_LT(green(0, 0), green(0, 4)) << extension;
    EXPECT_EQ(red(4, 0), red(4, 4)) << extension;
  }
}

TEST(Image, WhatIsNotFiniteBecomesZero) {
  Image image(2, 1);
  image.at(0, 0) = {kFloatNan, kFloatInfinity, -kFloatInfinity};
  image.at(1, 0) = {1, 1, 1};
  for (const char* extension : {"png", "exr"}) {
    const Decoded decoded = decode(encodeImage(image, extension), extension);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(decoded.values[i], 0) << extension << " channel " << i;
    for (int i = 3; i < 6; ++i) EXPECT_EQ(decoded.values[i], 1) << extension << " channel " << i;
  }
}

TEST(Image, SamePictureSameBytes) {
  const Image image = ramp(130, 70);
  for (const char* extension : {"png", "exr"}) {
    const std::string bytes = encodeImage(image, extension);
    EXPECT_EQ(bytes, encodeImage(image, extension)) << extension;
    for (const char* word : {"tIME", "Software", "HostComputer"}) {
      EXPECT_EQ(bytes.find(word), std::string::npos) << extension << " holds " << word;
    }
    const std::string date = decode(bytes, extension).spec.get_string_attribute("DateTime");
    EXPECT_TRUE(date.empty() || date.starts_with("1970")) << extension << ' ' << date;
  }
}

TEST(Image, ExtensionsAreTakenWithADotAndInCapitals) {
  const Image image = ramp(4, 4);
  EXPECT_EQ(encodeImage(image, ".png"), encodeImage(image, "png"));
  EXPECT_EQ(encodeImage(image, ".EXR"), encodeImage(image, "exr"));
  for (const char* bad : {"", ".", "jpg", "..png", "png ", "tiff"}) {
    EXPECT_THROW(encodeImage(image, bad), std::invalid_argument) << '"' << bad << '"';
  }
}

TEST(Image, EmptyOrInconsistentPicturesAreRefused) {
  EXPECT_THROW(encodeImage(Image(), "png"), std::invalid_argument);
  EXPECT_THROW(encodeImage(Image(0, 3), "exr"), std::invalid_argument);
  Image image = ramp(3, 3);
  image.pixels.pop_back();
  EXPECT_THROW(encodeImage(image, "png"), std::invalid_argument);
}

}  // namespace
