// SPDX-License-Identifier: Apache-2.0
/// @file study_circles.h
/// Circles in a plane about the foot of the origin of the dynamics, and the distance of a target on them.
#pragma once

#include "vdbtools/study/study.h"

#include <array>
#include <vector>

namespace vdbtools {

class StudyCircles {
 public:
  static constexpr std::size_t kAngles = 512;  ///< points of a circle, a power of two from 4 on

  StudyCircles(const SlicePlane& plane, const openvdb::Vec3d& origin);

  openvdb::Vec3d position(std::size_t circle, std::size_t angle) const;

  /// Everything about each circle except its membership. @throw DataError, Interrupted
  std::vector<StudyCircle> measure(const Scene& scene, Monitor& monitor) const;

 private:
  double radius(std::size_t circle) const;

  openvdb::Vec3d mOrigin, mCentre, mRight, mDown;
  double mFarthest = 0;  ///< the radius of the last circle
  std::vector<std::array<double, 2>> mUnit;
};

}  // namespace vdbtools
