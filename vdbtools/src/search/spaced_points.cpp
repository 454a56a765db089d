// SPDX-License-Identifier: Apache-2.0
#include "search/spaced_points.h"
#include "vdbtools/base/text.h"

#include "base/counter_random.h"
#include "base/elementary.h"
#include "base/in_parallel.h"
#include "search/point_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <queue>
#include <sstream>
#include <stdexcept>

namespace vdbtools {
namespace {

using openvdb::Vec3d;
using openvdb::Vec3s;

// Independent streams of random numbers.
enum Stream : std::uint64_t { kArea = 1, kFirst, kSecond, kOrder, kPieces };

constexpr std::size_t kGrain = 512;  ///< points that a thread moves at a time

/// Places on the triangles of a mesh.
class Surface {
 public:
  Surface(const Mesh& mesh, bool keepsCreases) : mMesh(mesh), mKeepsCreases(keepsCreases) {
    mAreas.reserve(mesh.triangles.size());
    for (const openvdb::Vec3I& t : mesh.triangles) {
      const Vec3d& a = mesh.points[t[0]];
      mArea += (mesh.points[t[1]] - a).cross(mesh.points[t[2]] - a).length() / 2;
      mAreas.push_back(mArea);
    }
    if (!(mArea > 0) || !std::isfinite(mArea)) throw DataError("the mesh has no area to place points on");
  }

  const Mesh& mesh() const { return mMesh; }
  double area() const { return mArea; }

  /// The triangle in which the cumulative area reaches the fraction @a share.
  std::uint32_t triangleAt(double share) const {
    const auto at = std::upper_bound(mAreas.begin(), mAreas.end(), share * mArea);
    return static_cast<std::uint32_t>(std::min(at - mAreas.begin(), std::ptrdiff_t(mAreas.size()) - 1));
  }

  PlacedPoint place(std::uint32_t triangle, const Vec3d& weights) const {
    const openvdb::Vec3I& t = mMesh.triangles[triangle];
    PlacedPoint point;
    point.triangle = triangle;
    point.weights = weights;
    point.position = Vec3d(0);
    Vec3d normal(0);
    for (int c = 0; c < 3; ++c) {
      point.position += mMesh.points[t[c]] * weights[c];
      normal += Vec3d(mMesh.normals[t[c]]) * weights[c];
    }
    Vec3d flat = (mMesh.points[t[1]] - mMesh.points[t[0]]).cross(mMesh.points[t[2]] - mMesh.points[t[0]]);
    const bool hasFlat = flat.normalize(0), hasNormal = normal.normalize(1e-6);
    constexpr double kCrease = 0.866;  // the cosine of 30 degrees
    if (hasFlat && (!hasNormal || (mKeepsCreases && flat.dot(normal) < kCrease))) normal = flat;
    point.normal = hasFlat || hasNormal ? Vec3s(normal) : Vec3s(0, 1, 0);
    return point;
  }

  /// Uniform weights over a triangle, from two uniform numbers.
  static Vec3d weightsOf(double u, double v) {
    const double root = std::sqrt(u);
    return {1 - root, root * (1 - v), root * v};
  }

  /// Point number @a i of points that are uniform over the mesh.
  PlacedPoint anywhere(std::uint64_t seed, std::uint64_t i) const {
    return place(triangleAt(randomUnit(seed, kArea, i)),
                 weightsOf(randomUnit(seed, kFirst, i), randomUnit(seed, kSecond, i)));
  }

  /// As above, for stratified points, each with 1 / @a count of the area for itself.
  PlacedPoint stratum(std::uint64_t seed, std::uint64_t i, std::uint64_t count) const {
    return place(triangleAt((static_cast<double>(i) + randomUnit(seed, kArea, i)) / static_cast<double>(count)),
                 weightsOf(randomUnit(seed, kFirst, i), randomUnit(seed, kSecond, i)));
  }

 private:
  const Mesh& mMesh;
  bool mKeepsCreases;
  std::vector<double> mAreas;  ///< cumulative, including each triangle
  double mArea = 0;
};

/// Makes points in threads, and moves them to the true surface.
template <class Make>
std::vector<PlacedPoint> movedPoints(std::size_t count, const PointMover& move, const Monitor& monitor,
                                     const Make& make) {
  std::vector<PlacedPoint> points(count);
  inParallel(count, kGrain, monitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) points[i] = make(i);
    if (move) move(std::span(points).subspan(begin, end - begin));
  });
  return points;
}

