// SPDX-License-Identifier: Apache-2.0
/// @file slice_stack.h
/// Stacks of slices: the values of a field at the centres of cubic voxels, as one grey picture for each layer. The
/// numbers are data for other programs, not colours, so there is no gradient, no line at the surface and no transfer
/// function.
#pragma once

#include "vdbtools/base/length_unit.h"
#include "vdbtools/picture/slice_image.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdbtools {

/// The layers of a box along an axis. They are as far apart as the pixels of a layer are wide, and cover the box.
class SliceStack {
 public:
  /// @throw std::invalid_argument  as SlicePlane(), or more layers than a name of 6 digits can count
  SliceStack(Axis axis, const openvdb::BBoxd& box, int longestSide);

  int count() const { return mCount; }
  double voxelSize() const { return mVoxelSize; }  ///< world units
  /// Layer 0 has the lowest coordinate on the axis.
  SlicePlane plane(int layer) const;

 private:
  Axis mAxis;
  openvdb::BBoxd mBox;
  int mLongestSide, mCount = 0;
  double mVoxelSize = 0, mFirst = 0;
};

/// The numbers of one layer, row by row from the top left.
struct SliceCodes {
  int width = 0, height = 0, channels = 1;
  int bits = 8;                      ///< 8 or 16; a code is at most 2^bits - 1
  std::vector<std::uint16_t> codes;  ///< interleaved channels
};

// All take one value for each pixel of the plane; @a bits is 8 or 16.

/// The largest code inside (value < 0), 0 outside.
SliceCodes membershipCodes(const SlicePlane& plane, std::span<const float> values, int bits);
/// From 0 at -range to the largest code at +range; values beyond are clamped, and a NaN is 0.
/// @throw std::invalid_argument  a range that is not above 0
SliceCodes signedCodes(const SlicePlane& plane, std::span<const float> values, double range, int bits);
/// The counts themselves, at most the largest code.
SliceCodes countCodes(const SlicePlane& plane, std::span<const int> counts, int bits);
/// Three channels, from 0 at -1 to the largest code at 1.
SliceCodes versorCodes(const SlicePlane& plane, std::span<const openvdb::Vec3s> versors, int bits);

/// The size of the voxels of a stack.
struct SliceVoxels {
  double size = 1;                   ///< world units
  std::optional<LengthUnit> unit{};  ///< the unit of the size; empty: unknown
};

/// Encodes a layer as the bytes of a PNG or a TIFF. If the unit of the voxels is known, the file's resolution is their
/// number per centimetre (TIFF) or per metre (PNG). If it is not, a TIFF has a resolution without a unit, and a PNG has
/// none. The description of a TIFF gives the unit and the distance between layers in the form that ImageJ and Fiji
/// read. The same layer gives the same bytes.
/// @param extension  png, tif or tiff, with or without its dot
/// @throw std::invalid_argument  another extension
/// @throw IoError                OpenImageIO cannot encode it
std::string encodeSlice(const SliceCodes& slice, const SliceVoxels& voxels, const std::string& extension);

}  // namespace vdbtools
