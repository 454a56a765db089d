// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/mesh/mesh.h"

#include "base/disjoint_sets.h"
#include "mesh/position_table.h"
#include "mesh/repeated_corner.h"
#include "vdbtools/base/errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

namespace vdbtools {
namespace {

/// Corners are collinear if their cross product is smaller than this times the square of the longest edge: the rest is
/// rounding of coordinates that were stored in single precision or far from the origin.
constexpr double kInLine = 1e-12;

void checkIndices(const Mesh& mesh) {
  for (std::size_t n = 0; n < mesh.triangles.size(); ++n) {
    for (int c = 0; c < 3; ++c) {
      if (mesh.triangles[n][c] >= mesh.points.size()) {
        throw DataError("triangle " + std::to_string(n) + " refers to point " + std::to_string(mesh.triangles[n][c]) +
                        ", but there are only " + std::to_string(mesh.points.size()) + "; export the mesh again");
      }
    }
  }
}

void countEdges(const Mesh& mesh, MeshReport& report) {
  // Buckets by the smaller end, so that only a few entries are sorted at a time; an entry is the larger end and, in its
  // lowest bit, the direction.
  std::vector<std::uint64_t> first(mesh.points.size() + 1, 0);
  const auto forEachEdge = [&mesh](auto&& visit) {
    for (const openvdb::Vec3I& t : mesh.triangles) {
      if (repeatsCorner(t)) continue;  // two of its edges are the same edge in both directions, and close each other
      for (int c = 0; c < 3; ++c) visit(t[c], t[(c + 1) % 3]);
    }
  };
  forEachEdge([&first](std::uint32_t a, std::uint32_t b) { ++first[std::min(a, b) + std::size_t{1}]; });
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<std::uint64_t> entries(first.back());
  std::vector<std::uint64_t> next(first.begin(), first.end() - 1);
  forEachEdge([&](std::uint32_t a, std::uint32_t b) {
    entries[next[std::min(a, b)]++] = (std::uint64_t{std::max(a, b)} << 1) | (a > b ? 1U : 0U);
  });
  for (std::size_t p = 0; p + 1 < first.size(); ++p) {
    const auto begin = entries.begin() + static_cast<std::ptrdiff_t>(first[p]);
    const auto end = entries.begin() + static_cast<std::ptrdiff_t>(first[p + 1]);
    std::sort(begin, end);
    for (auto it = begin; it != end;) {
      const auto stop = std::find_if(it, end, [&it](std::uint64_t e) { return (e >> 1) != (*it >> 1); });
      const auto uses = stop - it;
      if (uses == 1) ++report.openEdges;
      if (uses > 2) ++report.nonManifoldEdges;
      if (uses == 2 && it[0] == it[1]) ++report.misorientedEdges;
      it = stop;
    }
  }
}

std::uint64_t countComponents(const Mesh& mesh) {
  DisjointSets<std::uint32_t> sets(mesh.points.size());
  std::vector<bool> used(mesh.points.size(), false);
  for (const openvdb::Vec3I& t : mesh.triangles) {
    for (int c = 0; c < 3; ++c) used[t[c]] = true;
    sets.join(t[0], t[1]);
    sets.join(t[1], t[2]);
  }
  std::uint64_t count = 0;
  for (std::uint32_t p = 0; p < sets.size(); ++p) count += used[p] && sets.find(p) == p;
  return count;
}

}  // namespace

MeshReport reportMesh(const Mesh& mesh) {
  checkIndices(mesh);
  MeshReport report;
  report.points = mesh.points.size();
  report.triangles = mesh.triangles.size();
  for (const openvdb::Vec3I& t : mesh.triangles) {
    for (int c = 0; c < 3; ++c) report.box.expand(mesh.points[t[c]]);
  }
  // Volumes are computed relative to the box's centre: relative to a distant origin, the terms would be large and
  // cancel.
  const openvdb::Vec3d middle = mesh.triangles.empty() ? openvdb::Vec3d(0) : report.box.getCenter();
  for (const openvdb::Vec3I& t : mesh.triangles) {
    const openvdb::Vec3d a = mesh.points[t[0]] - middle;
    const openvdb::Vec3d b = mesh.points[t[1]] - middle;
    const openvdb::Vec3d c = mesh.points[t[2]] - middle;
    const openvdb::Vec3d normal = (b - a).cross(c - a);
    const double longest = std::max({(b - a).lengthSqr(), (c - b).lengthSqr(), (a - c).lengthSqr()});
    if (normal.length() <= kInLine * longest) ++report.degenerateFaces;
    report.area += normal.length() / 2;
    report.volume += a.dot(b.cross(c)) / 6;
  }
  countEdges(mesh, report);
  report.components = countComponents(mesh);
  return report;
}

openvdb::BBoxd boundingBox(const Mesh& mesh) {
  openvdb::BBoxd box;
  for (const openvdb::Vec3d& point : mesh.points) box.expand(point);
  return box;
}

Mesh weldMesh(const Mesh& mesh) {
  checkIndices(mesh);
  std::vector<std::uint32_t> welded(mesh.points.size());
  const bool hasNormals = mesh.normals.size() == mesh.points.size();
  const bool hasUvs = !mesh.cornerUvs.empty();
  Mesh result;
  result.pointsLeftOut = mesh.pointsLeftOut;
  result.faceNames = mesh.faceNames;
  for (const VertexAttribute& attribute : mesh.attributes) result.attributes.push_back({attribute.name, {}});
  PositionTable places(result.points, mesh.points.size());
  for (std::size_t p = 0; p < mesh.points.size(); ++p) {
    const std::size_t before = result.points.size();
    welded[p] = places.numberOf(mesh.points[p]);
    if (result.points.size() == before) continue;
    if (hasNormals) result.normals.push_back(mesh.normals[p]);
    for (std::size_t a = 0; a < result.attributes.size(); ++a)
      result.attributes[a].values.push_back(mesh.attributes[a].values[p]);
  }
  result.triangles.reserve(mesh.triangles.size());
  for (std::size_t n = 0; n < mesh.triangles.size(); ++n) {
    const openvdb::Vec3I& t = mesh.triangles[n];
    const openvdb::Vec3I triangle(welded[t[0]], welded[t[1]], welded[t[2]]);
    if (repeatsCorner(triangle)) continue;
    result.triangles.push_back(triangle);
    if (hasUvs) result.cornerUvs.insert(result.cornerUvs.end(), &mesh.cornerUvs[3 * n], &mesh.cornerUvs[3 * n] + 3);
  }
  return result;
}

}  // namespace vdbtools
