// SPDX-License-Identifier: Apache-2.0
// A page of pictures: they come out as they went in, and no text leaves its cell.
#include "picture/contact_sheet.h"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

namespace {

using namespace vdbtools;

constexpr int kWidth = 40, kHeight = 30;

ContactSheet sheet(int rows = 2, int columns = 3) {
  return ContactSheet(
      {.rows = rows, .columns = columns, .cellWidth = kWidth, .cellHeight = kHeight, .captionLines = 2});
}

/// A picture whose pixels differ from each other.
std::string picture(int width = kWidth, int height = kHeight, float blue = 0) {
  Image image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      image.at(x, y) = {static_cast<float>(x) / static_cast<float>(width),
                        static_cast<float>(y) / static_cast<float>(height), blue};
  return encodeImage(image, "png");
}

/// The page, read back through a canvas.
Image page(ContactSheet& drawn, int rows, int columns) {
  const std::string png = drawn.encode("png");
  // The size stands at a fixed place of every PNG.
  const auto number = [&](std::size_t at) {
    int value = 0;
    for (std::size_t i = at; i < at + 4; ++i) value = 256 * value + static_cast<unsigned char>(png[i]);
    return value;
  };
  Canvas canvas(CanvasKind::Pixels, number(16), number(20));
  EXPECT_TRUE(canvas.png(png, {0, 0, static_cast<double>(number(16)), static_cast<double>(number(20))}));
  EXPECT_GT(number(16), columns * kWidth);
  EXPECT_GT(number(20), rows * kHeight);
  return canvas.pixels();
}

TEST(CanvasPng, ReturnsTheCodesOfTheFile) {
  const std::string png = picture();
  Canvas canvas(CanvasKind::Pixels, kWidth, kHeight);
  ASSERT_TRUE(canvas.png(png, {0, 0, kWidth, kHeight}));
  EXPECT_EQ(canvas.encode("png"), png);
}

TEST(CanvasPng, RefusesBrokenBytesAndOtherSizes) {
  Canvas canvas(CanvasKind::Pixels, kWidth, kHeight);
  const std::string blank = canvas.encode("png"), png = picture();
  EXPECT_FALSE(canvas.png("", {0, 0, kWidth, kHeight}));
  EXPECT_FALSE(canvas.png("no picture", {0, 0, kWidth, kHeight}));
  for (const std::size_t size : {std::size_t{8}, std::size_t{40}, png.size() / 2, png.size() - 20})
    EXPECT_FALSE(canvas.png(png.substr(0, size), {0, 0, kWidth, kHeight})) << size;
  EXPECT_FALSE(canvas.png(picture(kWidth + 1), {0, 0, kWidth, kHeight}));
  EXPECT_FALSE(canvas.png(picture(kHeight, kWidth), {0, 0, kWidth, kHeight}));
  EXPECT_EQ(canvas.encode("png"), blank) << "something was drawn";
}

TEST(ContactSheet, EveryPictureStandsOnceOnThePage) {
  ContactSheet drawn = sheet();
  for (int cell = 0; cell < 6; ++cell)
    ASSERT_TRUE(drawn.setPicture(cell, picture(kWidth, kHeight, 0.1F * static_cast<float>(cell + 1))));
  const Image whole = page(drawn, 2, 3);
  // Pictures are told apart by their blue.
  std::map<float, int> pixelsOfBlue;
  std::vector<float> order;
  for (int y = 0; y < whole.height; ++y)
    for (int x = 0; x < whole.width; ++x) {
      const Colour& pixel = whole.at(x, y);
      if (pixelsOfBlue[pixel[2]]++ == 0) order.push_back(pixel[2]);
    }
  int cells = 0;
  for (const auto& [blue, count] : pixelsOfBlue) cells += count == kWidth * kHeight ? 1 : 0;
  EXPECT_EQ(cells, 6);
  // From the left to the right and then down, in their order: the margin's own colour comes first.
  ASSERT_EQ(order.size(), 7U);
  EXPECT_TRUE(std::is_sorted(order.begin() + 1, order.end()));
}

TEST(ContactSheet, NoTextLeavesItsCell) {
  const std::string longText = "an error with a very_long_word_that_does_not_fit_into_any_cell and many more words";
  ContactSheet before = sheet(), after = sheet();
  after.setMessage(1, longText + longText + longText);
  after.setCaption(
      1, 2,
      std::vector<std::string>{"texture-translate 0,0,0,0,0,0,0,0",
                               "\u00e4\u00f6\u00fc \u00e4\u00f6\u00fc\u00e4\u00f6\u00fc\u00e4\u00f6\u00fc"});
  const Image empty = page(before, 2, 3), written = page(after, 2, 3);
  int left = empty.width, right = 0, top = empty.height, bottom = 0;
  for (int y = 0; y < empty.height; ++y)
    for (int x = 0; x < empty.width; ++x)
      if (empty.at(x, y) != written.at(x, y)) {
        left = std::min(left, x), right = std::max(right, x + 1);
        top = std::min(top, y), bottom = std::max(bottom, y + 1);
      }
  ASSERT_LT(left, right) << "nothing was written";
  EXPECT_LE(right - left, kWidth + 1);
  EXPECT_GT(left, empty.width / 3);
  EXPECT_LT(right, 2 * empty.width / 3);
  EXPECT_LT(bottom, empty.height / 2);
  EXPECT_GT(bottom - top, kHeight) << "there is no caption";
}

TEST(ContactSheet, WhatIsDrawnLaterCovers) {
  ContactSheet twice = sheet(), once = sheet();
  twice.setMessage(0, "an error");
  twice.setCaption(0, 7, std::vector<std::string>{"alpha 10"});
  for (ContactSheet* each : {&twice, &once}) {
    ASSERT_TRUE(each->setPicture(0, picture()));
    each->setCaption(0, 1, std::vector<std::string>{"beta 2"});
  }
  EXPECT_EQ(twice.encode("png"), once.encode("png"));
}

TEST(ContactSheet, ATooLargePageIsRefused) { EXPECT_THROW(sheet(1, 1000), std::invalid_argument); }

}  // namespace
