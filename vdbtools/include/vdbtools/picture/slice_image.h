// SPDX-License-Identifier: Apache-2.0
/// @file slice_image.h
/// Pictures of fields on an axis-aligned plane, as in [SK23] Figs. 2 and 9. The caller samples a field at
/// SlicePlane::position() of every pixel; these functions turn the values into colours.
#pragma once

#include "vdbtools/base/units.h"
#include "vdbtools/picture/canvas.h"
#include "vdbtools/picture/image.h"

#include <openvdb/Types.h>
#include <openvdb/math/BBox.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdbtools {

// All functions take one value for each pixel of the plane, row by row from the top left, and throw
// std::invalid_argument for any other number of values.

enum class Axis { X = 0, Y = 1, Z = 2 };

/// Pixels along the longer side of a picture of a plane: Cairo draws no line beyond.
inline constexpr int kMostSlicePixels = 32768;

/// A raster over a rectangle of the plane where coordinate @a axis equals @a position, seen from the positive end of
/// the axis. For Z, +x points right and +y up; for Y, +x right and +z down; for X, -z right and +y up. The view is
/// always right-handed, and world Y is up if it lies in the plane.
class SlicePlane {
 public:
  /// Frames @a box (world units) with square pixels, @a longestSide of them along the longer side.
  /// @throw std::invalid_argument  longestSide < 1, a position that is not finite, or a box without extent in the plane
  SlicePlane(Axis axis, double position, const openvdb::BBoxd& box, int longestSide);

  int width() const { return mWidth; }
  int height() const { return mHeight; }
  /// The world position of a pixel's centre; (0, 0) is top left.
  openvdb::Vec3d position(int x, int y) const;
  /// The projection of a world position on the plane, in pixels from the picture's top left corner: the centre of pixel
  /// (0, 0) is (0.5, 0.5).
  CanvasPoint project(const openvdb::Vec3d& world) const;
  /// Intersects the plane with a sphere. @param centre, radius  of the sphere, world units. @return the radius of the
  /// circle of intersection in pixels; 0 if there is none
  double circle(const openvdb::Vec3d& centre, double radius) const;

 private:
  openvdb::Vec3d mTopLeft, mRight, mDown;  ///< world position of pixel (0, 0), and the steps per pixel
  int mWidth = 0, mHeight = 0;
};

/// The first step of a point's orbit, world units.
struct SliceArrow {
  openvdb::Vec3d from, to;
  openvdb::Vec3d centre;  ///< the origin of the dynamics
  double radius = 0;      ///< radius of the ball about the centre on which the step ends, world units
  bool inside = false;    ///< whether the point belongs to the set
};

/// Maps a signed scalar (phi, E, F) to a perceptually uniform diverging gradient: blue inside (negative), white at 0,
/// red outside. The zero set is a thin dark line. Values beyond +-range, including infinities, are clamped; a NaN is
/// grey.
/// @param range  0 or less: the 95th percentile of |v| is used
Image signedSlice(const SlicePlane& plane, std::span<const float> values, double range);

/// Maps membership to colours: black inside (value < 0), white outside.
Image membershipSlice(const SlicePlane& plane, std::span<const float> values);

/// Maps counts, such as the steps of an orbit, to greys from 0 (white) to @a most (black), in equal steps of sRGB.
/// @throw std::invalid_argument  most < 1
Image countSlice(const SlicePlane& plane, std::span<const int> counts, int most);

/// Maps the imaginary components of a versor from [-1, 1] to sRGB in [0, 1] ([SK23] Fig. 2).
Image versorSlice(const SlicePlane& plane, std::span<const openvdb::Vec3s> versors);

/// Draws each arrow, projected on the plane, from a dot at its start to its end, and the circle in which the plane cuts
/// the ball on which the arrow ends: white if the point is inside, black if not ([SK23] Fig. 3).
/// @param image  the picture of the plane; the result has the 256 levels of sRGB
Image withArrows(const SlicePlane& plane, const Image& image, std::span<const SliceArrow> arrows);

// Stacks of slices: the values of a field at the centres of cubic voxels, as one grey picture for each layer. The
// numbers are data for other programs, not colours, so there is no gradient, no line at the surface and no transfer
// function.

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
