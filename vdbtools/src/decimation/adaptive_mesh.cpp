// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/decimation/adaptive_mesh.h"
#include "vdbtools/base/text.h"

#include "decimation/halfedge_mesh.h"
#include "search/surface_distance.h"

#include <openvdb/math/Proximity.h>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModBaseT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace vdbtools {
namespace {

using openvdb::Vec3I;

/// The maximum rotation of a triangle's normal in one collapse, degrees: more would be a fold.
constexpr float kFold = 75;

/// The distance of samples of the surface is kept below this fraction of the bound, so that the surface between them
/// seldom exceeds the bound itself.
constexpr double kShareOfSamples = 0.6;

/// After this many failed proofs, the mesh is left unchanged, which trivially satisfies the bound.
constexpr int kMostAttempts = 12;

/// Allows an edge to collapse only if a sample of the original surface stays near: its points, and the midpoints of its
/// edges and of its triangles. OpenMesh's own ModHausdorff uses only the points, but on a rough surface the edges
/// between them are lost first.
template <class MeshT>
// NOLINTNEXTLINE(cppcoreguidelines-virtual-class-destructor): it is virtual, which the base's being a template hides
class ModSampleT : public OpenMesh::Decimater::ModBaseT<MeshT> {
 public:
  DECIMATING_MODULE(ModSampleT, MeshT, Sample);

  explicit ModSampleT(MeshT& mesh) : Base(mesh, true), mMesh(Base::mesh()) { mMesh.add_property(mSamples); }
  ~ModSampleT() override { mMesh.remove_property(mSamples); }

  void setTolerance(double tolerance) { mSquare = tolerance * tolerance; }

  void initialize() override {
    for (const auto face : mMesh.faces()) {
      const Triangle t = cornersOf(face);
      mMesh.property(mSamples, face) = {(t[0] + t[1] + t[2]) / 3.0};
    }
    for (const auto edge : mMesh.edges()) {
      const auto half = edge.h0().is_boundary() ? edge.h1() : edge.h0();
      const Vec3d middle = (pointOf(half.from()) + pointOf(half.to())) / 2.0;
      mMesh.property(mSamples, half.face()).push_back(middle);
    }
  }

  float collapse_priority(const CollapseInfo& collapse) override {
    mTriangles.clear();
    mLoose.assign(1, vector(collapse.p0));
    for (const auto face : mMesh.vf_range(collapse.v0)) {
      const std::vector<Vec3d>& samples = mMesh.property(mSamples, face);
      mLoose.insert(mLoose.end(), samples.begin(), samples.end());
      if (face == collapse.fl || face == collapse.fr) continue;
      Triangle t;
      std::size_t c = 0;
      for (const auto vertex : mMesh.fv_range(face))
        t[c++] = vertex == collapse.v0 ? vector(collapse.p1) : pointOf(vertex);
      mTriangles.push_back(t);
    }
    for (const Vec3d& sample : mLoose)
      if (std::none_of(mTriangles.begin(), mTriangles.end(),
                       [&](const Triangle& t) { return squaredDistance(sample, t) <= mSquare; }))
        return static_cast<float>(Base::ILLEGAL_COLLAPSE);
    return static_cast<float>(Base::LEGAL_COLLAPSE);
  }

  /// Assigns the samples to the nearest triangles of the new mesh.
  void postprocess_collapse(const CollapseInfo& collapse) override {
    mLoose.assign(1, vector(collapse.p0));
    const auto take = [&](typename Mesh::FaceHandle face) {
      std::vector<Vec3d>& samples = mMesh.property(mSamples, face);
      mLoose.insert(mLoose.end(), samples.begin(), samples.end());
      samples.clear();
    };
    for (const auto face : {collapse.fl, collapse.fr})
      if (face.is_valid()) take(face);
    mTriangles.clear();
    std::vector<typename Mesh::FaceHandle> faces;
    for (const auto face : mMesh.vf_range(collapse.v1)) {
      take(face);
      faces.push_back(face);
      mTriangles.push_back(cornersOf(face));
    }
    if (faces.empty()) return;
    for (const Vec3d& sample : mLoose) {
      std::size_t nearest = 0;
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t i = 0; i < faces.size(); ++i) {
        const double square = squaredDistance(sample, mTriangles[i]);
        if (square < least) least = square, nearest = i;
      }
      mMesh.property(mSamples, faces[nearest]).push_back(sample);
    }
  }

 private:
  using Vec3d = openvdb::Vec3d;
  using Triangle = std::array<Vec3d, 3>;

  static Vec3d vector(const typename Mesh::Point& p) { return {p[0], p[1], p[2]}; }
  Vec3d pointOf(typename Mesh::VertexHandle vertex) const { return vector(mMesh.point(vertex)); }
  Triangle cornersOf(typename Mesh::FaceHandle face) const {
    Triangle t;
    std::size_t c = 0;
    for (const auto vertex : mMesh.fv_range(face)) t[c++] = pointOf(vertex);
    return t;
  }
  static double squaredDistance(const Vec3d& p, const Triangle& t) {
    Vec3d weights;
    return (p - openvdb::math::closestPointOnTriangleToPoint(t[0], t[1], t[2], p, weights)).lengthSqr();
  }

  Mesh& mMesh;
  OpenMesh::FPropHandleT<std::vector<Vec3d>> mSamples;
  double mSquare = 0;
  std::vector<Vec3d> mLoose;  // kept to save allocations
  std::vector<Triangle> mTriangles;
};

/// Collapses all edges that may be collapsed. @param bound  is 1 in the units of @a mesh
AdaptedMesh collapsed(HalfedgeMesh mesh, const std::vector<bool>& keeps, double tolerance) {
  for (std::size_t i = 0; i < keeps.size(); ++i)
    if (keeps[i]) mesh.status(HalfedgeMesh::VertexHandle(static_cast<int>(i))).set_locked(true);
  {
    using namespace OpenMesh::Decimater;
    DecimaterT<HalfedgeMesh> decimater(mesh);
    ModQuadricT<HalfedgeMesh>::Handle quadric;
    ModNormalFlippingT<HalfedgeMesh>::Handle normals;
    ModSampleT<HalfedgeMesh>::Handle distance;
    decimater.add(quadric);
    decimater.module(quadric).unset_max_err();
    decimater.add(normals);
    decimater.module(normals).set_max_normal_deviation(kFold);
    decimater.add(distance);
    decimater.module(distance).setTolerance(tolerance);
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
  std::vector<bool> keeps(mesh.points.size(), false);
  for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
    monitor.throwIfCancelled();
    AdaptedMesh result = collapsed(halfedges, keeps, kShareOfSamples);
    const Mesh coarse = meshOf(result, scaled);
    std::vector<std::uint32_t> failed;
    for (const FarPlace& place : placesFartherThan(kLimit, coarse, scaled, whole, monitor))
      failed.push_back(place.otherTriangle);
    const SurfaceSearch search(coarse.points, coarse.triangles);
    for (const FarPlace& place : placesFartherThan(kLimit, scaled, coarse, search, monitor))
      failed.push_back(place.triangle);
    if (failed.empty()) return result;
    keepAround(scaled, failed, attempt + 2, keeps);
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
