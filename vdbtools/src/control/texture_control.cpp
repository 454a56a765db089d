// SPDX-License-Identifier: Apache-2.0
// A picture through the texture coordinates of the target's mesh, extended off the surface.
#include "control/control_kinds.h"
#include "control/control_lattice.h"

#include "formats/picture_file.h"
#include "vdbtools/base/errors.h"

#include <algorithm>
#include <cmath>

namespace vdbtools {
namespace {

using openvdb::Vec2s;
using openvdb::Vec3d;

constexpr const char* kTextureForm =
    "texture:FILE:LOW:HIGH or texture:FILE:CHANNEL:LOW:HIGH, with a picture whose path has no ':' in it, a channel out "
    "of r, g, b, a and luminance, and two finite numbers, such as texture:mask.png:20:300";

enum class ColourChannel { Red, Green, Blue, Alpha, Luminance };

std::optional<ColourChannel> channelFrom(const std::string& text) {
  if (text == "r") return ColourChannel::Red;
  if (text == "g") return ColourChannel::Green;
  if (text == "b") return ColourChannel::Blue;
  if (text == "a") return ColourChannel::Alpha;
  if (text == "luminance") return ColourChannel::Luminance;
  return std::nullopt;
}

/// One channel of a picture, row by row from the top left.
struct Picture1 {
  int width = 0, height = 0;
  std::vector<float> values;

  float at(int x, int y) const {
    return values[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }

  /// Bilinear between the centres of pixels. (0, 0) is the lower left corner of the picture, which repeats outside
  /// 0..1.
  double read(double u, double v) const {
    const auto within = [](double t) { return t < 0 || t > 1 ? t - std::floor(t) : t; };
    const double x = std::clamp(within(u) * width - 0.5, 0.0, width - 1.0);
    const double y = std::clamp((1 - within(v)) * height - 0.5, 0.0, height - 1.0);
    const int left = static_cast<int>(x), top = static_cast<int>(y);
    const int right = std::min(left + 1, width - 1), bottom = std::min(top + 1, height - 1);
    return std::lerp(std::lerp<double>(at(left, top), at(right, top), x - left),
                     std::lerp<double>(at(left, bottom), at(right, bottom), x - left), y - top);
  }
};

Picture1 channelOf(const DecodedImage& image, ColourChannel channel, const NamedFile& file) {
  if (channel == ColourChannel::Alpha && image.alphaChannel < 0)
    throw DataError(file.path.string() + ": the picture has no alpha channel; use r, g, b or luminance");
  const int colours = image.channels - (image.alphaChannel >= 0 ? 1 : 0);
  const std::size_t channels = static_cast<std::size_t>(image.channels);
  Picture1 picture{image.width, image.height, {}};
  picture.values.reserve(image.values.size() / channels);
  for (std::size_t i = 0; i < image.values.size(); i += channels) {
    const float* pixel = &image.values[i];
    // A grey picture has the same value in all three.
    const float red = pixel[0], green = colours < 3 ? red : pixel[1], blue = colours < 3 ? red : pixel[2];
    switch (channel) {
      case ColourChannel::Red: picture.values.push_back(red); break;
      case ColourChannel::Green: picture.values.push_back(green); break;
      case ColourChannel::Blue: picture.values.push_back(blue); break;
      case ColourChannel::Alpha: picture.values.push_back(pixel[image.alphaChannel]); break;
      case ColourChannel::Luminance:  // ITU-R BT.709
        picture.values.push_back(colours < 3 ? red : 0.2126F * red + 0.7152F * green + 0.0722F * blue);
        break;
    }
  }
  return picture;
}

/// Scales the picture by @a factor; each new pixel is the mean of the old ones, weighted by their overlap.
Picture1 reduced(const Picture1& picture, double factor) {
  const int width = std::max(1, static_cast<int>(std::lround(picture.width / factor)));
  const int height = std::max(1, static_cast<int>(std::lround(picture.height / factor)));
  // Calls use(old, share) along one axis for the old pixels that the new pixel covers, with its share of each.
  const auto forEachPart = [](int at, int count, int old, const auto& use) {
    const double begin = static_cast<double>(at) * old / count, end = static_cast<double>(at + 1) * old / count;
    for (int i = static_cast<int>(begin); i < old && i < end; ++i)
      if (const double share = std::min(i + 1.0, end) - std::max<double>(i, begin); share > 0)
        use(i, share / (end - begin));
  };
  Picture1 narrow{width, picture.height, {}};
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < width; ++x) {
      double sum = 0;
      forEachPart(x, width, picture.width, [&](int i, double share) { sum += share * picture.at(i, y); });
      narrow.values.push_back(static_cast<float>(sum));
    }
  Picture1 result{width, height, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      double sum = 0;
      forEachPart(y, height, picture.height, [&](int i, double share) { sum += share * narrow.at(x, i); });
      result.values.push_back(static_cast<float>(sum));
    }
  return result;
}

/// The average number of the picture's pixels per voxel of the lattice along an axis, over the mesh.
double pixelsPerVoxel(const Mesh& mesh, const Picture1& picture, double voxel) {
  double area = 0, pixels = 0;
  for (std::size_t n = 0; n < mesh.triangles.size(); ++n) {
    const openvdb::Vec3I& t = mesh.triangles[n];
    const Vec3d &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
    area += (b - a).cross(c - a).length() / 2;
    const Vec2s* uv = &mesh.cornerUvs[3 * n];
    const Vec2s first = uv[1] - uv[0], second = uv[2] - uv[0];
    pixels += std::abs(first[0] * second[1] - first[1] * second[0]) / 2;
  }
  pixels *= static_cast<double>(picture.width) * picture.height;
  return area > 0 ? std::sqrt(pixels / area) * voxel : 0;
}

class TextureSource final : public ControlSource {
 public:
  TextureSource(NamedFile file, ColourChannel channel, double low, double high, std::string text)
      : mFile(std::move(file)), mChannel(channel), mLow(low), mHigh(high), mText(std::move(text)) {}
  std::string text() const override { return mText; }
  std::vector<NamedFile> files() const override { return {mFile}; }

