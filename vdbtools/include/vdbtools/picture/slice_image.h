// SPDX-License-Identifier: Apache-2.0
/// @file slice_image.h
/// Pictures of fields on an axis-aligned plane, as in [SK23] Figs. 2 and 9. Whoever has a field samples it at
/// SlicePlane::position() of every pixel; these functions give the values their colours.
#pragma once

#include "vdbtools/picture/image.h"

#include <openvdb/Types.h>
#include <openvdb/math/BBox.h>

#include <span>

namespace vdbtools {

// The values come row by row from the top left, one for each pixel of the plane; another number of them is a
// std::invalid_argument.

enum class Axis { X = 0, Y = 1, Z = 2 };

/// A raster over a rectangle of the plane where coordinate @a axis equals @a position. Looking down the axis, from its
/// positive end: for Z, +x runs right and +y up; for Y, +x right and +z down; for X, -z right (so +z left) and +y up:
/// always a right-handed view, with world Y up where it lies in the plane.
class SlicePlane {
 public:
  /// Frames @a box (world units), with pixels square: @a longestSide pixels along the longer side of the rectangle.
  /// @throw std::invalid_argument  longestSide < 1, a position that is not finite, or a box without extent in the plane
  SlicePlane(Axis axis, double position, const openvdb::BBoxd& box, int longestSide);

  int width() const { return mWidth; }
  int height() const { return mHeight; }
  /// The world position of a pixel's centre; (0, 0) is top left.
  openvdb::Vec3d position(int x, int y) const;

 private:
  openvdb::Vec3d mTopLeft, mRight, mDown;  ///< world position of pixel (0, 0), world steps a pixel
  int mWidth = 0, mHeight = 0;
};

/// A signed scalar (phi, E, F): a perceptually even diverging map, blue inside (negative), white at 0, red outside,
/// with values beyond +-range clamped, and the zero set drawn as a thin dark line. range <= 0 takes the 95th percentile
/// of |v|. Infinities clamp; a NaN is grey.
Image signedSlice(const SlicePlane& plane, std::span<const float> values, double range);

/// Membership: black inside (value < 0), white outside.
Image membershipSlice(const SlicePlane& plane, std::span<const float> values);

/// Counts from 0 (white) to @a most (black), such as the steps of an orbit, in even steps of sRGB.
/// @throw std::invalid_argument  most < 1
Image countSlice(const SlicePlane& plane, std::span<const int> counts, int most);

/// The imaginary components of a versor, from [-1, 1] to sRGB in [0, 1] ([SK23] Fig. 2).
Image versorSlice(const SlicePlane& plane, std::span<const openvdb::Vec3s> versors);

}  // namespace vdbtools
