// SPDX-License-Identifier: Apache-2.0
#include "formats/image_decoder.h"

#include <OpenImageIO/imageio.h>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <exception>
#include <fstream>
#include <mutex>
#include <string_view>

namespace {

/// Keeps libpng from printing its errors and warnings, of which OpenImageIO 2.4 lets some through, for as long as it
/// lives. The process has one stderr, so only one of these exists at a time.
class QuietStderr {
 public:
  QuietStderr() : mLock(mutex()) {
    std::fflush(stderr);
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (nowhere < 0) return;
    mKept = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 0);
    if (mKept >= 0) dup2(nowhere, STDERR_FILENO);
    close(nowhere);
  }
  ~QuietStderr() {
    if (mKept < 0) return;
    std::fflush(stderr);
    dup2(mKept, STDERR_FILENO);
    close(mKept);
  }
  QuietStderr(const QuietStderr&) = delete;
  QuietStderr& operator=(const QuietStderr&) = delete;

 private:
  static std::mutex& mutex() {
    static std::mutex mutex;
    return mutex;
  }
  std::scoped_lock<std::mutex> mLock;
  int mKept = -1;
};

/// Values of a picture: 4 GB. A damaged header can announce anything.
constexpr std::uint64_t kMostValues = std::uint64_t{1} << 30;

/// How OpenImageIO calls the format that a file begins like; "": none that is read.
std::string formatOf(const std::string& path) {
  struct Beginning {
    std::string_view bytes;
    const char* format;
  };
  using namespace std::literals;
  constexpr std::array kBeginnings = {Beginning{"\x89PNG\r\n\x1a\n"sv, "png"},
                                      Beginning{"\xff\xd8\xff"sv, "jpeg"},
                                      Beginning{"II*\0"sv, "tiff"},
                                      Beginning{"MM\0*"sv, "tiff"},
                                      Beginning{"II+\0"sv, "tiff"},
                                      Beginning{"MM\0+"sv, "tiff"},
                                      Beginning{"\x76\x2f\x31\x01"sv, "openexr"}};
  std::array<char, 8> bytes{};
  std::ifstream stream(path, std::ios::binary);
  stream.read(bytes.data(), bytes.size());
  const std::string_view found(bytes.data(), static_cast<std::size_t>(stream.gcount()));
  const auto it = std::find_if(kBeginnings.begin(), kBeginnings.end(),
                               [&](const Beginning& beginning) { return found.starts_with(beginning.bytes); });
  return it == kBeginnings.end() ? "" : it->format;
}

}  // namespace

bool juliavdbDecodeImage(const std::string& path, double room, vdbtools::DecodedImage& image, std::string& reason) {
  try {
    const QuietStderr quiet;
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);  // colours as they are in the file, not multiplied by alpha
    // ImageInput::open() would try the decoders of all formats on a file that the one for its name refuses.
    const std::string format = formatOf(path);
    if (format.empty()) {
      reason = "it is of another format";
      return false;
    }
    const auto input = OIIO::ImageInput::create(format);
    OIIO::ImageSpec spec;
    if (!input || !input->open(path, spec, config)) {
      reason = input ? input->geterror() : OIIO::geterror();
      return false;
    }
    const std::uint64_t values =
        static_cast<std::uint64_t>(spec.image_pixels()) * static_cast<std::uint64_t>(spec.nchannels);
    if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.nchannels < 1 || spec.deep ||
        values > kMostValues) {
      reason = "a picture of " + std::to_string(spec.width) + " x " + std::to_string(spec.height) + " pixels and " +
               std::to_string(spec.nchannels) + " channels cannot be used";
      return false;
    }
    image.width = spec.width;
    image.height = spec.height;
    image.channels = spec.nchannels;
    image.alphaChannel = spec.alpha_channel;
    image.isLinear = format == "openexr";
    if (static_cast<double>(values) * sizeof(float) > room) {
      reason.clear();
      return false;
    }
    image.values.resize(values);
    // Where a part of a TIFF is missing, reading goes well, and says so only in the message.
    if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, image.values.data()) || input->has_error()) {
      reason = input->geterror();
      return false;
    }
    return true;
  } catch (const std::exception& error) {
    reason = error.what();
    return false;
  }
}
