// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/mesh/adaptive_mesh.h"

#include "mesh/halfedge_mesh.h"
#include "mesh/surface_distance.h"

#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModHausdorffT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace vdbtools {
namespace {

using openvdb::Vec3I;

/// Degrees that a triangle's normal may turn by in one collapse: more would be a fold.
constexpr float kFold = 75;

/// The distance of the points that are taken away is held below this share of the bound, so that the surface between
/// them seldom exceeds the bound itself.
constexpr double kShareOfPoints = 0.8;

/// After as many proofs that failed, the mesh stays as it was, which is certainly near itself.
constexpr int kMostAttempts = 12;

/// Collapses all edges that may be. @param bound  1 in the units of @a mesh
AdaptedMesh collapsed(HalfedgeMesh mesh, const std::vector<bool>& keeps, double tolerance) {
  for (std::size_t i = 0; i < keeps.size(); ++i)
    if (keeps[i]) mesh.status(HalfedgeMesh::VertexHandle(static_cast<int>(i))).set_locked(true);
  {
    using namespace OpenMesh::Decimater;
    DecimaterT<HalfedgeMesh> decimater(mesh);
    ModQuadricT<HalfedgeMesh>::Handle quadric;
    ModNormalFlippingT<HalfedgeMesh>::Handle normals;
    ModHausdorffT<HalfedgeMesh>::Handle distance;
    decimater.add(quadric);
    decimater.module(quadric).unset_max_err();
    decimater.add(normals);
    decimater.module(normals).set_max_normal_deviation(kFold);
    decimater.add(distance);
    decimater.module(distance).set_tolerance(tolerance);
    decimater.initialize();
    decimater.decimate();
  }
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

Mesh meshOf(const AdaptedMesh& adapted, const Mesh& mesh) {
  Mesh result;
  for (const std::uint32_t point : adapted.points) result.points.push_back(mesh.points[point]);
  result.triangles = adapted.triangles;
  return result;
}

/// Marks the points of some triangles, and of @a rings rings of triangles around them.
void keepAround(const Mesh& mesh, const std::vector<std::uint32_t>& triangles, int rings, std::vector<bool>& keeps) {
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
    if (marked[i]) keeps[i] = true;
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
    throw std::invalid_argument("a mesh is adapted within a bound of " + std::to_string(bound) +
                                "; the bound must be positive");
  monitor.begin("adapting", 0);
  if (mesh.triangles.empty()) return unchanged(mesh);
  // The bound is 1 from here on, as OpenMesh takes very small triangles for lines; and positions are from a point.
  Mesh scaled{.points = {}, .triangles = mesh.triangles};
  scaled.points.reserve(mesh.points.size());
  for (const openvdb::Vec3d& point : mesh.points) scaled.points.push_back((point - mesh.points.front()) / bound);
  const HalfedgeMesh halfedges = toHalfedges(scaled);
  const SurfaceSearch whole(scaled.points, scaled.triangles);
  constexpr double kLimit = 1 - 1e-9;  // leaves room for rounding
  std::vector<bool> keeps(mesh.points.size(), false);
  for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
    monitor.throwIfCancelled();
    const double tolerance = kShareOfPoints * std::pow(0.9, attempt);
    AdaptedMesh result = collapsed(halfedges, keeps, tolerance);
    const Mesh coarse = meshOf(result, scaled);
    std::vector<std::uint32_t> failed;
    for (const FarPlace& place : placesFartherThan(kLimit, coarse, scaled, whole, monitor))
      failed.push_back(place.otherTriangle);
    const SurfaceSearch search(coarse.points, coarse.triangles);
    for (const FarPlace& place : placesFartherThan(kLimit, scaled, coarse, search, monitor))
      failed.push_back(place.triangle);
    if (failed.empty()) return result;
    keepAround(scaled, failed, attempt + 1, keeps);
  }
  return unchanged(mesh);
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
