// SPDX-License-Identifier: Apache-2.0
// Texts within PNG files: they come back, and the picture stays what it is.
#include "picture/png_text.h"
#include "formats/png_decoder.h"
#include "picture/png_encoder.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace vdbtools;

std::string fewPixels() {
  std::vector<std::uint8_t> codes;
  for (int i = 0; i < 5 * 4 * 3; ++i) codes.push_back(static_cast<std::uint8_t>(4 * i));
  return encodePng(5, 4, codes.data());
}

std::vector<float> valuesOf(const std::string& png) {
  DecodedImage image;
  std::string reason;
  EXPECT_TRUE(decodePng(png, 1e6, image, reason)) << reason;
  return image.values;
}

TEST(PngText, ThePictureStaysWhatItIs) {
  const std::string plain = fewPixels();
  EXPECT_EQ(valuesOf(withPngText(withPngText(plain, "a", "one text"), "b", std::string(300, 'x'))), valuesOf(plain));
}

TEST(PngText, ComesBackByItsKey) {
  const std::string plain = fewPixels();
  const std::string one = withPngText(plain, "first", "25 % of it"), both = withPngText(one, "second", "");
  EXPECT_EQ(pngText(one, "first"), "25 % of it");
  EXPECT_EQ(pngText(both, "first"), "25 % of it");
  for (const char* none : {"second", "fir", "first ", ""}) EXPECT_EQ(pngText(one, none), "") << none;
  EXPECT_EQ(pngText(plain, "first"), "");
}

TEST(PngText, BrokenFilesHoldNoText) {
  const std::string whole = withPngText(fewPixels(), "key", "text");
  const std::size_t text = whole.find("text");
  for (std::size_t size = 0; size < text + 8; ++size) EXPECT_EQ(pngText(whole.substr(0, size), "key"), "") << size;
  for (std::size_t at = 0; at < text + 8; ++at) {
    std::string broken = whole;
    broken[at] = static_cast<char>(broken[at] ^ 0x10);
    EXPECT_EQ(pngText(broken, "key"), "") << at;
  }
  for (const char* none : {"", "no picture", "\x89PNG\r\n\x1a\n"})
    EXPECT_THROW(withPngText(none, "key", "text"), std::invalid_argument) << none;
}

}  // namespace
