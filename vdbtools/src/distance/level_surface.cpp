// SPDX-License-Identifier: Apache-2.0
#include "distance/level_surface.h"

#include <openvdb/tools/VolumeToMesh.h>

namespace vdbtools {

LevelSurface levelSurface(const openvdb::FloatGrid& grid, double isovalue) {
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec4I> quads;
  openvdb::tools::volumeToMesh(grid, points, quads, isovalue);
  LevelSurface surface;
  surface.points.assign(points.begin(), points.end());
  surface.triangles.reserve(2 * quads.size());
  for (const openvdb::Vec4I& q : quads) {
    surface.triangles.emplace_back(q[0], q[1], q[2]);
    surface.triangles.emplace_back(q[0], q[2], q[3]);
  }
  return surface;
}

}  // namespace vdbtools
