// SPDX-License-Identifier: Apache-2.0
#include "decimation/simplify.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <type_traits>

namespace vdbtools {
namespace {

using Triangles = std::span<const openvdb::Vec3I>;

/// Six times the enclosed volume of a closed surface; meaningless for others.
double volumeOf(std::span<const float> positions, Triangles triangles) {
  if (triangles.empty()) return 0;
  const auto point = [&](unsigned index) {
    return openvdb::Vec3d(positions[3 * std::size_t{index}], positions[3 * std::size_t{index} + 1],
                          positions[3 * std::size_t{index} + 2]);
  };
  const openvdb::Vec3d origin = point(triangles.front()[0]);  // far from 0, digits would be lost
  double volume = 0;
  for (const openvdb::Vec3I& corners : triangles)
    volume += (point(corners[0]) - origin).dot((point(corners[1]) - origin).cross(point(corners[2]) - origin));
  return volume;
}

bool isClosed(Triangles triangles) {
  std::vector<std::uint64_t> edges, opposite;
  for (const openvdb::Vec3I& corners : triangles)
    for (int k = 0; k < 3; ++k) {
      const std::uint64_t from = corners[k], to = corners[(k + 1) % 3];
      edges.push_back(from << 32 | to);
      opposite.push_back(to << 32 | from);
    }
  std::sort(edges.begin(), edges.end());
  std::sort(opposite.begin(), opposite.end());
  return edges == opposite;
}

/// Whether a solid has become flat, or has vanished.
bool isFlattened(std::span<const float> positions, Triangles before, Triangles after) {
  constexpr double kFlat = 1e-6;
  return volumeOf(positions, after) <= kFlat * volumeOf(positions, before) && isClosed(before);
}

}  // namespace

SimplifiedTriangles simplified(std::span<const float> positions, std::span<const openvdb::Vec3I> triangles,
                               double share) {
  static_assert(std::is_same_v<openvdb::Vec3I::value_type, unsigned> && sizeof(openvdb::Vec3I) == 3 * sizeof(unsigned));
  constexpr std::size_t kStride = 3 * sizeof(float);
  constexpr float kAnyError = 1;  // relative to the longest side: only the share decides
  SimplifiedTriangles result;
  if (triangles.empty()) return result;
  const std::size_t points = positions.size() / 3, corners = 3 * triangles.size();
  const auto wanted = static_cast<std::size_t>(std::llround(share * static_cast<double>(triangles.size())));
  result.triangles.resize(triangles.size());
  float error = 0;
  const std::size_t count = meshopt_simplify(
      reinterpret_cast<unsigned*>(result.triangles.data()), reinterpret_cast<const unsigned*>(triangles.data()),
      corners, positions.data(), points, kStride, 3 * std::max<std::size_t>(wanted, 1), kAnyError, 0, &error);
  result.triangles.resize(count / 3);
  if (isFlattened(positions, triangles, result.triangles)) {
    result.triangles.assign(triangles.begin(), triangles.end());
    return result;
  }
  result.error =
      static_cast<double>(error) * static_cast<double>(meshopt_simplifyScale(positions.data(), points, kStride));
  return result;
}

}  // namespace vdbtools