/// Measures the spacing and the reach of finished points.
void measure(SpacedPoints& result, const Surface& surface, double usual, std::uint64_t seed, const Monitor& monitor) {
  PointCells cells(usual, surface.mesh().points[surface.mesh().triangles[0][0]]);
  for (const PlacedPoint& point : result.points) cells.add(point.position);
  // Searches in rings of growing width, because points may be lost over wide regions.
  const auto nearest = [&](const Vec3d& p, std::int64_t except, double most) {
    for (double within = usual;; within *= 2) {
      double best = std::numeric_limits<double>::infinity();
      cells.forEachWithin(p, std::min(within, most), [&](std::uint32_t i, double square) {
        if (i != except) best = std::min(best, square);
        return true;
      });
      if (std::isfinite(best) || within >= most) return std::sqrt(best);
    }
  };
  constexpr int kMostRings = 8;  // each twice as wide as the previous one
  const double most = usual * kMostRings;
  std::vector<double> apart(result.points.size()), away(4 * result.points.size());
  inParallel(apart.size(), kGrain, monitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      apart[i] = nearest(result.points[i].position, static_cast<std::int64_t>(i), most);
  });
  inParallel(away.size(), kGrain, monitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      away[i] = std::min(most, nearest(surface.stratum(~seed, i, away.size()).position, -1, most));
  });
  const double least = *std::min_element(apart.begin(), apart.end());
  result.spacing = std::isfinite(least) ? least : 0;
  result.reach = *std::max_element(away.begin(), away.end());
}

void requireSome(const SpacedPoints& result) {
  if (!result.points.empty()) return;
  throw DataError("no point was found on the surface: all " + std::to_string(result.lost) +
                  " that were tried lie too far from it; the mesh is too coarse for it");
}

// Dart throwing.

/// A part of a triangle that points do not cover yet.
struct Piece {
  std::uint32_t triangle;
  std::array<Vec3d, 3> corners;  ///< as weights of the triangle's corners
};

class DartThrower {
 public:
  DartThrower(const Surface& surface, double spacing, const SpacedPointsOptions& options, Monitor& monitor)
      : mSurface(surface),
        mSpacing(spacing),
        mOptions(options),
        mMonitor(monitor),
        mCells(spacing, surface.mesh().points[surface.mesh().triangles[0][0]]) {}

  SpacedPoints run() {
    throwAnywhere();
    throwAtPieces();
    return std::move(mResult);
  }

 private:
  /// Keeps those points, in order, that are far enough from all previous ones.
  void accept(const std::vector<PlacedPoint>& points, const std::vector<std::uint32_t>& order) {
    for (const std::uint32_t i : order) {
      const PlacedPoint& point = points[i];
      if (point.lost) {
        ++mResult.lost;
      } else if (!mCells.anyWithin(point.position, mSpacing)) {
        mCells.add(point.position);
        mResult.points.push_back(point);
      }
    }
  }

  void throwAnywhere() {
    constexpr double kDarts = 3;  // per square of the spacing, about four times as many as will remain
    constexpr std::size_t kAtOnce = std::size_t{1} << 15;
    const auto count = static_cast<std::size_t>(kDarts * mSurface.area() / (mSpacing * mSpacing)) + 1;
    mMonitor.begin(PhaseKind::Points, count);
    std::vector<std::uint32_t> order(kAtOnce);
    std::iota(order.begin(), order.end(), 0U);
    for (std::size_t begin = 0; begin < count; begin += kAtOnce) {
      const std::size_t size = std::min(kAtOnce, count - begin);
      order.resize(size);
      accept(movedPoints(size, mOptions.move, mMonitor,
                         [&](std::size_t i) { return mSurface.anywhere(mOptions.seed, begin + i); }),
             order);
      mMonitor.advance(size);
    }
  }

  /// Whether a single point covers all of a piece.
  bool covered(const Piece& piece) const {
    std::array<Vec3d, 3> corners;
    for (std::size_t c = 0; c < 3; ++c) corners[c] = at(piece, piece.corners[c]);
    const Vec3d middle = (corners[0] + corners[1] + corners[2]) / 3.0;
    const double square = mSpacing * mSpacing;
    return !mCells.forEachWithin(middle, mSpacing, [&](std::uint32_t i, double) {
      return !std::all_of(corners.begin(), corners.end(),
                          [&](const Vec3d& corner) { return (corner - mCells[i]).lengthSqr() < square; });
    });
  }

  Vec3d at(const Piece& piece, const Vec3d& weights) const {
    const openvdb::Vec3I& t = mSurface.mesh().triangles[piece.triangle];
    const std::vector<Vec3d>& points = mSurface.mesh().points;
    return points[t[0]] * weights[0] + points[t[1]] * weights[1] + points[t[2]] * weights[2];
  }

