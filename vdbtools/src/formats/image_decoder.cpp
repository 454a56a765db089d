// SPDX-License-Identifier: Apache-2.0
#include "formats/image_decoder.h"

#include "formats/image_threads.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <new>
#include <system_error>

// Of libtiff, which OpenImageIO links to; its headers are not needed for anything else. They are null where OpenImageIO
// was built without it.
extern "C" {
using TiffHandler = void(const char* module, const char* format, std::va_list arguments);
[[gnu::weak]] TiffHandler* TIFFSetErrorHandler(TiffHandler* handler);
[[gnu::weak]] TiffHandler* TIFFSetWarningHandler(TiffHandler* handler);
}

namespace {

thread_local bool isDecoding = false;
TiffHandler *hostsErrors = nullptr, *hostsWarnings = nullptr;

/// Keeps libtiff from printing what is wrong with the files that are decoded here: OpenImageIO 2.4 prevented it,
/// and 2.5, which also takes the messages, does not. What libtiff has to say to the host still arrives there.
class QuietTiff {
 public:
  QuietTiff() {
    [[maybe_unused]] static const bool isSet = set();
    isDecoding = true;
  }
  ~QuietTiff() { isDecoding = false; }
  QuietTiff(const QuietTiff&) = delete;
  QuietTiff& operator=(const QuietTiff&) = delete;

 private:
  static bool set() {
    if (!TIFFSetErrorHandler || !TIFFSetWarningHandler) return false;
    hostsErrors = TIFFSetErrorHandler([](const char* module, const char* format, std::va_list arguments) {
      if (!isDecoding && hostsErrors) hostsErrors(module, format, arguments);
    });
    hostsWarnings = TIFFSetWarningHandler([](const char* module, const char* format, std::va_list arguments) {
      if (!isDecoding && hostsWarnings) hostsWarnings(module, format, arguments);
    });
    return true;
  }
};

/// The bytes of a file. It replaces a reader of OpenImageIO 2.4 that reads before and behind them if a damaged file has
/// a negative or too large offset.
class ByteSource final : public OIIO::Filesystem::IOMemReader {
 public:
  explicit ByteSource(std::string_view bytes) : IOMemReader(bytes.data(), bytes.size()) {}

  bool seek(std::int64_t offset) override {
    if (offset < 0) return false;
    m_pos = offset;
    return true;
  }
  std::size_t read(void* to, std::size_t size) override {
    const std::size_t count = pread(to, size, m_pos);
    m_pos += static_cast<std::int64_t>(count);
    return count;
  }
  std::size_t pread(void* to, std::size_t size, std::int64_t offset) override {
    const std::size_t all = this->size(), begin = static_cast<std::size_t>(offset);
    if (offset < 0 || begin >= all) return 0;
    const std::size_t count = std::min(size, all - begin);
    std::memcpy(to, buffer().data() + begin, count);
    return count;
  }
};

/// What the decoder says is wrong. Those of OpenImageIO 2.5 refuse some damaged files without a word.
std::string errorOf(const OIIO::ImageInput& input) {
  const std::string error = input.geterror();
  return error.empty() ? "it is damaged" : error;
}

constexpr int kMostTilesInRow = 1 << 14;

/// Reads some lines at a time, and stops at a damaged one: OpenImageIO 2.4 would continue, store a message for each,
/// and abort the program when these reach 16 MB.
bool readLines(OIIO::ImageInput& input, const OIIO::ImageSpec& spec, float* values) {
  constexpr int kLines = 64;
  const bool tiled = spec.tile_width > 0 && spec.tile_height > 0;
  const int last = spec.y + spec.height;
  for (int begin = spec.y; begin < last;) {
    const int end = std::min(begin + (tiled ? spec.tile_height : kLines), last);
    const bool good =
        tiled ? input.read_tiles(0, 0, spec.x, spec.x + spec.width, begin, end, spec.z, spec.z + 1, 0, spec.nchannels,
                                 OIIO::TypeDesc::FLOAT, values)
              : input.read_scanlines(0, 0, begin, end, spec.z, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, values);
    // If a part of a TIFF is missing, reading succeeds, and only the message says so.
    if (!good || input.has_error()) return false;
    values += std::ptrdiff_t{end - begin} * spec.width * spec.nchannels;
    begin = end;
  }
  return true;
}

}  // namespace

bool juliavdbDecodeImage(std::string_view bytes, std::string_view format, int threads, double room,
                         vdbtools::DecodedImage& image, std::string& reason) {
  try {
    const QuietTiff quiet;
    vdbtools::useImageThreads(threads);
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);  // colours as in the file, not multiplied by alpha
    ByteSource source(bytes);
    // ImageInput::open() would try the decoders of all formats on a file that its own format's decoder refuses.
    const auto input = OIIO::ImageInput::create(std::string(format));
    OIIO::ImageSpec spec;
    // The name is for messages only; the source supplies the bytes.
    if (!input || !input->set_ioproxy(&source) || !input->open("picture", spec, config)) {
      reason = input ? errorOf(*input) : OIIO::geterror();
      return false;
    }
    const std::uint64_t values =
        static_cast<std::uint64_t>(spec.image_pixels()) * static_cast<std::uint64_t>(spec.nchannels);
    if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.nchannels < 1 || spec.deep ||
        values > vdbtools::kMostPictureValues ||
        (spec.tile_width > 0 && spec.width / spec.tile_width > kMostTilesInRow)) {
      reason = vdbtools::unusableSize(spec.width, spec.height, spec.nchannels);
      return false;
    }
    image.width = spec.width;
    image.height = spec.height;
    image.channels = spec.nchannels;
    image.alphaChannel = spec.alpha_channel;
    if (static_cast<double>(values) * sizeof(float) > room) {
      reason.clear();
      return false;
    }
    image.values.resize(values);
    if (!readLines(*input, spec, image.values.data())) {
      reason = errorOf(*input);
      return false;
    }
    return true;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::system_error&) {
    throw;  // a thread that cannot be started
  } catch (const std::exception& error) {
    reason = error.what();
    return false;
  }
}
