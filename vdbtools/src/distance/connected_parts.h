// SPDX-License-Identifier: Apache-2.0
/// @file connected_parts.h
/// The parts of a mesh: the sets of triangles that are connected across edges, and what each of them encloses.
#pragma once

#include "base/in_parallel.h"
#include "mesh/repeated_corner.h"
#include "search/triangle_tree.h"
#include "vdbtools/base/monitor.h"

#include <openvdb/Types.h>
#include <openvdb/math/BBox.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace vdbtools {

/// A mesh in which points of the same position are one.
class WeldedMesh {
 public:
  /// Keeps a reference to the mesh.
  explicit WeldedMesh(const TriangleTree& mesh);

  const std::vector<openvdb::Vec3d>& points() const { return mPlaces.empty() ? mMesh.points() : mPlaces; }
  const std::vector<openvdb::Vec3I>& triangles() const { return mPlaces.empty() ? mMesh.triangles() : mTriangles; }
  const TriangleTree& tree() const { return mMesh; }

 private:
  const TriangleTree& mMesh;
  std::vector<openvdb::Vec3d> mPlaces;  ///< empty if no two points have the same position
  std::vector<openvdb::Vec3I> mTriangles;
};

/// One use of an edge by a triangle.
struct EdgeUse {
  std::uint64_t edge = 0;  ///< its smaller point, then its larger one
  std::uint32_t side = 0;  ///< three times the triangle, plus the number of the corner at which the edge begins

  std::uint32_t triangle() const { return side / 3; }
  bool operator<(const EdgeUse& other) const { return edge < other.edge || (edge == other.edge && side < other.side); }
};

/// Calls visit(uses) for each edge, in several threads, with its uses in the order of the triangles. Triangles that
/// repeat a corner use no edge.
template <class Visit>
void forEachEdge(const WeldedMesh& mesh, const Monitor& monitor, const Visit& visit) {
  // Each turn takes the edges whose smaller points are in one range, so that not all uses are in memory at once.
  constexpr std::size_t kTurns = 16, kFewest = 4096;
  const std::vector<openvdb::Vec3I>& triangles = mesh.triangles();
  const std::size_t points = mesh.points().size(), turns = std::clamp<std::size_t>(points / kFewest, 1, kTurns);
  inParallel(turns, 1, monitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t turn = begin; turn < end; ++turn) {
      const std::size_t low = points * turn / turns, high = points * (turn + 1) / turns;
      std::vector<EdgeUse> uses;
      for (std::uint32_t t = 0; t < triangles.size(); ++t)
        for (std::uint32_t c = 0; c < 3; ++c) {
          const std::uint64_t a = triangles[t][static_cast<int>(c)], b = triangles[t][static_cast<int>((c + 1) % 3)];
          const std::uint64_t smaller = std::min(a, b);
          if (smaller >= low && smaller < high && !repeatsCorner(triangles[t]))
            uses.push_back({smaller << 32 | std::max(a, b), 3 * t + c});
        }
      std::sort(uses.begin(), uses.end());
      for (std::size_t first = 0, next = 0; first < uses.size(); first = next) {
        while (next < uses.size() && uses[next].edge == uses[first].edge) ++next;
        visit(std::span<const EdgeUse>(uses).subspan(first, next - first));
      }
    }
  });
}

/// How a part determines what is inside (outer_surface.h).
enum class Closure : std::uint8_t { Open, Parity, Winding };

struct ConnectedParts {
  static constexpr std::uint32_t kNone = 0xffffffff;

  std::vector<std::uint32_t> of;    ///< the part of each triangle; kNone: it repeats a corner
  std::vector<Closure> closure;     ///< of each part
  std::vector<openvdb::BBoxd> box;  ///< of each part
  bool closedOneBranches = false;   ///< whether a closed part uses an edge more than twice: it may touch itself there
};

/// Finds the parts. They are numbered in the order of their first triangles.
/// @throw Interrupted
ConnectedParts findParts(const WeldedMesh& mesh, const Monitor& monitor);

/// Whether the box of a closed part overlaps or touches the box of another part.
bool mayMeet(const ConnectedParts& parts);

}  // namespace vdbtools
