// SPDX-License-Identifier: Apache-2.0
#include "formats/exr_header.h"

#include "formats/picture_file.h"
#include "support/temporary_folder.h"
#include "support/test_meshes.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/picture/image.h"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace {

using namespace std::string_view_literals;

std::string someExr() {
  vdbtools::Image image(3, 2);
  const std::array channels = {vdbtools::Channel{"Z", std::vector<float>(6, 2)}};
  return vdbtools::encodeExr(image, channels);
}

class ExrHeader : public testing::Test {
 protected:
  TemporaryFolder mFolder;
};

TEST_F(ExrHeader, WhatIsWrittenIsSound) {
  const std::string bytes = someExr();
  EXPECT_TRUE(vdbtools::isExrHeaderSound(bytes));
  EXPECT_EQ(vdbtools::readPicture(mFolder.write("whole.exr", bytes)).width, 3);
}

TEST_F(ExrHeader, NoBeginningOfItIsSound) {
  const std::string bytes = someExr();
  const std::size_t last = bytes.find("screenWindowWidth\0float\0"sv);
  ASSERT_NE(last, std::string::npos);
  for (std::size_t size = 4; size < last; ++size)
    EXPECT_FALSE(vdbtools::isExrHeaderSound(std::string_view(bytes).substr(0, size))) << size;
}

TEST_F(ExrHeader, EverySizeIsThatOfItsKind) {
  const std::string bytes = someExr();
  for (const std::string_view attribute :
       {"channels\0chlist\0"sv, "compression\0compression\0"sv, "dataWindow\0box2i\0"sv, "displayWindow\0box2i\0"sv,
        "lineOrder\0lineOrder\0"sv, "pixelAspectRatio\0float\0"sv, "screenWindowCenter\0v2f\0"sv}) {
    const std::size_t at = bytes.find(attribute);
    ASSERT_NE(at, std::string::npos) << attribute;
    for (const char change : {1, 2, 17, 64}) {
      std::string changed = bytes;
      changed[at + attribute.size()] = static_cast<char>(changed[at + attribute.size()] ^ change);
      EXPECT_FALSE(vdbtools::isExrHeaderSound(changed)) << attribute << " with " << int{change};
      EXPECT_THROW(vdbtools::readPicture(mFolder.write("changed.exr", changed)), vdbtools::DataError);
    }
  }
}

// Promise: OpenImageIO's "own decoders of other ..."
TEST_F(ExrHeader, NoValueIsLargerThanTheFile) {
  const std::string start("\x76\x2f\x31\x01\2\0\0\0", 8);
  const auto with = [&](std::string_view kind, std::string_view value, std::size_t size) {
    std::string bytes = start + std::string("note\0"sv) + std::string(kind) + '\0';
    for (int i = 0; i < 4; ++i) bytes += static_cast<char>(size >> (8 * i));
    return bytes + std::string(value) + '\0';
  };
  EXPECT_TRUE(vdbtools::isExrHeaderSound(with("string", "abc", 3)));
  EXPECT_FALSE(vdbtools::isExrHeaderSound(with("string", "abc", 5)));
  EXPECT_FALSE(vdbtools::isExrHeaderSound(with("string", "abc", 0x7fffffff)));
  EXPECT_FALSE(vdbtools::isExrHeaderSound(with("string", "abc", 0xffffffff)));
  EXPECT_TRUE(vdbtools::isExrHeaderSound(with("of its own", "abc", 3)));
  EXPECT_TRUE(vdbtools::isExrHeaderSound(with("stringvector", "\1\0\0\0a\2\0\0\0bc"sv, 11)));
  EXPECT_FALSE(vdbtools::isExrHeaderSound(with("stringvector", "\1\0\0\0a\3\0\0\0bc"sv, 11)));
  EXPECT_TRUE(vdbtools::isExrHeaderSound(with("preview", "\1\0\0\0\1\0\0\0abcd"sv, 12)));
  EXPECT_FALSE(vdbtools::isExrHeaderSound(with("preview", "\1\0\0\0\2\0\0\0abcd"sv, 12)));
  EXPECT_FALSE(vdbtools::isExrHeaderSound(with("preview", "\xff\xff\xff\xff\xff\xff\xff\xff"sv, 12)));
}

}  // namespace
