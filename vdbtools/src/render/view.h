// SPDX-License-Identifier: Apache-2.0
/// @file view.h
/// The common parts of the two renderers except the camera: its frame, the rays of a pixel and the background.
#pragma once

#include "vdbtools/picture/image.h"
#include "vdbtools/render/camera.h"

#include <array>
#include <cmath>

namespace vdbtools {

/// The directions of a camera, of length 1, in world space.
struct CameraFrame {
  openvdb::Vec3d right, up, forward;
  double tangent = 0;  ///< tangent of half the vertical field of view
};

/// @throw std::invalid_argument  angles out of their ranges
void requireAngles(const ViewAngles& angles);

/// @throw std::invalid_argument  the eye is at the look-at point, or a number is not finite or out of its range
CameraFrame frameOf(const Camera& camera);

/// The rays of a picture: a lattice of n x n in each pixel. A rough pixel gets as many again, one in each row and in
/// each column of the n^2 x n^2 parts of the pixel (K. Chiu, P. Shirley, C. Wang, "Multi-jittered sampling", Graphics
/// Gems IV, 1994), so that its edges are sampled at other heights.
class PixelSamples {
 public:
  /// @throw std::invalid_argument  a side that is not 1 to 32768, samples that are not 1, 4, 9 or 16
  PixelSamples(int width, int height, int samples);

  double aspect() const { return static_cast<double>(mWidth) / mHeight; }
  /// The number of samples of a smooth pixel. A rough one has twice as many.
  int usual() const { return mGrid * mGrid; }

  /// The position of sample @a s of a pixel in the picture: u to the right and v up, from -1 to 1.
  /// @param s  below 2 * usual()
  std::array<double, 2> at(int x, int y, int s) const {
    const bool isMore = s >= usual();
    const int i = isMore ? s - usual() : s, column = i % mGrid, row = i / mGrid;
    const double right = isMore ? (row + 0.5) / mGrid : 0.5, down = isMore ? (mGrid - column - 0.5) / mGrid : 0.5;
    return {2 * (x + (column + right) / mGrid) / mWidth - 1, 1 - 2 * (y + (row + down) / mGrid) / mHeight};
  }

 private:
  int mWidth, mHeight;
  int mGrid;  ///< samples along the side of a pixel
};

/// The neutral background at (u, v): lighter at the top, darker towards the corners.
inline openvdb::Vec3d background(double u, double v) {
  constexpr double kTop = 0.86, kBottom = 0.64, kVignette = 0.10;
  return openvdb::Vec3d(std::lerp(kBottom, kTop, 0.5 * (v + 1)) - kVignette * 0.5 * (u * u + v * v));
}

inline Colour toColour(const openvdb::Vec3d& rgb) {
  return {static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2])};
}

/// Throws the std::invalid_argument "render: NAME must be DOMAIN, not VALUE" unless @a good.
void requireOption(bool good, const char* name, double value, const char* domain);

}  // namespace vdbtools
