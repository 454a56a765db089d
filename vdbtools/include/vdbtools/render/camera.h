// SPDX-License-Identifier: Apache-2.0
/// @file camera.h
/// The room `render`: shaded pictures of a level set, by rays through its voxels (preview.h), and of the set of a map,
/// by rays through the map itself (field_render.h). It may use the rooms up to picture: base, files, field and picture
/// are those that it needs.
///
/// This header: the camera of both. The world is right-handed; Y is up unless it is said to be Z.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/up_axis.h"

namespace vdbtools {

struct Camera {
  openvdb::Vec3d eye{0, 0, 5}, lookAt{0, 0, 0};  ///< world units; the two must differ
  /// The direction that is up in the picture. If the view goes along it, (0, 0, -1) takes its place, or (0, 1, 0) if
  /// the view goes along z.
  openvdb::Vec3d up{0, 1, 0};
  double fieldOfView = 30;  ///< degrees, vertical; above 0 and below 180
};

/// Where a camera stands that looks at something, and how much of it fills the picture.
struct ViewAngles {
  double azimuth = -30;     ///< degrees about +Y: 0 looks at the front, from +Z; 90 looks from +X. With Z up,
                            ///< about +Z, and the front is seen from -Y
  double elevation = 15;    ///< degrees above the horizon, -90 to 90
  double fieldOfView = 30;  ///< degrees, vertical, 1 to 150, before the zoom
  double zoom = 1;          ///< magnification, above 0: at 1 the ball around the object touches the frame
};

/// A ball that a camera frames.
struct FramedBall {
  openvdb::Vec3d centre;  ///< world units
  double radius = 0;      ///< world units
};

/// The camera that looks at the ball. At zoom 1 the ball touches the nearer pair of the picture's edges; other values
/// change the field of view and leave the eye where it is.
/// @param aspect  width over height
/// @throw std::invalid_argument  angles out of their ranges
Camera cameraAround(const FramedBall& ball, const ViewAngles& angles, double aspect, UpAxis up = UpAxis::Y);

/// The same camera turned about the axis through its look-at point: a frame of a turntable.
/// @param axis     a direction, world space
/// @param degrees  anticlockwise, seen from the end of the axis
Camera turned(const Camera& camera, const openvdb::Vec3d& axis, double degrees);

}  // namespace vdbtools
