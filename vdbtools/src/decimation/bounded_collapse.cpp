// SPDX-License-Identifier: Apache-2.0
#include "decimation/bounded_collapse.h"

#include "search/surface_distance.h"

#include <OpenMesh/Core/Geometry/QuadricT.hh>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <queue>
#include <utility>

namespace vdbtools {
namespace {

using openvdb::Vec3d;

/// The cosine of the maximum rotation of a triangle's normal in one collapse, 75 degrees: more would be a fold.
constexpr double kLeastCosine = 0.25881904510252074;

/// New triangles are proved to be as near as this. A smaller limit needs more triangles; with a larger one,
/// more places of either surface are too far from the other.
constexpr double kNearLimit = 0.95;

/// A new triangle that is not proved to be near after so many halvings counts as far.
constexpr int kMostHalvings = 12;

/// Collapses of inner points onto places whose mean squared distance from the planes of the triangles around is less
/// than this stay in these planes, and their new triangles are not tested: that would take as long as a plane is large.
/// The rounding of coordinates to 32 bits moves points by less.
constexpr double kFlat = 1e-6;

class BoundedCollapse {
 public:
  BoundedCollapse(HalfedgeMesh& mesh, const Mesh& before, const SurfaceSearch& search,
                  const std::vector<float>& tolerances)
      : mMesh(mesh),
        mBefore(before),
        mProof(kNearLimit, before, search, kMostHalvings),
        mQuadrics(mesh.n_vertices()),
        mTurns(mesh.n_vertices()),
        mSamplesOfFace(mesh.n_faces()) {
    addQuadrics();
    addSamples(tolerances);
  }

  /// Repeats collapses of an earlier attempt, but for those near points whose tolerances have changed since.
  /// @param history    receives those that were repeated
  /// @param unsettled  for each point, whether its tolerance has changed; receives all around which something is not as
  ///                   it was in the earlier attempt
  void repeat(std::vector<Collapse>& history, std::vector<bool>& unsettled) {
    std::size_t kept = 0;
    for (const Collapse& collapse : history) {
      const Vertex from(static_cast<int>(collapse.from)), to(static_cast<int>(collapse.to));
      bool isSettled = !unsettled[collapse.from];
      for (const auto vertex : mMesh.vv_range(from)) isSettled = isSettled && !unsettled[at(vertex)];
      if (isSettled) {
        carryOut(mMesh.find_halfedge(from, to));
        history[kept++] = collapse;
      } else {
        unsettled[collapse.from] = unsettled[collapse.to] = true;
        for (const auto vertex : mMesh.vv_range(from)) unsettled[at(vertex)] = true;
      }
    }
    history.resize(kept);
  }

  /// Collapses what is possible. OpenMesh's own decimater tests all collapses of a point whenever something changes
  /// near it. Here, they are tested when it is the point's turn, before which most have changed again.
  /// @param history  receives the collapses
  /// @param points   those where something may be possible
  void run(std::vector<Collapse>& history, const std::vector<bool>& points, const Monitor& monitor) {
    for (const auto vertex : mMesh.vertices())
      if (points[at(vertex)]) putIntoQueue(vertex);
    std::size_t count = 0;
    constexpr std::size_t kChecks = 4096;
    while (!mQueue.empty()) {
      if (++count % kChecks == 0) monitor.throwIfCancelled();
      const Entry entry = mQueue.top();
      mQueue.pop();
      if (entry.number != mTurns[entry.vertex].number) continue;
      const auto chosen = choose(entry);
      if (!chosen) continue;
      const Vertex to = mMesh.to_vertex_handle(*chosen);
      carryOut(*chosen);
      history.push_back({entry.vertex, numberOf(to)});
      putIntoQueue(to);
      for (const auto vertex : mMesh.vv_range(to)) putIntoQueue(vertex);
    }
  }

 private:
  using Vertex = HalfedgeMesh::VertexHandle;
  using Halfedge = HalfedgeMesh::HalfedgeHandle;
  using Face = HalfedgeMesh::FaceHandle;