  std::vector<Piece> uncovered(const std::vector<Piece>& pieces) const {
    std::vector<char> open(pieces.size());
    inParallel(pieces.size(), kGrain, mMonitor, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) open[i] = !covered(pieces[i]);
    });
    std::vector<Piece> result;
    for (std::size_t i = 0; i < pieces.size(); ++i)
      if (open[i]) result.push_back(pieces[i]);
    return result;
  }

  /// The two halves of each piece, without those that are too small to contain a relevant gap.
  std::vector<Piece> halves(const std::vector<Piece>& pieces) const {
    constexpr double kSmallest = 0.1;  // of the spacing; the amount by which a gap may extend the distance from a point
    std::vector<Piece> result;
    for (const Piece& piece : pieces) {
      double longest = 0;
      std::size_t side = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        const double length = (at(piece, piece.corners[(c + 1) % 3]) - at(piece, piece.corners[c])).length();
        if (length > longest) longest = length, side = c;
      }
      if (longest < kSmallest * mSpacing) continue;
      const Vec3d half = (piece.corners[side] + piece.corners[(side + 1) % 3]) / 2.0;
      result.push_back({piece.triangle, {piece.corners[side], half, piece.corners[(side + 2) % 3]}});
      result.push_back({piece.triangle, {half, piece.corners[(side + 1) % 3], piece.corners[(side + 2) % 3]}});
    }
    return result;
  }

  /// Tries a point in each piece; pieces are in random order, so that none precedes its neighbours for long.
  void throwAt(const std::vector<Piece>& pieces, std::uint64_t round) {
    const std::uint64_t stream = kPieces + 3 * round;
    std::vector<std::uint64_t> keys(pieces.size());
    for (std::size_t i = 0; i < keys.size(); ++i) keys[i] = randomBits(mOptions.seed, stream, i);
    std::vector<std::uint32_t> order(pieces.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return keys[a] != keys[b] ? keys[a] < keys[b] : a < b; });
    const auto make = [&](std::size_t i) {
      const Vec3d weights =
          Surface::weightsOf(randomUnit(mOptions.seed, stream + 1, i), randomUnit(mOptions.seed, stream + 2, i));
      Vec3d within(0);
      for (std::size_t c = 0; c < 3; ++c) within += pieces[i].corners[c] * weights[static_cast<int>(c)];
      return mSurface.place(pieces[i].triangle, within);
    };
    accept(movedPoints(pieces.size(), mOptions.move, mMonitor, make), order);
  }

  void throwAtPieces() {
    std::vector<Piece> pieces;
    const std::size_t triangles = mSurface.mesh().triangles.size();
    constexpr std::size_t kAtOnce = std::size_t{1} << 18;
    for (std::size_t begin = 0; begin < triangles; begin += kAtOnce) {
      std::vector<Piece> some;
      for (std::size_t t = begin; t < std::min(triangles, begin + kAtOnce); ++t)
        some.push_back({static_cast<std::uint32_t>(t), {Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)}});
      some = uncovered(some);
      pieces.insert(pieces.end(), some.begin(), some.end());
    }
    mMonitor.begin(PhaseKind::Gaps, 0);
    for (std::uint64_t round = 0; !pieces.empty(); ++round) {
      throwAt(pieces, round);
      pieces = uncovered(halves(uncovered(pieces)));
    }
  }

  const Surface& mSurface;
  double mSpacing;
  const SpacedPointsOptions& mOptions;
  Monitor& mMonitor;
  PointCells mCells;
  SpacedPoints mResult;
};

// Weighted sample elimination.

