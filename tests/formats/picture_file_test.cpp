// SPDX-License-Identifier: Apache-2.0
#include "formats/picture_file.h"

#include "support/temporary_folder.h"
#include "vdbtools/base/errors.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace {

using vdbtools::DecodedImage;
using vdbtools::readPicture;

/// Noise, as a file of this format.
std::string encodedNoise(const char* format, int channels, OIIO::TypeDesc type, const char* compression = nullptr) {
  constexpr int kWidth = 37, kHeight = 23;
  std::mt19937 random(5);
  std::vector<std::uint16_t> values(std::size_t{kWidth} * kHeight * channels);
  for (std::uint16_t& value : values) value = static_cast<std::uint16_t>(random());
  OIIO::ImageSpec spec(kWidth, kHeight, channels, type);
  if (channels == 2) spec.channelnames = {"Y", "A"};
  if (channels % 2 == 0) spec.alpha_channel = channels - 1;
  spec.attribute("oiio:UnassociatedAlpha", 1);
  if (compression) spec.attribute("compression", compression);
  const auto output = OIIO::ImageOutput::create(format);
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput sink(bytes);
  output->set_ioproxy(&sink);
  EXPECT_TRUE(output->open(std::string("picture.") + format, spec)) << output->geterror();
  EXPECT_TRUE(output->write_image(OIIO::TypeDesc::UINT16, values.data())) << output->geterror();
  EXPECT_TRUE(output->close());
  return {bytes.begin(), bytes.end()};
}

class PictureFile : public testing::Test {
 protected:
  TemporaryFolder mFolder;
};

// Promise: "A host's stderr is its own ..."
TEST_F(PictureFile, PngHasTheValuesThatOpenImageIoFinds) {
  for (const int channels : {1, 2, 3, 4})
    for (const OIIO::TypeDesc& type : {OIIO::TypeDesc(OIIO::TypeDesc::UINT8), OIIO::TypeDesc(OIIO::TypeDesc::UINT16)}) {
      const std::filesystem::path path = mFolder.write("a.png", encodedNoise("png", channels, type));
      const DecodedImage image = readPicture(path);
      OIIO::ImageSpec config;
      config.attribute("oiio:UnassociatedAlpha", 1);
      const auto input = OIIO::ImageInput::open(path.string(), &config);
      ASSERT_TRUE(input);
      const OIIO::ImageSpec& spec = input->spec();
      std::vector<float> values(static_cast<std::size_t>(spec.image_pixels()) * static_cast<std::size_t>(channels));
      ASSERT_TRUE(input->read_image(0, 0, 0, channels, OIIO::TypeDesc::FLOAT, values.data()));
      EXPECT_EQ(image.values, values) << channels;
      EXPECT_EQ(image.width, spec.width);
      EXPECT_EQ(image.height, spec.height);
      EXPECT_EQ(image.channels, spec.nchannels);
      EXPECT_EQ(image.alphaChannel, spec.alpha_channel) << channels;
    }
}

/// A host's lines all arrive, and the libraries that decode add none, whatever is wrong with the pictures.
// Promise of reliability.md: "A host's stderr is its own while pictures are decoded"
TEST_F(PictureFile, StderrBelongsToTheHost) {
  const OIIO::TypeDesc byte(OIIO::TypeDesc::UINT8);
  const std::vector<std::string> pictures = {encodedNoise("png", 4, byte),
                                             encodedNoise("png", 1, OIIO::TypeDesc(OIIO::TypeDesc::UINT16)),
                                             encodedNoise("jpeg", 3, byte),
                                             encodedNoise("tiff", 3, byte, "lzw"),
                                             encodedNoise("tiff", 3, byte, "jpeg"),
                                             encodedNoise("tiff", 3, byte, "zip"),
                                             encodedNoise("exr", 3, OIIO::TypeDesc(OIIO::TypeDesc::HALF), "zip"),
                                             encodedNoise("exr", 3, OIIO::TypeDesc(OIIO::TypeDesc::HALF), "piz")};
  testing::internal::CaptureStderr();
  std::atomic<bool> over{false};
  std::string expected;
  std::thread host([&] {
    for (int i = 0; !over; ++i) {
      const std::string line = "line " + std::to_string(i) + " of the host\n";
      expected += line;
      EXPECT_EQ(::write(STDERR_FILENO, line.data(), line.size()), static_cast<ssize_t>(line.size()));
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
  });
  std::mt19937 random(11);
  int refused = 0;
  for (const std::string& picture : pictures)
    for (int round = 0; round < 60; ++round) {
      std::string damaged = picture;
      if (round % 4 == 0) damaged.resize(16 + random() % (damaged.size() - 16));
      for (unsigned i = 0; i <= random() % 5; ++i)
        damaged[16 + random() % (damaged.size() - 16)] = static_cast<char>(random());
      try {
        readPicture(mFolder.write("damaged", damaged));
      } catch (const vdbtools::DataError&) {
        ++refused;
      } catch (const std::exception& error) {
        ADD_FAILURE() << "a damaged file is not said to be one: " << error.what();
      }
    }
  over = true;
  host.join();
  const std::string arrived = testing::internal::GetCapturedStderr();
  // Not EXPECT_EQ(), which would look for the differences of thousands of lines.
  const auto [found, wanted] = std::mismatch(arrived.begin(), arrived.end(), expected.begin(), expected.end());
  EXPECT_TRUE(arrived == expected) << arrived.size() << " bytes in place of " << expected.size()
                                   << ", from here on: " << std::string(found, arrived.end()).substr(0, 200);
  EXPECT_GT(refused, 100);
}

}  // namespace