  /// A point in the queue. The error is the least one of its collapses, whether these are possible or not.
  struct Entry {
    double error;
    std::uint32_t vertex, number;
    bool operator<(const Entry& other) const {  // the top of the queue is its greatest element
      return error != other.error ? error > other.error : vertex > other.vertex;
    }
  };
  struct Turn {
    std::uint32_t number = 0;  ///< of the entry that holds; others are of a time before something changed
    Halfedge possible;         ///< the cheapest possible collapse, once it is known
  };
  struct Sample {
    Vec3d place;
    std::uint32_t triangle;  ///< a triangle of the surface before that has the place
    float tolerance;
  };

  static std::size_t at(OpenMesh::BaseHandle handle) { return static_cast<std::size_t>(handle.idx()); }
  static std::uint32_t numberOf(OpenMesh::BaseHandle handle) { return static_cast<std::uint32_t>(handle.idx()); }
  static Vec3d vector(const HalfedgeMesh::Point& p) { return {p[0], p[1], p[2]}; }
  Vec3d pointOf(Vertex vertex) const { return vector(mMesh.point(vertex)); }
  TriangleCorners cornersOf(Face face) const {
    TriangleCorners t;
    std::size_t c = 0;
    for (const auto vertex : mMesh.fv_range(face)) t[c++] = pointOf(vertex);
    return t;
  }

  void addQuadrics() {
    for (const auto face : mMesh.faces()) {
      const TriangleCorners t = cornersOf(face);
      Vec3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
      const double length = normal.length();
      if (length > 0) normal /= length;
      OpenMesh::Geometry::Quadricd quadric(normal[0], normal[1], normal[2], -normal.dot(t[0]));
      quadric *= length / 2;  // the area
      for (const auto vertex : mMesh.fv_range(face)) mQuadrics[at(vertex)] += quadric;
    }
  }

  /// The samples of points have their numbers; a point itself belongs to no face.
  void addSamples(const std::vector<float>& tolerances) {
    for (std::size_t i = 0; i < mBefore.points.size(); ++i) mSamples.push_back({mBefore.points[i], 0, tolerances[i]});
    for (std::size_t i = 0; i < mBefore.triangles.size(); ++i)
      for (int c = 0; c < 3; ++c) mSamples[mBefore.triangles[i][c]].triangle = static_cast<std::uint32_t>(i);
    const auto add = [&](Face face, const Vec3d& place, float tolerance) {
      mSamplesOfFace[at(face)].push_back(static_cast<std::uint32_t>(mSamples.size()));
      mSamples.push_back({place, numberOf(face), tolerance});
    };
    for (const auto face : mMesh.faces()) {
      const TriangleCorners t = cornersOf(face);
      float least = std::numeric_limits<float>::infinity();
      for (const auto vertex : mMesh.fv_range(face)) least = std::min(least, tolerances[at(vertex)]);
      add(face, (t[0] + t[1] + t[2]) / 3.0, least);
    }
    for (const auto edge : mMesh.edges()) {
      const auto half = edge.h0().is_boundary() ? edge.h1() : edge.h0();
      add(half.face(), (pointOf(half.from()) + pointOf(half.to())) / 2.0,
          std::min(tolerances[at(half.from())], tolerances[at(half.to())]));
    }
  }

  /// Of the planes of the triangles around both points.
  OpenMesh::Geometry::Quadricd quadricOf(Halfedge half) const {
    OpenMesh::Geometry::Quadricd quadric = mQuadrics[at(mMesh.from_vertex_handle(half))];
    quadric += mQuadrics[at(mMesh.to_vertex_handle(half))];
    return quadric;
  }

  double quadricError(Halfedge half) const {
    return std::max(quadricOf(half)(mMesh.point(mMesh.to_vertex_handle(half))), 0.0);
  }

  bool isFlat(Halfedge half) const {
    const OpenMesh::Geometry::Quadricd quadric = quadricOf(half);
    const double area = quadric.a() + quadric.e() + quadric.h();  // of all triangles, whose normals have the length 1
    return quadricError(half) < kFlat * std::max(area, 1.0);
  }

