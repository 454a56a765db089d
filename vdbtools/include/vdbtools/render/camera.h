// SPDX-License-Identifier: Apache-2.0
/// @file camera.h
/// The room `render` makes shaded pictures of a level set, by rays through its voxels (preview.h), and of the set of a
/// map, by rays through the map itself (field_render.h). It may use the rooms up to picture, and needs base, files,
/// field and picture.
///
/// This header declares the camera of both. The world is right-handed; Y is up unless Z is specified.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/units.h"

namespace vdbtools {

struct Camera {
  openvdb::Vec3d eye{0, 0, 5}, lookAt{0, 0, 0};  ///< world units; the two must differ
  /// The direction that is up in the picture. If the view direction is parallel to it, (0, 0, -1) replaces it, or (0,
  /// 1, 0) if the view is along z.
  openvdb::Vec3d up{0, 1, 0};
  double fieldOfView = 30;  ///< degrees, vertical; above 0 and below 180
};

/// The direction of a camera that looks at an object, and how much of the object fills the picture.
struct ViewAngles {
  double azimuth = -30;     ///< degrees about +Y: 0 looks at the front, from +Z; 90 looks from +X. With Z up,
                            ///< about +Z, and the front is seen from -Y
  double elevation = 15;    ///< degrees above the horizon, -90 to 90
  double fieldOfView = 30;  ///< degrees, vertical, 1 to 150, before the zoom
  double zoom = 1;          ///< magnification, above 0; at 1 the ball around the object touches the frame
};

/// A ball that a camera frames.
struct FramedBall {
  openvdb::Vec3d centre;  ///< world units
  double radius = 0;      ///< world units
};

/// Returns the camera that looks at the ball. At zoom 1 the ball touches the nearer pair of the picture's edges; other
/// values change the field of view and do not move the eye.
/// @param aspect  width over height
/// @throw std::invalid_argument  angles out of their ranges
Camera cameraAround(const FramedBall& ball, const ViewAngles& angles, double aspect, UpAxis up = UpAxis::Y);

/// Returns the camera turned about the axis through its look-at point, for a frame of a turntable.
/// @param axis     a direction, world space
/// @param degrees  anticlockwise, seen from the tip of the axis
Camera turned(const Camera& camera, const openvdb::Vec3d& axis, double degrees);

}  // namespace vdbtools