  Control bind(const ControlContext& context) const override {
    if (!context.mesh)
      throw DataError(
          "'" + mText +
          "' cannot be used: the target is a VDB, which has no texture coordinates; give the mesh itself as "
          "the target, or use paint:NAME@FILE with a painted mesh");
    const Mesh& mesh = *context.mesh;
    Picture1 picture = channelOf(readPicture(mFile.path), mChannel, mFile);
    requireUvs(mesh);
    const ControlLattice lattice = controlLattice(context);
    // Detail finer than the lattice would appear as noise.
    if (const double pixels = pixelsPerVoxel(mesh, picture, lattice.voxel); pixels > 1)
      picture = reduced(picture, pixels);
    SurfaceValues found = fromSurface(lattice, mesh, 1, [&](const SurfacePoint& point, double* value) {
      const Vec2s* uv = &mesh.cornerUvs[3 * std::size_t{point.triangle}];
      double at[2];
      for (int c = 0; c < 2; ++c)
        at[c] = uv[0][c] + point.weights[1] * (double{uv[1][c]} - uv[0][c]) +
                point.weights[2] * (double{uv[2][c]} - uv[0][c]);
      *value = mLow + (mHigh - mLow) * picture.read(at[0], at[1]);
    });
    std::vector<float> values = std::move(found.values[0]);
    smooth(lattice, values);
    return Control(latticeField(lattice, std::move(values)));
  }

 private:
  NamedFile mFile;
  ColourChannel mChannel;
  double mLow, mHigh;  ///< the values that 0 and 1 become
  std::string mText;
};

}  // namespace

ControlSourcePtr parseTextureControl(const RecipeReader& reader, const std::string& option) {
  const std::string text = reader.text(option);
  const std::optional<std::string> rest = afterPrefix(text, "texture:");
  if (!rest) return nullptr;
  const std::vector<std::string> parts = split(*rest, ':');
  if ((parts.size() != 3 && parts.size() != 4) || parts[0].empty()) reader.refuse(option, kTextureForm);
  const std::optional<ColourChannel> channel = parts.size() == 4 ? channelFrom(parts[1]) : ColourChannel::Luminance;
  const std::optional<double> low = finiteNumber(parts[parts.size() - 2]), high = finiteNumber(parts.back());
  if (!channel || !low || !high) reader.refuse(option, kTextureForm);
  return std::make_shared<TextureSource>(reader.file(option, parts[0]), *channel, *low, *high, text);
}

}  // namespace vdbtools