  /// The quadric error and, where that is about 0, the shorter edge first: triangles of all sizes would make one point
  /// of a plane the neighbour of all others, and each collapse as expensive as the plane is large.
  double errorOf(Halfedge half) const {
    constexpr double kShareOfLength = 1e-6;
    const double square =
        (mMesh.point(mMesh.to_vertex_handle(half)) - mMesh.point(mMesh.from_vertex_handle(half))).sqrnorm();
    return quadricError(half) + kShareOfLength * square * square;
  }

  void putIntoQueue(Vertex vertex) {
    Turn& turn = mTurns[at(vertex)];
    ++turn.number;
    turn.possible.invalidate();
    double least = std::numeric_limits<double>::infinity();
    for (const auto half : mMesh.voh_range(vertex)) least = std::min(least, errorOf(half));
    if (least < std::numeric_limits<double>::infinity()) mQueue.push({least, numberOf(vertex), turn.number});
  }

  /// What collapses now. If the point's cheapest possible collapse costs more than the entry says, it waits for its
  /// turn.
  std::optional<Halfedge> choose(const Entry& entry) {
    Turn& turn = mTurns[entry.vertex];
    if (turn.possible.is_valid()) return turn.possible;
    mChoices.clear();
    for (const auto half : mMesh.voh_range(Vertex(static_cast<int>(entry.vertex))))
      mChoices.emplace_back(errorOf(half), half.idx());
    std::sort(mChoices.begin(), mChoices.end());
    for (const auto& [error, number] : mChoices) {
      const Halfedge half(number);
      if (!keepsTopology(half) || !staysNear(half)) continue;
      if (error <= entry.error) return half;
      turn.possible = half;
      mQueue.push({error, entry.vertex, entry.number});
      break;
    }
    return std::nullopt;
  }

  bool keepsTopology(Halfedge half) {
    if (!mMesh.is_collapse_ok(half)) return false;  // the link condition
    const Halfedge back = mMesh.opposite_halfedge_handle(half);
    const bool hasLeft = mMesh.face_handle(half).is_valid(), hasRight = mMesh.face_handle(back).is_valid();
    const Vertex from = mMesh.from_vertex_handle(half);
    // A point of the border stays at the border, and moves along it.
    if (mMesh.is_boundary(from) && (!mMesh.is_boundary(mMesh.to_vertex_handle(half)) || (hasLeft && hasRight)))
      return false;
    if (mMesh.valence(from) < 3) return false;  // the only triangle would vanish
    if (!hasLeft || !hasRight) return true;
    // Two triangles would become the same one.
    const Vertex left = mMesh.to_vertex_handle(mMesh.next_halfedge_handle(half)),
                 right = mMesh.to_vertex_handle(mMesh.next_halfedge_handle(back));
    return mMesh.valence(left) != 3 || mMesh.valence(right) != 3 || !mMesh.find_halfedge(left, right).is_valid();
  }

  bool staysNear(Halfedge half) {
    const Vertex from = mMesh.from_vertex_handle(half);
    const Vec3d target = pointOf(mMesh.to_vertex_handle(half));
    const Face left = mMesh.face_handle(half), right = mMesh.opposite_face_handle(half);
    mTriangles.clear();
    mLoose.clear();
    mFirst.clear();
    for (const auto face : mMesh.vf_range(from)) {
      const std::vector<std::uint32_t>& samples = mSamplesOfFace[at(face)];
      mLoose.insert(mLoose.end(), samples.begin(), samples.end());
      mFirst.resize(mLoose.size(), mTriangles.size());
      if (face == left || face == right) continue;
      TriangleCorners t;
      std::size_t c = 0;
      for (const auto vertex : mMesh.fv_range(face)) t[c++] = vertex == from ? target : pointOf(vertex);
      const Vec3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
      if (normal.dot(vector(mMesh.normal(face))) < kLeastCosine * normal.length()) return false;
      mTriangles.push_back(t);
    }
    mLoose.push_back(numberOf(from));
    mFirst.push_back(0);
    for (std::size_t i = mLoose.size(); i-- > 0;)
      if (!isNearNewTriangles(mSamples[mLoose[i]], mFirst[i])) return false;
    if (isFlat(half) && !mMesh.is_boundary(from)) return true;
    const auto likely = [&](const Vec3d& place, std::optional<std::uint32_t> nearby) {
      constexpr std::size_t kFewSamples = 100;
      if (nearby && mLoose.size() > kFewSamples) return nearby;
      double least = std::numeric_limits<double>::infinity();
      std::optional<std::uint32_t> triangle;
      for (const std::uint32_t i : mLoose) {
        const double square = (mSamples[i].place - place).lengthSqr();
        if (square < least) least = square, triangle = mSamples[i].triangle;
      }
      return triangle;
    };
    return std::all_of(mTriangles.begin(), mTriangles.end(),
                       [&](const TriangleCorners& t) { return !mProof.farPlace(t, likely); });
  }

