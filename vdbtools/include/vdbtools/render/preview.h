// SPDX-License-Identifier: Apache-2.0
/// @file preview.h
/// Renders a shaded picture of a level set, which the camera frames automatically: rays that skip empty space, a key
/// light with soft shadows, and skylight gathered by ambient rays. The surface is where the sign changes, so fields
/// whose gradient is far from 1 show no holes.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/picture/image.h"
#include "vdbtools/render/camera.h"
#include "vdbtools/render/look.h"
#include "vdbtools/render/shaded_image.h"

#include <optional>
#include <set>
#include <vector>

namespace vdbtools {

/// A mark in the picture, such as a root of a map. A ball inside the object shows through the surface.
struct PreviewBall {
  openvdb::Vec3d centre;  ///< world units
  double radius = 0;      ///< world units, > 0
  Colour colour{};
};

struct PreviewOptions {
  int width = 800;   ///< pixels
  int height = 800;  ///< pixels
  int samples = 4;   ///< rays per pixel: 1, 4, 9 or 16; twice as many where the pixel is rough
  ViewAngles view;
  UpAxis up = UpAxis::Y;  ///< the world's up axis; the picture and its lights are upright
  /// Replaces the camera that follows from the view and the axis; the lights are upright with respect to its own up.
  std::optional<Camera> camera{};
  Look look{};
  std::set<Pass> passes{Pass::Beauty};  ///< every pass is possible except Pass::Trap
  std::vector<PreviewBall> balls;
};

/// Renders the picture, which is the same for any number of threads. Colours lie near [0, 1].
/// @throw std::invalid_argument  options out of their ranges
/// @throw DataError              the grid is not a level set, its voxels are not cubes, or it has no surface
/// @throw Interrupted
ShadedImage renderPreview(const openvdb::FloatGrid& levelSet, const PreviewOptions& options, Monitor& monitor);

// Renders a shaded picture of a mesh, with the same light and camera, by rays through its triangles.
//
// Both sides of a triangle look the same, so a mesh may be open, a soup, or oriented in any way. The normal at a point
// is averaged over the triangles there that differ little from the visible one, so edges stay sharp.

struct MeshPreviewOptions {
  PreviewOptions picture;
  /// Whether the mesh's attributes red, green and blue (sRGB, 0 to 1) colour it. Points without these numbers, and
  /// meshes that lack one of the three, have the colour of clay.
  bool colours = true;
};

/// Renders the picture, which is the same for any number of threads and on any machine.
/// @param mesh  is welded if its triangles share few points
/// @throw std::invalid_argument  options out of their ranges
/// @throw DataError              no triangle has an extent, an index is out of range, or a coordinate is not finite
/// @throw Interrupted
ShadedImage renderMeshPreview(Mesh mesh, const MeshPreviewOptions& options, Monitor& monitor);

}  // namespace vdbtools
