// SPDX-License-Identifier: Apache-2.0
/// @file surface_velocity.h
/// How fast the neighbourhood of a surface moves, from the same surface a little earlier and later.
#pragma once

#include "vdbtools/motion/surface_motion.h"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdbtools {

/// A surface at another time than now.
struct SurfaceAt {
  double seconds = 0;  ///< after now; negative before
  std::shared_ptr<const Mesh> mesh;
  std::string name;  ///< for errors
};

class SurfaceVelocity {
 public:
  /// @param moments  one, or one before and one after; none: nothing moves
  /// @throw DataError  as SurfaceMotion, naming the mesh
  SurfaceVelocity(const Mesh& now, std::span<const SurfaceAt> moments, MotionDepth depth);
  ~SurfaceVelocity();

  /// The velocities of points, world units per second: how far each point goes from the earlier moment to the later one
  /// (which may be now), by the time between them. A point goes where SurfaceMotion carries it, with its nearest point
  /// of the surface.
  std::vector<openvdb::Vec3d> at(std::span<const openvdb::Vec3d> points) const;

  /// The time of a frame: from now to the moment that is farthest away, seconds.
  double frame() const;

 private:
  struct Side {
    double seconds = 0;
    std::unique_ptr<const SurfaceMotion> motion{};  ///< nullptr: it stands still
  };
  std::vector<Side> mSides;
};

}  // namespace vdbtools
