// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/scene/scene.h"

#include <algorithm>

namespace vdbtools {

openvdb::BBoxd sliceFrame(const Scene& scene) {
  constexpr double kAir = 0.08;  // of the target's longest side
  if (scene.options.lattice.box) return *scene.options.lattice.box;
  if (!scene.target) return scene.region();
  openvdb::BBoxd box = scene.target->distances.box;
  const openvdb::Vec3d extents = box.extents();
  box.expand(kAir * std::max({extents[0], extents[1], extents[2]}));
  return box;
}

}  // namespace vdbtools
