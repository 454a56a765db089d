// SPDX-License-Identifier: Apache-2.0
/// @file solid_meter.h
/// The room `search` answers geometric queries about a surface: its nearest triangle, distances between surfaces,
/// points spread over it, the volume it encloses. It uses the rooms up to `mesh`.
///
/// This header measures the volume and the islands of a closed mesh while it is passed on.
#pragma once

#include "vdbtools/mesh/mesh_sink.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

namespace vdbtools {

struct SolidMeasure {
  double volume = 0;  ///< world units cubed: the total of all parts, less their cavities
  /// The volumes within the outer surfaces of the parts, the largest first; an inside-out surface bounds a cavity and
  /// is not a part.
  std::vector<double> islands;

  /// The fraction of the volume of all islands that the first @a count have; 0 if there are none.
  double shareOfLargest(std::size_t count) const;
};

/// Measures a mesh on its way to another sink. A part consists of triangles connected through shared points. The
/// meter stores the points that later triangles may still use, and one number for each place where a part first
/// appeared.
class SolidMeter final : public MeshSink {
 public:
  /// @param next  the sink to which the mesh is passed on; nullptr: none
  explicit SolidMeter(MeshSink* next = nullptr) : mNext(next) {}

  void addPoints(const PointBatch& batch) override;
  void addTriangles(std::span<const openvdb::Vec3I> triangles, std::uint64_t firstPoint) override;

  /// Measures what has passed so far. Meaningful for closed meshes only.
  SolidMeasure measure() const;

 private:
  struct Point {
    openvdb::Vec3d position;  ///< relative to the first point of the mesh, world units
    std::uint32_t part;       ///< kNoPart: not used by a triangle yet
  };
  struct Part {
    std::uint32_t parent;  ///< its own index if it is a root
    double volume;         ///< for a root: 6 times the volume of all joined parts
  };
  static constexpr std::uint32_t kNoPart = ~std::uint32_t{0};

  std::uint32_t rootOf(std::uint32_t part);

  MeshSink* mNext;
  openvdb::Vec3d mOrigin{0, 0, 0};
  std::uint64_t mFirst = 0;  ///< the index of the first of mPoints
  std::deque<Point> mPoints;
  std::vector<Part> mParts;
};

SolidMeasure measureSolid(const Mesh& mesh);

}  // namespace vdbtools