  /// @param first  the triangle to be tried first
  bool isNearNewTriangles(const Sample& sample, std::size_t first) const {
    const double square = static_cast<double>(sample.tolerance) * static_cast<double>(sample.tolerance);
    for (std::size_t n = 0; n < mTriangles.size(); ++n)
      if (squaredDistance(sample.place, mTriangles[(first + n) % mTriangles.size()]) <= square) return true;
    return false;
  }

  void carryOut(Halfedge half) {
    const Vertex from = mMesh.from_vertex_handle(half), to = mMesh.to_vertex_handle(half);
    mLoose.assign(1, numberOf(from));
    const auto take = [&](Face face) {
      std::vector<std::uint32_t>& samples = mSamplesOfFace[at(face)];
      mLoose.insert(mLoose.end(), samples.begin(), samples.end());
      samples.clear();
    };
    for (const Face face : {Face(mMesh.face_handle(half)), Face(mMesh.opposite_face_handle(half))})
      if (face.is_valid()) take(face);
    mQuadrics[at(to)] += mQuadrics[at(from)];
    ++mTurns[at(from)].number;
    mMesh.collapse(half);

    mTriangles.clear();
    mAround.clear();
    for (const auto face : mMesh.vf_range(to)) {
      take(face);
      mAround.push_back(face);
      mTriangles.push_back(cornersOf(face));
      mMesh.set_normal(face, mMesh.calc_face_normal(face));
    }
    if (!mAround.empty())
      for (const std::uint32_t sample : mLoose) {
        std::size_t nearest = 0;
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < mAround.size(); ++i) {
          const double square = squaredDistance(mSamples[sample].place, mTriangles[i]);
          if (square < least) least = square, nearest = i;
        }
        mSamplesOfFace[at(mAround[nearest])].push_back(sample);
      }
  }

  HalfedgeMesh& mMesh;
  const Mesh& mBefore;
  NearProof mProof;
  std::vector<OpenMesh::Geometry::Quadricd> mQuadrics;
  std::vector<Turn> mTurns;
  std::vector<Sample> mSamples;
  std::vector<std::vector<std::uint32_t>> mSamplesOfFace;  ///< those for which it is the nearest triangle
  std::priority_queue<Entry> mQueue;
  // Kept to save allocations: of one collapse.
  std::vector<std::pair<double, int>> mChoices;
  std::vector<std::uint32_t> mLoose;  ///< the samples around
  std::vector<std::size_t> mFirst;    ///< for each of them, the new triangle that is probably near
  std::vector<TriangleCorners> mTriangles;
  std::vector<Face> mAround;
};

}  // namespace

void collapseWithin(HalfedgeMesh& mesh, const Mesh& before, const SurfaceSearch& search,
                    const std::vector<float>& tolerances, std::vector<bool> changed, std::vector<Collapse>& history,
                    const Monitor& monitor) {
  BoundedCollapse attempt(mesh, before, search, tolerances);
  attempt.repeat(history, changed);
  attempt.run(history, changed, monitor);
}

}  // namespace vdbtools
