// SPDX-License-Identifier: Apache-2.0
#include "mesh/simplify.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <type_traits>

namespace vdbtools {

SimplifiedTriangles simplified(std::span<const float> positions, std::span<const openvdb::Vec3I> triangles,
                               double share) {
  static_assert(std::is_same_v<openvdb::Vec3I::value_type, unsigned> && sizeof(openvdb::Vec3I) == 3 * sizeof(unsigned));
  constexpr std::size_t kStride = 3 * sizeof(float);
  constexpr float kAnyError = 1;  // of the longest side: the share alone decides
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
  result.error =
      static_cast<double>(error) * static_cast<double>(meshopt_simplifyScale(positions.data(), points, kStride));
  return result;
}

}  // namespace vdbtools
