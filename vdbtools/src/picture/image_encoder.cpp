// SPDX-License-Identifier: Apache-2.0
#include "picture/image_encoder.h"

#include "formats/image_threads.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <exception>
#include <new>
#include <system_error>
#include <vector>

namespace {

using vdbtools::kImageChannels;

constexpr const char* kNoDate = "1970:01:01 00:00:00";

bool encode(const OIIO::ImageSpec& spec, const float* values, std::string& result) {
  const auto output = OIIO::ImageOutput::create("exr");
  if (!output) {
    result = "OpenImageIO was built without EXR: " + OIIO::geterror();
    return false;
  }
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput sink(bytes);
  output->set_ioproxy(&sink);
  // The name only determines the format; the bytes go to the sink.
  const bool written = output->open("picture.exr", spec) && output->write_image(OIIO::TypeDesc::FLOAT, values);
  if (!output->close() || !written) {
    result = std::string("cannot encode the image: ") + output->geterror();
    return false;
  }
  result.assign(bytes.begin(), bytes.end());
  return true;
}

}  // namespace

bool juliavdbEncodeImage(const vdbtools::Picture& picture, std::string& result) {
  try {
    vdbtools::useImageThreads(picture.threads);
    OIIO::ImageSpec spec(picture.width, picture.height, picture.channels, OIIO::TypeDesc::HALF);
    if (picture.channels > kImageChannels) {
      spec.channelnames = {"R", "G", "B"};
      spec.channelformats.assign(kImageChannels, OIIO::TypeDesc::HALF);
      for (int extra = 0; extra < picture.channels - kImageChannels; ++extra) {
        const std::string name = picture.names[extra];
        if (name == "A") spec.alpha_channel = kImageChannels + extra;
        if (name == "Z") spec.z_channel = kImageChannels + extra;
        spec.channelnames.push_back(name);
        spec.channelformats.emplace_back(OIIO::TypeDesc::FLOAT);
      }
    }
    spec.attribute("oiio:ColorSpace", "Linear");
    spec.attribute("compression", "zip");
    // By default OpenImageIO writes the current time, and the same image would give different bytes each time.
    spec.attribute("DateTime", kNoDate);
    return encode(spec, picture.linear, result);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::system_error&) {
    throw;  // a thread that cannot be started
  } catch (const std::exception& error) {
    result = std::string("cannot encode the image: ") + error.what();
    return false;
  }
}
