// SPDX-License-Identifier: Apache-2.0
/// @file slice_frame.h
/// The part of a scene that a picture of a plane shows.
#pragma once

#include "vdbtools/scene/scene.h"

namespace vdbtools {

/// The scene's box, or its target with a margin, world units. A picture shows the rectangle that its plane cuts out of
/// this box.
openvdb::BBoxd sliceFrame(const Scene& scene);

}  // namespace vdbtools
