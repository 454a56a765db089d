// SPDX-License-Identifier: Apache-2.0
#include "distance/triangle_cut.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

namespace {

using openvdb::Vec2d;
using openvdb::Vec3d;
using vdbtools::ConvexPolygon;
using vdbtools::kTouch;
using vdbtools::PlaneSegment;

double crossed(const Vec2d& a, const Vec2d& b) { return a[0] * b[1] - a[1] * b[0]; }

double areaOf(const ConvexPolygon& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) twice += crossed(polygon[i], polygon[(i + 1) % polygon.size()]);
  return twice / 2;
}

/// The distance to the nearest line of an edge, positive within.
double depthIn(const ConvexPolygon& polygon, const Vec2d& p) {
  double least = 1e300;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2d &a = polygon[i], edge = polygon[(i + 1) % polygon.size()] - a;
    if (edge.length() > 0) least = std::min(least, crossed(edge, p - a) / edge.length());
  }
  return least;
}

/// The middle of a polygon's corners.
Vec2d middleOf(const ConvexPolygon& polygon) {
  Vec2d sum(0, 0);
  for (const Vec2d& p : polygon) sum += p;
  return sum / static_cast<double>(polygon.size());
}

class Numbers {
 public:
  explicit Numbers(unsigned seed) : mRandom(seed) {}
  double between(double low, double high) { return std::uniform_real_distribution<>(low, high)(mRandom); }
  Vec2d point() {
    const double x = between(-2, 6);
    return {x, between(-2, 6)};
  }
  PlaneSegment segment() {
    const Vec2d from = point();
    return {from, point()};
  }

 private:
  std::mt19937 mRandom;
};

/// Asserts what piecesOf() promises.
void expectTiling(const ConvexPolygon& polygon, const std::vector<PlaneSegment>& segments, double diameter) {
  const std::vector<ConvexPolygon> pieces = vdbtools::piecesOf(polygon, segments);
  double sum = 0;
  for (const ConvexPolygon& piece : pieces) {
    const double area = areaOf(piece);
    ASSERT_GT(area, 0);
    sum += area;
    for (const Vec2d& p : piece) ASSERT_GE(depthIn(polygon, p), -1e-9);
    // Convex: no corner is beyond the line of an edge, up to the tolerance within which corners count as on a line.
    for (const Vec2d& p : piece) ASSERT_GE(depthIn(piece, p), -kTouch);
    for (const PlaneSegment& segment : segments)
      for (int k = 0; k <= 200; ++k)
        ASSERT_LE(depthIn(piece, segment.from + (segment.to - segment.from) * (k / 200.0)), 3 * kTouch)
            << "a segment passes through a piece";
  }
  // Pieces lie within the polygon, so they tile it if their areas add up. Each cut may leave out a sliver.
  const double slivers = static_cast<double>(pieces.size() + segments.size()) * kTouch * diameter;
  EXPECT_NEAR(sum, areaOf(polygon), slivers);
  // In the middle of a piece there is no other one.
  for (std::size_t i = 0; i < pieces.size(); ++i)
    for (std::size_t k = 0; k < pieces.size(); ++k)
      if (k != i) {
        EXPECT_LE(depthIn(pieces[k], middleOf(pieces[i])), kTouch);
      }
}

TEST(TriangleCut, PiecesTileTheTriangleAndNoSegmentPassesThroughOne) {
  Numbers numbers(62);
  for (const int count : {1, 2, 5, 20, 60}) {
    SCOPED_TRACE(count);
    for (int turn = 0; turn < 10; ++turn) {
      const ConvexPolygon triangle = {{0, 0}, {4, 0}, {numbers.between(-1, 4), numbers.between(1, 4)}};
      std::vector<PlaneSegment> segments;
      for (int k = 0; k < count; ++k) segments.push_back(numbers.segment());
      ASSERT_NO_FATAL_FAILURE(expectTiling(triangle, segments, 8));
    }
  }
}

