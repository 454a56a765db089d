// SPDX-License-Identifier: Apache-2.0
/// @file solid_meter.h
/// The room `search` answers questions about a surface in space: its nearest triangle, distances between surfaces,
/// points spread over it, what it encloses. It uses the rooms up to `mesh`.
///
/// What a closed mesh holds, measured while it passes by: its volume and its islands.
#pragma once

#include "vdbtools/mesh/mesh_sink.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

namespace vdbtools {

struct SolidMeasure {
  double volume = 0;  ///< world units cubed: of all parts together, cavities taken off
  /// The volumes within the outer surfaces of the parts, the largest first; a surface that is turned inside out bounds
  /// a cavity and is no part.
  std::vector<double> islands;

  /// The share of the first @a count islands in the volume of all; 0 if there are none.
  double shareOfLargest(std::size_t count) const;
};

/// Measures a mesh on its way to another sink. Parts are what triangles join through shared points. The memory is that
/// of the points which later triangles may still use, and of one number for each place where a part was first met.
class SolidMeter final : public MeshSink {
 public:
  /// @param next  where the mesh goes on to; nullptr: nowhere
  explicit SolidMeter(MeshSink* next = nullptr) : mNext(next) {}

  void addPoints(const PointBatch& batch) override;
  void addTriangles(std::span<const openvdb::Vec3I> triangles, std::uint64_t firstPoint) override;

  /// Of what has passed. Meaningful for closed meshes only.
  SolidMeasure measure() const;

 private:
  struct Point {
    openvdb::Vec3d position;  ///< from the first point of all, world units
    std::uint32_t part;       ///< kNoPart: no triangle has used it yet
  };
  struct Part {
    std::uint32_t parent;  ///< itself: it is a root
    double volume;         ///< of a root: of all that was joined, times 6
  };
  static constexpr std::uint32_t kNoPart = ~std::uint32_t{0};

  std::uint32_t rootOf(std::uint32_t part);

  MeshSink* mNext;
  openvdb::Vec3d mOrigin{0, 0, 0};
  std::uint64_t mFirst = 0;  ///< the index of mPoints' first
  std::deque<Point> mPoints;
  std::vector<Part> mParts;
};

SolidMeasure measureSolid(const Mesh& mesh);

}  // namespace vdbtools