/// Removes points one by one, always the most crowded one, until @a count are left.
std::vector<PlacedPoint> eliminated(const std::vector<PlacedPoint>& points, std::size_t count, double area,
                                    Monitor& monitor) {
  // The names and values of [Yuksel 2015].
  constexpr double kAlpha = 8, kBeta = 0.65, kGamma = 1.5;
  const double most = std::sqrt(area / (2 * std::sqrt(3.0) * static_cast<double>(count)));
  const double least =
      most * (1 - elementary::pow(static_cast<double>(count) / static_cast<double>(points.size()), kGamma)) * kBeta;
  const auto weight = [&](double squaredDistance) {
    const double distance = std::max(std::sqrt(squaredDistance), 2 * least);
    return elementary::pow(1 - std::min(distance, 2 * most) / (2 * most), kAlpha);
  };
  PointCells cells(2 * most, points.front().position);
  for (const PlacedPoint& point : points) cells.add(point.position);
  std::vector<double> weights(points.size());
  inParallel(points.size(), kGrain, monitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      cells.forEachWithin(points[i].position, 2 * most, [&](std::uint32_t other, double square) {
        if (other != i) weights[i] += weight(square);
        return true;
      });
  });
  // Outdated entries stay in the queue when a weight decreases; they are recognised by their weight.
  using Entry = std::pair<double, std::uint32_t>;
  std::vector<Entry> entries;
  for (std::size_t i = 0; i < points.size(); ++i) entries.emplace_back(weights[i], static_cast<std::uint32_t>(i));
  std::priority_queue<Entry> queue(std::less<Entry>(), std::move(entries));
  std::vector<char> gone(points.size(), 0);
  monitor.begin(PhaseKind::Elimination, points.size() - count);
  for (std::size_t left = points.size(); left > count;) {
    const auto [heaviest, i] = queue.top();
    queue.pop();
    if (gone[i]) continue;
    if (heaviest != weights[i]) {
      queue.emplace(weights[i], i);
      continue;
    }
    gone[i] = 1;
    --left;
    monitor.advance(1);
    if (left % 4096 == 0) monitor.throwIfCancelled();
    cells.forEachWithin(points[i].position, 2 * most, [&](std::uint32_t other, double square) {
      if (!gone[other]) weights[other] -= weight(square);
      return true;
    });
  }
  std::vector<PlacedPoint> result;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!gone[i]) result.push_back(points[i]);
  return result;
}

}  // namespace

SpacedPoints pointsBySpacing(const Mesh& mesh, double spacing, const SpacedPointsOptions& options, Monitor& monitor) {
  constexpr double kMostPoints = 1 << 27;
  const Surface surface(mesh, options.keepsCreases);
  constexpr double kJammed = 0.7;  // points per square of the spacing when random darts fill a plane
  const double expected = kJammed * surface.area() / (spacing * spacing);
  if (!(spacing > 0) || !std::isfinite(spacing))
    throw std::invalid_argument("points cannot be spaced by " + shortText(spacing) + "; the spacing must be positive");
  if (!(expected <= kMostPoints))
    throw std::invalid_argument("a spacing of " + shortText(spacing) + " would take some " + shortText(expected) +
                                " points on this surface, whose area is " + shortText(surface.area()) +
                                "; take a larger spacing");
  SpacedPoints result = DartThrower(surface, spacing, options, monitor).run();
  requireSome(result);
  measure(result, surface, spacing, options.seed, monitor);
  return result;
}

SpacedPoints pointsByCount(const Mesh& mesh, std::uint64_t count, const SpacedPointsOptions& options,
                           Monitor& monitor) {
  constexpr std::uint64_t kMostPoints = std::uint64_t{1} << 25;
  if (count == 0 || count > kMostPoints)
    throw std::invalid_argument("the number of points is " + std::to_string(count) + "; it must be 1 to " +
                                std::to_string(kMostPoints));
  const Surface surface(mesh, options.keepsCreases);
  constexpr std::uint64_t kCandidates = 5;  // for each wanted point, as the paper recommends
  constexpr int kMostTries = 4;             // to make up for points that were lost
  SpacedPoints result;
  std::vector<PlacedPoint> candidates;
  for (std::uint64_t attempt = 0; attempt < kMostTries && candidates.size() < kCandidates * count; ++attempt) {
    const std::uint64_t wanted = (kCandidates * count - candidates.size()) << attempt;
    monitor.begin(PhaseKind::Points, 0);
    const auto make = [&](std::size_t i) { return surface.stratum(options.seed + attempt * 0x51ed27U, i, wanted); };
    for (const PlacedPoint& point : movedPoints(wanted, options.move, monitor, make)) {
      if (point.lost) {
        ++result.lost;
      } else {
        candidates.push_back(point);
      }
    }
  }
  result.points = std::move(candidates);
  requireSome(result);
  if (result.points.size() < 2 * count)
    throw DataError("only " + std::to_string(result.points.size()) + " of " +
                    std::to_string(result.points.size() + result.lost) +
                    " places lie near the surface, too few to choose " + std::to_string(count) +
                    " points from; the mesh is too coarse for it");
  result.points = eliminated(result.points, count, surface.area(), monitor);
  measure(result, surface, std::sqrt(surface.area() / static_cast<double>(count)), options.seed, monitor);
  return result;
}

}  // namespace vdbtools
