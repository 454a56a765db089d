// SPDX-License-Identifier: Apache-2.0
/// @file slice_frame.h
/// What a picture of a plane through a scene shows.
#pragma once

#include "vdbtools/scene/scene.h"

namespace vdbtools {

/// The scene's box, or its target with some air, world units. A plane shows the rectangle that it cuts out of this.
openvdb::BBoxd sliceFrame(const Scene& scene);

}  // namespace vdbtools
