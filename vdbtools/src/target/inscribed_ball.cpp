// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/target/target_survey.h"

#include "distance/level_surface.h"
#include "search/triangle_tree.h"
#include "vdbtools/base/errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <queue>
#include <unordered_map>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::BBoxd;
using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3d;
using openvdb::Vec3I;

// All lengths are in voxels, and all positions in index space.

/// No ball scores better by more than this than the one that is found, unless many are nearly equal.
constexpr double kTolerance = 1e-4;
/// Over a step, the distance to a surface changes by no more than the length of the step, and the pulls by their
/// fractions of it.
constexpr double kSteepest = 1 + kInscribedBallPull + kInscribedBallTieBreak;
/// The direction of the second pull, of length 1; neither an axis nor a diagonal, which are symmetrical in many shapes.
const Vec3d kTieDirection(0.8, 0.48, 0.36);
/// Half of a voxel's diagonal.
constexpr double kCorner = 0.8660254037844387;
/// Distances that were interpolated may be too small by this.
constexpr double kSlack = 0.1;
/// A ball about a point of a node's voxel scores better than the node's by no more than this.
constexpr double kReach = kSteepest * kCorner + kSlack;

/// The score of a ball: its radius, with the pulls toward the preferred point and along the direction.
struct Score {
  Vec3d preferred;
  double operator()(const Vec3d& centre, double radius) const {
    const Vec3d way = centre - preferred;
    return radius - kInscribedBallPull * way.length() + kInscribedBallTieBreak * way.dot(kTieDirection);
  }
};

struct Node {
  Coord at;
  double depth = 0, score = 0;
};

/// The nodes around which the best centre may lie, in the order of coordinates.
std::vector<Node> candidateNodes(const FloatGrid& phi, double voxel, const Score& score) {
  double best = -std::numeric_limits<double>::infinity();
  std::vector<Node> nodes;
  for (auto value = phi.cbeginValueOn(); value; ++value) {
    if (!(*value < 0)) continue;
    const double depth = -static_cast<double>(*value) / voxel, here = score(value.getCoord().asVec3d(), depth);
    best = std::max(best, here);
    if (here > best - kReach) nodes.push_back({value.getCoord(), depth, here});
  }
  if (nodes.empty()) throw DataError("the signed distance field is nowhere negative: it has no inside");
  std::erase_if(nodes, [&](const Node& node) { return !(node.score > best - kReach); });
  std::sort(nodes.begin(), nodes.end(), [](const Node& a, const Node& b) { return a.at < b.at; });
  return nodes;
}

/// Triangles, and their tree.
class Surface {
 public:
  explicit Surface(LevelSurface surface) : mSurface(std::make_unique<const LevelSurface>(std::move(surface))) {
    if (!mSurface->triangles.empty())
      mTree = std::make_unique<const TriangleTree>(mSurface->points, mSurface->triangles);
  }
  bool empty() const { return !mTree; }
  TriangleTree::Nearest nearest(const Vec3d& position) const {
    return mTree->nearest(position, std::numeric_limits<float>::max()).value();
  }

 private:
  std::unique_ptr<const LevelSurface> mSurface;  // the tree refers to it
  std::unique_ptr<const TriangleTree> mTree;
};

/// The triangles of a mesh that may touch a ball about one of the nodes' cells.
Surface partAbout(const std::vector<Node>& nodes, const Mesh& mesh, const openvdb::math::Transform& transform) {
  BBoxd reach;
  double depth = 0;
  for (const Node& node : nodes) {
    reach.expand(node.at.asVec3d());
    depth = std::max(depth, node.depth);
  }
  reach.expand(depth + 2);
  LevelSurface part;
  std::unordered_map<std::uint32_t, std::uint32_t> numbers;
  for (const Vec3I& triangle : mesh.triangles) {
    Vec3d corner[3];
    BBoxd box;
    for (int c = 0; c < 3; ++c) {
      corner[c] = transform.worldToIndex(mesh.points[triangle[c]]);
      box.expand(corner[c]);
    }
    if (!box.hasOverlap(reach)) continue;
    Vec3I kept;
    for (int c = 0; c < 3; ++c) {
      const auto [number, isNew] = numbers.try_emplace(triangle[c], static_cast<std::uint32_t>(part.points.size()));
      if (isNew) part.points.push_back(corner[c]);
      kept[c] = number->second;
    }
    part.triangles.push_back(kept);
  }
  return Surface(std::move(part));
}

