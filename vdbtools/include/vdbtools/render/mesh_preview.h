// SPDX-License-Identifier: Apache-2.0
/// @file mesh_preview.h
/// Renders a shaded picture of a mesh, in the light and with the camera of preview.h, by rays through its triangles.
///
/// Both sides of a triangle look the same, so a mesh may be open, a soup, or oriented in any way. The normal at a point
/// is averaged over the triangles there that differ little from the visible one, so edges stay sharp.
#pragma once

#include "vdbtools/mesh/mesh.h"
#include "vdbtools/render/preview.h"

namespace vdbtools {

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
