// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/decimation/adaptive_mesh.h"
#include "vdbtools/base/text.h"

#include "decimation/bounded_collapse.h"
#include "decimation/halfedge_mesh.h"
#include "search/surface_distance.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace vdbtools {
namespace {

using openvdb::Vec3I;

/// The distance of samples of the surface is kept below this fraction of the bound, so that the surface between them
/// seldom exceeds the bound itself.
constexpr float kShareOfSamples = 0.8F;

/// After this many failed proofs, the mesh is left unchanged, which trivially satisfies the bound.
constexpr int kMostAttempts = 12;

AdaptedMesh remainderOf(const HalfedgeMesh& mesh) {
  constexpr std::uint32_t kNone = ~std::uint32_t{0};
  std::vector<std::uint32_t> numbers(mesh.n_vertices(), kNone);
  AdaptedMesh result;
  std::vector<bool> used(mesh.n_vertices(), false);
  const auto corners = [&](HalfedgeMesh::FaceHandle face) {
    Vec3I triangle(0, 0, 0);
    int c = 0;
    for (auto vertex = mesh.cfv_iter(face); vertex.is_valid() && c < 3; ++vertex)
      triangle[c++] = static_cast<std::uint32_t>(vertex->idx());
    return triangle;
  };
  for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
    const HalfedgeMesh::FaceHandle face(static_cast<int>(f));
    if (mesh.status(face).deleted()) continue;
    result.triangles.push_back(corners(face));
    for (int c = 0; c < 3; ++c) used[result.triangles.back()[c]] = true;
  }
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    numbers[i] = static_cast<std::uint32_t>(result.points.size());
    result.points.push_back(static_cast<std::uint32_t>(i));
  }
  for (Vec3I& triangle : result.triangles)
    for (int c = 0; c < 3; ++c) triangle[c] = numbers[triangle[c]];
  return result;
}

/// Halves the tolerances at some triangles, and at @a rings rings of triangles around them, and returns at which
/// points.
std::vector<bool> tightenAround(const Mesh& mesh, const std::vector<std::uint32_t>& triangles, int rings,
                                std::vector<float>& tolerances) {
  std::vector<bool> marked(mesh.points.size(), false);
  for (const std::uint32_t t : triangles)
    for (int c = 0; c < 3; ++c) marked[mesh.triangles[t][c]] = true;
  for (int ring = 0; ring < rings; ++ring) {
    std::vector<bool> wider = marked;
    for (const Vec3I& t : mesh.triangles)
      if (marked[t[0]] || marked[t[1]] || marked[t[2]])
        for (int c = 0; c < 3; ++c) wider[t[c]] = true;
    marked.swap(wider);
  }
  for (std::size_t i = 0; i < marked.size(); ++i)
    if (marked[i]) tolerances[i] /= 2;
  return marked;
}

/// Keeps the extents: the samples of the outermost points have to stay on the surface. Those beside them may only leave
/// the plane as far as rounding does, so that a flat base stays as large as it is.
void keepExtents(const Mesh& mesh, std::vector<float>& tolerances) {
  constexpr float kRounding = 1e-3F;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [low, high] =
        std::minmax_element(mesh.points.begin(), mesh.points.end(),
                            [&](const openvdb::Vec3d& p, const openvdb::Vec3d& q) { return p[axis] < q[axis]; });
    for (const auto outermost : {low, high}) {
      for (std::size_t i = 0; i < mesh.points.size(); ++i)
        if (std::abs(mesh.points[i][axis] - (*outermost)[axis]) < static_cast<double>(kRounding))
          tolerances[i] = std::min(tolerances[i], kRounding);
      tolerances[static_cast<std::size_t>(outermost - mesh.points.begin())] = 0;
    }
  }
}

AdaptedMesh unchanged(const Mesh& mesh) {
  AdaptedMesh result;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) result.points.push_back(static_cast<std::uint32_t>(i));
  result.triangles = mesh.triangles;
  return result;
}

}  // namespace

