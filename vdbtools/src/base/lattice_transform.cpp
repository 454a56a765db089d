// SPDX-License-Identifier: Apache-2.0
#include "base/lattice_transform.h"

#include <cmath>
#include <sstream>

namespace vdbtools {

using openvdb::Vec3d;
using openvdb::math::Transform;

bool isOrdinaryScale(const Vec3d& scale) {
  return std::abs(scale[0] * scale[1] * scale[2]) >= 3.0 * openvdb::math::Tolerance<double>::value();
}

bool hasCubicVoxels(const openvdb::GridBase& grid) {
  constexpr double kRelativeError = 1e-5;
  if (!grid.transform().isLinear()) return false;
  const auto side = [&](int axis) {
    Vec3d unit(0);
    unit[axis] = 1;
    return grid.transform().baseMap()->applyJacobian(unit);
  };
  const double area = side(0).lengthSqr();
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b <= a; ++b)
      if (std::abs(side(a).dot(side(b)) - (a == b ? area : 0)) > 2 * kRelativeError * area) return false;
  return true;
}

Transform::Ptr latticeTransform(double voxelSize) {
  if (isOrdinaryScale(Vec3d(voxelSize))) return Transform::createLinearTransform(voxelSize);
  // The constructors refuse it, but a transform that is read is not checked.
  std::stringstream stream(std::ios::in | std::ios::out | std::ios::binary);
  const double inverse = 1 / voxelSize;
  for (const double part : {voxelSize, std::abs(voxelSize), inverse, inverse * inverse, inverse / 2})
    Vec3d(part).write(stream);
  const auto map = openvdb::math::UniformScaleMap::create();
  map->read(stream);
  return std::make_shared<Transform>(map);
}

Transform::Ptr coarserTransform(const Transform& fine) {
  if (fine.isLinear() && !isOrdinaryScale(fine.voxelSize()))
    return latticeTransform(2 * fine.indexToWorld(Vec3d(1))[0]);
  const Transform::Ptr coarse = fine.copy();
  coarse->preScale(2);
  return coarse;
}

}  // namespace vdbtools
