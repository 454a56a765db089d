// SPDX-License-Identifier: Apache-2.0
#include "distance/known_distance.h"

namespace vdbtools {

std::optional<double> knownDistance(const BandAccessor& band, const openvdb::Vec3d& index) {
  constexpr double kRounding = 1e-6;
  const openvdb::Coord base = openvdb::Coord::floor(index + openvdb::Vec3d(kRounding));
  const openvdb::Vec3d t = index - base.asVec3d();
  const bool between[] = {t[0] > kRounding, t[1] > kRounding, t[2] > kRounding};
  double values[8] = {};
  for (int n = 0; n < 8; ++n) {
    const int x = n & 1, y = n >> 1 & 1, z = n >> 2;
    if ((x && !between[0]) || (y && !between[1]) || (z && !between[2])) continue;
    float value;
    if (!band.probeValue(base.offsetBy(x, y, z), value)) return std::nullopt;
    values[n] = value;
  }
  for (int axis = 0, count = 4; axis < 3; ++axis, count /= 2)
    for (int n = 0; n < count; ++n)
      values[n] = between[axis] ? values[2 * n] + t[axis] * (values[2 * n + 1] - values[2 * n]) : values[2 * n];
  return values[0];
}

}  // namespace vdbtools
