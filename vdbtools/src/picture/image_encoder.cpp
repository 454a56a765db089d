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

/// @param name  determines the format only; the bytes go to @a result
bool encode(const std::string& name, const OIIO::ImageSpec& spec, OIIO::TypeDesc type, const void* values,
            std::string& result) {
  const auto output = OIIO::ImageOutput::create(name);
  if (!output) {
    result = "OpenImageIO cannot write '" + name + "': " + OIIO::geterror();
    return false;
  }
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput sink(bytes);
  output->set_ioproxy(&sink);
  const bool written = output->open(name, spec) && output->write_image(type, values);
  if (!output->close() || !written) {
    result = std::string("cannot encode the image: ") + output->geterror();
    return false;
  }
  result.assign(bytes.begin(), bytes.end());
  return true;
}

/// Runs @a encode, and turns its failures into a message.
template <class Encode>
bool encoding(std::string& result, const Encode& encode) {
  try {
    return encode();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::system_error&) {
    throw;  // a thread that cannot be started
  } catch (const std::exception& error) {
    result = std::string("cannot encode the image: ") + error.what();
    return false;
  }
}

}  // namespace

bool juliavdbEncodeImage(const vdbtools::Picture& picture, std::string& result) {
  return encoding(result, [&] {
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
    return encode("picture.exr", spec, OIIO::TypeDesc::FLOAT, picture.linear, result);
  });
}

bool juliavdbEncodeSlice(const vdbtools::CodedPicture& picture, std::string& result) {
  return encoding(result, [&] {
    vdbtools::useImageThreads(picture.threads);
    const OIIO::TypeDesc type = picture.bits == 8 ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::UINT16;
    OIIO::ImageSpec spec(picture.width, picture.height, picture.channels, type);
    spec.attribute("compression", "zip");
    spec.attribute("DateTime", kNoDate);
    if (picture.resolution > 0) {
      spec.attribute("XResolution", static_cast<float>(picture.resolution));
      spec.attribute("YResolution", static_cast<float>(picture.resolution));
      spec.attribute("ResolutionUnit", picture.resolutionUnit);
    }
    if (picture.description) spec.attribute("ImageDescription", picture.description);
    return encode(std::string("layer.") + picture.format, spec, type, picture.codes, result);
  });
}