AdaptedMesh adaptedMesh(const Mesh& mesh, double bound, Monitor& monitor) {
  if (!(bound > 0) || !std::isfinite(bound))
    throw std::invalid_argument("a mesh is adapted within a bound of " + shortText(bound) +
                                "; the bound must be positive");
  monitor.begin(PhaseKind::Adapting, 0);
  if (mesh.triangles.empty()) return unchanged(mesh);
  // The bound is 1 from here on, because OpenMesh treats very small triangles as lines; and positions are relative to a
  // point.
  Mesh scaled{.points = {}, .triangles = mesh.triangles};
  scaled.points.reserve(mesh.points.size());
  for (const openvdb::Vec3d& point : mesh.points) scaled.points.push_back((point - mesh.points.front()) / bound);
  const HalfedgeMesh halfedges = toHalfedges(scaled);
  const SurfaceSearch whole(scaled.points, scaled.triangles);
  constexpr double kLimit = 1 - 1e-9;  // leaves room for rounding
  constexpr int kRings = 2;
  std::vector<float> tolerances(mesh.points.size(), kShareOfSamples);
  keepExtents(scaled, tolerances);
  std::vector<bool> changed(mesh.points.size(), true);
  std::vector<Collapse> history;
  for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
    monitor.throwIfCancelled();
    HalfedgeMesh collapsed = halfedges;
    collapseWithin(collapsed, scaled, whole, tolerances, changed, history, monitor);
    AdaptedMesh result = remainderOf(collapsed);
    const Mesh coarse = meshOf(result, scaled);
    std::vector<std::uint32_t> failed;
    for (const FarPlace& place : placesFartherThan(kLimit, coarse, scaled, whole, monitor))
      if (const auto nearest = whole.nearest(place.place)) failed.push_back(nearest->triangle);
    const SurfaceSearch search(coarse.points, coarse.triangles);
    for (const FarPlace& place : placesFartherThan(kLimit, scaled, coarse, search, monitor))
      failed.push_back(place.triangle);
    if (failed.empty()) return result;
    changed = tightenAround(scaled, failed, kRings, tolerances);
  }
  return unchanged(mesh);
}

Mesh meshOf(const AdaptedMesh& adapted, const Mesh& mesh) {
  Mesh result;
  for (const std::uint32_t point : adapted.points) result.points.push_back(mesh.points[point]);
  result.triangles = adapted.triangles;
  return result;
}

void AdaptiveMeshSink::addPoints(const PointBatch& batch) {
  mMesh.points.insert(mMesh.points.end(), batch.positions.begin(), batch.positions.end());
  mMesh.normals.insert(mMesh.normals.end(), batch.normals.begin(), batch.normals.end());
  mValues.insert(mValues.end(), batch.values.begin(), batch.values.end());
}

void AdaptiveMeshSink::addTriangles(std::span<const Vec3I> triangles, std::uint64_t) {
  mMesh.triangles.insert(mMesh.triangles.end(), triangles.begin(), triangles.end());
}

void AdaptiveMeshSink::finish(Monitor& monitor) {
  const AdaptedMesh adapted = adaptedMesh(mMesh, mBound, monitor);
  const std::size_t row = mMesh.points.empty() ? 0 : mValues.size() / mMesh.points.size();
  std::vector<openvdb::Vec3d> points;
  std::vector<openvdb::Vec3s> normals;
  std::vector<float> values;
  for (const std::uint32_t i : adapted.points) {
    points.push_back(mMesh.points[i]);
    if (!mMesh.normals.empty()) normals.push_back(mMesh.normals[i]);
    for (std::size_t k = 0; k < row; ++k) values.push_back(mValues[i * row + k]);
  }
  mNext.addPoints({points, normals, values});
  mNext.addTriangles(adapted.triangles, 0);
  mPointsAfter = points.size();
  mTrianglesAfter = adapted.triangles.size();
}

}  // namespace vdbtools