/// Whether the nodes' distances are those to the triangles: others of a mesh may lie within a part, for example.
bool isMeasuredFrom(const Surface& surface, const std::vector<Node>& nodes) {
  constexpr double kSame = 1e-3;
  constexpr std::size_t kMost = 256;
  const std::size_t step = nodes.size() / kMost + 1;
  for (std::size_t i = 0; i < nodes.size(); i += step)
    if (!(std::abs(surface.nearest(nodes[i].at.asVec3d()).distance - nodes[i].depth) <= kSame)) return false;
  return true;
}

Surface surfaceAbout(const std::vector<Node>& nodes, const FloatGrid& phi, const Mesh* mesh) {
  if (mesh) {
    Surface part = partAbout(nodes, *mesh, phi.transform());
    if (!part.empty() && isMeasuredFrom(part, nodes)) return part;
  }
  // With an identity as its transform, so that the points are in index space.
  const FloatGrid inVoxels(std::const_pointer_cast<openvdb::FloatTree>(phi.constTreePtr()));
  return Surface(levelSurface(inVoxels, 0));
}

/// Branch and bound [LD60] over cubes. The distance to some points of the surface is an upper bound of that to the
/// surface. The points nearest to the most recently tried centres serve for this, because few other points touch a ball
/// that is nearly the largest.
class BallSearch {
 public:
  BallSearch(const Surface& surface, const Score& score) : mSurface(surface), mScore(score) {}

  /// Tries a centre.
  void attempt(const Vec3d& centre) {
    const TriangleTree::Nearest nearest = mSurface.nearest(centre);
    const double score = mScore(centre, nearest.distance);
    if (score > mBest) mBest = score, mBall = {centre, nearest.distance};
    mTouched[mTried++ % mTouched.size()] = nearest.point;
  }
  void add(const Vec3d& middle, double half, double bound) {
    const double here = atMost(middle);
    bound = std::min(bound, here + kSteepest * std::sqrt(3.0) * half);
    if (bound > mBest + kTolerance) mCubes.push({middle, half, bound});
  }
  InscribedBall find() {
    // A limit to time, which shapes of many equal balls reach.
    constexpr int kMostCubes = 100000;
    for (int i = 0; i < kMostCubes && !mCubes.empty(); ++i) {
      const Cube cube = mCubes.top();
      if (!(cube.bound > mBest + kTolerance)) break;
      mCubes.pop();
      if (atMost(cube.middle) > mBest) attempt(cube.middle);
      const double half = cube.half / 2;
      for (int n = 0; n < 8; ++n)
        add(cube.middle + Vec3d(n & 4 ? half : -half, n & 2 ? half : -half, n & 1 ? half : -half), half, cube.bound);
    }
    return mBall;
  }

 private:
  struct Cube {
    Vec3d middle;
    double half = 0, bound = 0;
    bool operator<(const Cube& other) const { return bound < other.bound; }
  };

  double atMost(const Vec3d& centre) const {
    double squared = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < std::min(mTried, mTouched.size()); ++i)
      squared = std::min(squared, (mTouched[i] - centre).lengthSqr());
    return mScore(centre, std::sqrt(squared));
  }

  const Surface& mSurface;
  Score mScore;
  InscribedBall mBall;
  double mBest = -std::numeric_limits<double>::infinity();
  std::array<Vec3d, 128> mTouched;
  std::size_t mTried = 0;
  std::priority_queue<Cube> mCubes;
};

}  // namespace

InscribedBall largestInscribedBall(const FloatGrid& phi, const Vec3d& preferred, const Mesh* mesh) {
  const double voxel = phi.voxelSize()[0];
  const Score score{phi.worldToIndex(preferred)};
  const std::vector<Node> nodes = candidateNodes(phi, voxel, score);
  const Node& best =
      *std::max_element(nodes.begin(), nodes.end(), [](const Node& a, const Node& b) { return a.score < b.score; });
  const Surface surface = surfaceAbout(nodes, phi, mesh);
  if (surface.empty()) return {phi.indexToWorld(best.at.asVec3d()), best.depth * voxel};
  BallSearch search(surface, score);
  search.attempt(best.at.asVec3d());
  for (const Node& node : nodes) search.add(node.at.asVec3d(), 0.5, node.score + kReach);
  const InscribedBall found = search.find();
  return {phi.indexToWorld(found.centre), found.radius * voxel};
}

}  // namespace vdbtools
