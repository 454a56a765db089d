// SPDX-License-Identifier: Apache-2.0
/// @file surface_motion.h
/// The room `motion` carries a fractal along with a surface that moves. It uses the rooms up to `target`.
///
/// This header declares how a neighbourhood of one surface is mapped to that of another one with the same triangles,
/// such as from an animated mesh to the same mesh at rest (docs/design.md 2.16). On the surface the map is exact:
/// a point of a triangle goes to the point with the same barycentric weights. The difference between a point x beside
/// the surface and its nearest point p is mapped linearly:
///
///   rho(x) = P + T (x - p)
///
/// P is the image of p. T is the mean of the gradients of the triangles about each vertex, interpolated in triangles.
/// How fast a neighbourhood moves follows from its images a little earlier and later.
#pragma once

#include "vdbtools/mesh/mesh.h"

#include <openvdb/math/Mat3.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdbtools {

/// What becomes of the distance to a surface whose area changes.
enum class MotionDepth {
  Stretched,  ///< it changes by as much as lengths in the surface do, as the square root of the area
  Kept,       ///< it is the same distance, world units
};

/// An affine map of world space.
struct AffineMap {
  openvdb::Mat3d matrix = openvdb::Mat3d::identity();
  openvdb::Vec3d offset{0, 0, 0};

  openvdb::Vec3d operator()(const openvdb::Vec3d& x) const { return matrix * x + offset; }
};

/// What errors say of two meshes.
struct FaceWords {
  std::string other;                ///< what the second mesh is called
  std::string mesh = "the target";  ///< and the first
  std::string wayOut = "give meshes with the same faces";
};

/// @throw DataError  the numbers of triangles differ
void requireSameCount(std::size_t triangles, std::size_t others, const FaceWords& words);

/// Whether the second mesh may be the first one after a motion.
/// @throw DataError  the meshes do not have the same triangles
void requireSameFaces(const Mesh& mesh, const Mesh& other, const FaceWords& words);

class SurfaceMotion {
 public:
  /// @param name  of the second mesh, for errors
  /// @throw DataError  the meshes do not have the same triangles, one is turned inside out or has no area, or their
  ///                   sizes are of different units
  SurfaceMotion(const Mesh& from, const Mesh& to, MotionDepth depth, const std::string& name = "the mesh at rest");
  ~SurfaceMotion();

  /// The map that fits best to all of the surface. Where it is the whole truth, rho equals it, up to rounding.
  const AffineMap& overall() const;

  /// The triangles of the first surface; their corners lie at points().
  const std::vector<openvdb::Vec3I>& triangles() const;
  /// World units of the first surface.
  std::vector<openvdb::Vec3d> points() const;

  /// Leaves triangles out of those to which points may be nearest, because they are hidden inside the solid.
  /// @param shown  the numbers of those that stay; not empty
  void showOnly(const std::vector<std::uint32_t>& shown);

  struct Image {
    openvdb::Vec3d at;        ///< rho(x), world units of the other surface
    openvdb::Mat3d gradient;  ///< of rho at x, for x that keep their nearest point
    std::uint32_t hint = 0;   ///< for points beside x
  };
  /// @param hint  makes the search faster and changes nothing else
  Image carry(const openvdb::Vec3d& x, std::optional<std::uint32_t> hint = std::nullopt) const;
  /// The same if the triangle to which x is nearest is known; without a hint.
  Image carryBy(std::uint32_t triangle, const openvdb::Vec3d& x) const;

  /// How large the first surface is, as a multiple of the other one: the root of their areas' ratio.
  double size() const;

  /// How much longer the distances beside the surface may be than those beside the other one: a factor that is exceeded
  /// on half a per cent of the surface.
  double greatestGrowth() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> mParts;
};

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