TEST(TriangleCut, PiecesTileTheTriangleWhereSegmentsMeetAndRepeat) {
  const ConvexPolygon triangle = {{0, 0}, {4, 0}, {0, 4}};
  std::vector<PlaneSegment> segments;
  for (int k = 0; k < 12; ++k) {
    // A fan about a point, each segment twice, and segments that end at it.
    const double angle = 0.5 * k;
    const Vec2d way(3 * std::cos(angle), 3 * std::sin(angle));
    segments.push_back({Vec2d(1, 1) - way, Vec2d(1, 1) + way});
    segments.push_back(segments.back());
    segments.push_back({Vec2d(1, 1), Vec2d(1, 1) + way * 0.2});
  }
  // Along an edge, and a point: these cut nothing.
  segments.push_back({{0, 0}, {4, 0}});
  segments.push_back({{1, 0.5}, {1, 0.5}});
  ASSERT_NO_FATAL_FAILURE(expectTiling(triangle, segments, 6));
}

TEST(TriangleCut, IsNotCutByWhatLiesOutsideOrAlongItsEdges) {
  const ConvexPolygon triangle = {{0, 0}, {4, 0}, {0, 4}};
  const std::vector<PlaneSegment> beside = {
      {{0, 0}, {4, 0}}, {{-1, 0}, {5, 0}}, {{4, 0}, {0, 4}}, {{3, 3}, {9, 9}}, {{-2, 1}, {-1, 5}}};
  const std::vector<ConvexPolygon> pieces = vdbtools::piecesOf(triangle, beside);
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_EQ(pieces.front(), triangle);
}

TEST(TriangleCut, ClippedSegmentsAreTheirPointsWithinThePolygon) {
  Numbers numbers(63);
  const ConvexPolygon polygon = {{0, 0}, {3, -1}, {4, 1}, {2, 4}, {0, 3}};
  int met = 0;
  for (int turn = 0; turn < 500; ++turn) {
    const PlaneSegment whole = numbers.segment();
    const double inset = turn % 3 == 0 ? 0 : numbers.between(-0.3, 0.3);
    const PlaneSegment part = vdbtools::clipped(whole, polygon, inset);
    const Vec2d way = whole.to - whole.from;
    const double length = way.length();
    const auto place = [&](const Vec2d& p) { return way.dot(p - whole.from) / (length * length); };
    const bool exists = place(part.to) > place(part.from);
    met += exists;
    for (int k = 0; k <= 100; ++k) {
      const double s = k / 100.0, depth = depthIn(polygon, whole.from + way * s);
      const bool isKept = exists && s >= place(part.from) - 1e-12 && s <= place(part.to) + 1e-12;
      if (depth > inset + 1e-9) {
        EXPECT_TRUE(isKept) << depth << " within, with an inset of " << inset;
      }
      if (depth < inset - 1e-9) {
        EXPECT_FALSE(isKept && s > place(part.from) + 1e-9 && s < place(part.to) - 1e-9) << depth;
      }
    }
  }
  EXPECT_GT(met, 100);
  EXPECT_LT(met, 500);
}

TEST(TriangleCut, PlanesKeepDistances) {
  Numbers numbers(64);
  const auto spatial = [&numbers] {
    const Vec2d p = numbers.point();
    return Vec3d(p[0], p[1], numbers.between(-2, 6));
  };
  for (int turn = 0; turn < 100; ++turn) {
    const Vec3d a = spatial(), b = spatial(), c = spatial(), p = spatial(), q = spatial();
    const vdbtools::TrianglePlane plane(a, b, c);
    for (const Vec3d& corner : {a, b, c}) EXPECT_NEAR(plane.height(corner), 0, 1e-9);
    EXPECT_GT(plane.normal().dot((b - a).cross(c - a)), 0);
    EXPECT_GT(areaOf({plane.flat(a), plane.flat(b), plane.flat(c)}), 0);
    EXPECT_NEAR((plane.space(plane.flat(p)) + plane.normal() * plane.height(p) - p).length(), 0, 1e-9);
    const double flat = (plane.flat(p) - plane.flat(q)).length(), up = plane.height(p) - plane.height(q);
    EXPECT_NEAR(flat * flat + up * up, (p - q).lengthSqr(), 1e-9);
  }
}

}  // namespace
