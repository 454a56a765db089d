// SPDX-License-Identifier: Apache-2.0
/// @file preview.h
/// A shaded picture of a level set, framed by itself: rays through OpenVDB's hierarchical DDA, a key light with a soft
/// shadow, and a sky gathered by ambient rays. The surface is where the sign changes, so that fields whose gradient is
/// far from 1 have no holes. World Y is up.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/picture/image.h"

#include <array>
#include <vector>

namespace vdbtools {

/// A mark in the picture, such as a root of a map. One that lies within the object shows through its surface.
struct PreviewBall {
  openvdb::Vec3d centre;          ///< world units
  double radius = 0;              ///< world units, > 0
  std::array<float, 3> colour{};  ///< linear RGB
};

struct PreviewOptions {
  int width = 800;          ///< pixels
  int height = 800;         ///< pixels
  double azimuth = -30;     ///< degrees about +Y: 0 looks at the front, from +Z; 90 looks from +X
  double elevation = 15;    ///< degrees above the horizon, -90 to 90
  double fieldOfView = 30;  ///< degrees, vertical, 1 to 150
  int samples = 4;          ///< rays a pixel: 1, 4, 9 or 16
  double zoom = 1;          ///< magnification: at 1 the ball around the object touches the frame
  std::vector<PreviewBall> balls;
};

/// The same picture for any number of threads. Colours lie near [0, 1]; the background is neutral.
/// @throw std::invalid_argument  sizes or angles out of their domain
/// @throw DataError              not a level set, its voxels are no cubes, or it has no surface
/// @throw Interrupted
Image renderPreview(const openvdb::FloatGrid& levelSet, const PreviewOptions& options, Monitor& monitor);

}  // namespace vdbtools
