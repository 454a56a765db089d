// SPDX-License-Identifier: Apache-2.0
#include "distance/connected_parts.h"

#include "base/disjoint_sets.h"
#include "distance/triangle_cut.h"
#include "mesh/position_table.h"

#include <tbb/concurrent_vector.h>

#include <algorithm>
#include <utility>

namespace vdbtools {

using openvdb::BBoxd;
using openvdb::Vec3d;
using openvdb::Vec3I;

WeldedMesh::WeldedMesh(const TriangleTree& mesh) : mMesh(mesh) {
  const std::vector<Vec3d>& given = mesh.points();
  std::vector<std::uint32_t> numbers(given.size());
  PositionTable table(mPlaces, given.size());
  for (std::size_t p = 0; p < given.size(); ++p) numbers[p] = table.numberOf(given[p]);
  if (mPlaces.size() == given.size()) {
    std::vector<Vec3d>().swap(mPlaces);
    return;
  }
  mTriangles = mesh.triangles();
  for (Vec3I& t : mTriangles) t = Vec3I(numbers[t[0]], numbers[t[1]], numbers[t[2]]);
}

ConnectedParts findParts(const WeldedMesh& mesh, const Monitor& monitor) {
  const std::vector<Vec3I>& triangles = mesh.triangles();
  DisjointSets<std::uint32_t> sets(triangles.size());
  tbb::concurrent_vector<std::pair<std::uint32_t, Closure>> exceptions;
  tbb::concurrent_vector<std::uint32_t> branching;
  forEachEdge(mesh, monitor, [&](std::span<const EdgeUse> uses) {
    int balance = 0;
    for (const EdgeUse& use : uses) {
      const bool forward = triangles[use.triangle()][static_cast<int>(use.side % 3)] == use.edge >> 32;
      balance += forward ? 1 : -1;
      sets.join(uses.front().triangle(), use.triangle());
    }
    if (balance != 0)
      exceptions.emplace_back(uses.front().triangle(), uses.size() % 2 == 0 ? Closure::Parity : Closure::Open);
    if (uses.size() > 2) branching.push_back(uses.front().triangle());
  });
  ConnectedParts parts;
  parts.of.assign(triangles.size(), ConnectedParts::kNone);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    if (repeatsCorner(triangles[t])) continue;
    // The first triangle of a part names its set.
    const std::uint32_t first = sets.find(t);
    if (first == t) {
      parts.of[t] = static_cast<std::uint32_t>(parts.closure.size());
      parts.closure.push_back(Closure::Winding);
      parts.box.emplace_back();
    }
    const std::uint32_t number = parts.of[t] = parts.of[first];
    for (int c = 0; c < 3; ++c) parts.box[number].expand(mesh.points()[triangles[t][c]]);
  }
  for (const auto& [triangle, closure] : exceptions) {
    Closure& whole = parts.closure[parts.of[triangle]];
    whole = std::min(whole, closure);
  }
  parts.closedOneBranches = std::any_of(branching.begin(), branching.end(),
                                        [&](std::uint32_t t) { return parts.closure[parts.of[t]] != Closure::Open; });
  return parts;
}

bool mayMeet(const ConnectedParts& parts) {
  std::vector<std::uint32_t> order(parts.box.size());
  for (std::uint32_t p = 0; p < order.size(); ++p) order[p] = p;
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double x = parts.box[a].min()[0], y = parts.box[b].min()[0];
    return x < y || (x == y && a < b);
  });
  for (std::size_t i = 0; i < order.size(); ++i) {
    BBoxd box = parts.box[order[i]];
    box.expand(kTouch);
    for (std::size_t k = i + 1; k < order.size() && parts.box[order[k]].min()[0] <= box.max()[0]; ++k)
      if (box.hasOverlap(parts.box[order[k]]) &&
          (parts.closure[order[i]] != Closure::Open || parts.closure[order[k]] != Closure::Open))
        return true;
  }
  return false;
}

}  // namespace vdbtools
