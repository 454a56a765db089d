// SPDX-License-Identifier: Apache-2.0
#include "mesh_files/usable_points.h"

#include "vdbtools/base/errors.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace vdbtools {
namespace {

bool isUsable(const openvdb::Vec3d& point) { return point.isFinite(); }

}  // namespace

void leaveOutUnusable(const std::filesystem::path& path, Mesh& mesh, std::uint64_t firstNumber) {
  if (std::all_of(mesh.points.begin(), mesh.points.end(), isUsable)) return;
  for (const openvdb::Vec3I& triangle : mesh.triangles)
    for (int corner = 0; corner < 3; ++corner)
      for (int axis = 0; axis < 3; ++axis)
        if (const double value = mesh.points[triangle[corner]][axis]; !std::isfinite(value))
          throw DataError(path.string() + ": vertex " + std::to_string(firstNumber + triangle[corner]) +
                          ": the coordinate " + "xyz"[axis] + " is " + std::to_string(value) +
                          "; repair the mesh and export it again");
  std::vector<std::uint32_t> numbers(mesh.points.size());  // of a point among those that stay
  std::uint32_t kept = 0;
  for (std::size_t p = 0; p < mesh.points.size(); ++p) {
    numbers[p] = kept;
    if (!isUsable(mesh.points[p])) continue;
    mesh.points[kept] = mesh.points[p];
    for (VertexAttribute& attribute : mesh.attributes) attribute.values[kept] = attribute.values[p];
    ++kept;
  }
  mesh.pointsLeftOut += mesh.points.size() - kept;
  mesh.points.resize(kept);
  for (VertexAttribute& attribute : mesh.attributes) attribute.values.resize(kept);
  for (openvdb::Vec3I& triangle : mesh.triangles)
    for (int corner = 0; corner < 3; ++corner) triangle[corner] = numbers[triangle[corner]];
}

}  // namespace vdbtools
