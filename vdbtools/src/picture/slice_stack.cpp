// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/picture/slice_image.h"

#include "files/image_module.h"
#include "picture/image_encoder.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/recipe/option_value.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace vdbtools {
namespace {

SliceCodes emptyCodes(const SlicePlane& plane, std::size_t values, int channels, int bits) {
  const auto pixels = static_cast<std::size_t>(plane.width()) * static_cast<std::size_t>(plane.height());
  if (values != pixels)
    throw std::invalid_argument("a layer of " + std::to_string(plane.width()) + " x " + std::to_string(plane.height()) +
                                " pixels needs " + std::to_string(pixels) + " values, not " + std::to_string(values));
  if (bits != 8 && bits != 16) throw std::invalid_argument("a layer has 8 or 16 bits, not " + std::to_string(bits));
  return {.width = plane.width(), .height = plane.height(), .channels = channels, .bits = bits, .codes = {}};
}

constexpr int largestCode(int bits) { return (1 << bits) - 1; }

/// @param share  clamped to 0 to 1
std::uint16_t codeOf(double share, int bits) {
  if (std::isnan(share)) return 0;
  return static_cast<std::uint16_t>(std::clamp(share, 0.0, 1.0) * largestCode(bits) + 0.5);
}

SliceEncoder* findSliceEncoder() {
#ifdef JULIAVDB_IMAGE_MODULE
  return reinterpret_cast<SliceEncoder*>(imageFunction("juliavdbEncodeSlice"));
#else
  return juliavdbEncodeSlice;
#endif
}

}  // namespace

SliceStack::SliceStack(Axis axis, const openvdb::BBoxd& box, int longestSide)
    : mAxis(axis), mBox(box), mLongestSide(longestSide) {
  const auto k = static_cast<int>(axis);
  const double middle = 0.5 * (box.min()[k] + box.max()[k]);
  const SlicePlane first(axis, middle, box, longestSide);
  mVoxelSize = (first.position(1, 0) - first.position(0, 0)).length();
  // Every part of the box must be covered, but a rounding error must not add a row.
  constexpr double kRounding = 1e-9, kMost = 999999;
  const double layers = std::ceil((box.max()[k] - box.min()[k]) / mVoxelSize * (1 - kRounding));
  if (!(layers <= kMost))
    throw std::invalid_argument("a stack of " + shortText(layers) + " layers is too high; it may have " +
                                shortText(kMost));
  mCount = std::max(1, static_cast<int>(layers));
  mFirst = middle - 0.5 * (mCount - 1) * mVoxelSize;
}

SlicePlane SliceStack::plane(int layer) const { return {mAxis, mFirst + layer * mVoxelSize, mBox, mLongestSide}; }

SliceCodes membershipCodes(const SlicePlane& plane, std::span<const float> values, int bits) {
  SliceCodes slice = emptyCodes(plane, values.size(), 1, bits);
  for (const float value : values) slice.codes.push_back(codeOf(value < 0 ? 1 : 0, bits));
  return slice;
}

SliceCodes signedCodes(const SlicePlane& plane, std::span<const float> values, double range, int bits) {
  if (!(range > 0 && std::isfinite(range)))
    throw std::invalid_argument("the range of a stack must be above 0, not " + shortText(range));
  SliceCodes slice = emptyCodes(plane, values.size(), 1, bits);
  for (const float value : values) slice.codes.push_back(codeOf(0.5 * (double{value} / range + 1), bits));
  return slice;
}

SliceCodes countCodes(const SlicePlane& plane, std::span<const int> counts, int bits) {
  SliceCodes slice = emptyCodes(plane, counts.size(), 1, bits);
  for (const int count : counts)
    slice.codes.push_back(static_cast<std::uint16_t>(std::clamp(count, 0, largestCode(bits))));
  return slice;
}

SliceCodes versorCodes(const SlicePlane& plane, std::span<const openvdb::Vec3s> versors, int bits) {
  SliceCodes slice = emptyCodes(plane, versors.size(), 3, bits);
  for (const openvdb::Vec3s& versor : versors)
    for (int k = 0; k < 3; ++k) slice.codes.push_back(codeOf(0.5 * (double{versor[k]} + 1), bits));
  return slice;
}

std::string encodeSlice(const SliceCodes& slice, const SliceVoxels& voxels, const std::string& extension) {
  const std::string format = lowerCase(extension.substr(extension.starts_with('.') ? 1 : 0));
  const bool png = format == "png";
  if (!png && format != "tif" && format != "tiff")
    throw std::invalid_argument("layers cannot be written as \"" + extension + "\"; use png or tif");
  CodedPicture picture{.width = slice.width,
                       .height = slice.height,
                       .channels = slice.channels,
                       .bits = slice.bits,
                       .format = png ? "png" : "tif"};
  std::vector<std::uint8_t> bytes;
  picture.codes = slice.codes.data();
  if (slice.bits == 8) {
    bytes.assign(slice.codes.begin(), slice.codes.end());
    picture.codes = bytes.data();
  }
  constexpr double kMetresOfACentimetre = 0.01;
  if (voxels.unit) {
    const double metres = voxels.size * metresOf(*voxels.unit);
    picture.resolution = (png ? 1 : kMetresOfACentimetre) / metres;
    picture.resolutionUnit = png ? "m" : "cm";
  } else if (!png) {
    picture.resolution = 1 / voxels.size;
    picture.resolutionUnit = "none";
  }
  // ImageJ's words: "inch", and "pixel" for an unknown unit.
  const std::string unit = !voxels.unit ? "pixel" : *voxels.unit == LengthUnit::Inch ? "inch" : nameOf(*voxels.unit);
  const std::string description =
      "ImageJ=1.53\nimages=1\nunit=" + unit + "\nspacing=" + (voxels.unit ? numbersText({voxels.size}) : "1") + "\n";
  if (!png) picture.description = description.c_str();
  static SliceEncoder* const encode = findSliceEncoder();
  picture.threads = imageThreads();
  std::string result;
  if (!encode(picture, result)) throw IoError(result);
  return result;
}

}  // namespace vdbtools
