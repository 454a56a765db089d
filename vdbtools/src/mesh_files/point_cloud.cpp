// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/mesh_files/mesh_reader.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace vdbtools {

Mesh asPoints(Mesh mesh) {
  mesh.cornerUvs.clear();
  mesh.triangles.clear();
  mesh.triangles.reserve(mesh.points.size());
  for (std::uint32_t p = 0; p < mesh.points.size(); ++p) mesh.triangles.emplace_back(p, p, p);
  return mesh;
}

double pointSpacing(const std::vector<openvdb::Vec3d>& points) {
  constexpr std::size_t kMostAsked = 255;
  if (points.size() < 2) return 0;
  const std::size_t asked = std::min(kMostAsked, points.size());
  std::vector<double> nearest(asked, std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < asked; ++i) {
    const std::size_t self = i * points.size() / asked;
    for (std::size_t p = 0; p < points.size(); ++p)
      if (p != self) nearest[i] = std::min(nearest[i], (points[p] - points[self]).lengthSqr());
  }
  const auto middle = nearest.begin() + static_cast<std::ptrdiff_t>(asked / 2);
  std::nth_element(nearest.begin(), middle, nearest.end());
  return std::sqrt(*middle);
}

}  // namespace vdbtools
