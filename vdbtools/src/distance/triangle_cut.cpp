// SPDX-License-Identifier: Apache-2.0
#include "distance/triangle_cut.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace vdbtools {

using openvdb::Vec2d;

namespace {

double cross(const Vec2d& a, const Vec2d& b) { return a[0] * b[1] - a[1] * b[0]; }

/// Whether a polygon is a sliver, by twice its area over its diameter, which is approximately its width.
bool isSliver(const ConvexPolygon& polygon) {
  double area = 0, squared = 0;
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    area += cross(polygon[i] - polygon[0], polygon[i + 1] - polygon[0]);
  for (std::size_t i = 0; i < polygon.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) squared = std::max(squared, (polygon[i] - polygon[k]).lengthSqr());
  return !(area > kTouch * std::sqrt(squared));
}

/// The two parts of a polygon on either side of a line; one may be empty.
std::pair<ConvexPolygon, ConvexPolygon> halves(const ConvexPolygon& polygon, const Vec2d& on, const Vec2d& along) {
  std::pair<ConvexPolygon, ConvexPolygon> result;
  const auto side = [&](const Vec2d& p) {
    const double d = cross(along, p - on);
    return std::abs(d) < 0.1 * kTouch ? 0.0 : d;
  };
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double a = side(p), b = side(q);
    if (a >= 0) result.first.push_back(p);
    if (a <= 0) result.second.push_back(p);
    if (!(a * b < 0)) continue;
    const Vec2d between = p + (q - p) * (a / (a - b));
    result.first.push_back(between);
    result.second.push_back(between);
  }
  return result;
}

/// Cuts a polygon until no segment passes through the pieces.
void cut(const ConvexPolygon& polygon, const std::vector<PlaneSegment>& segments, int depth,
         std::vector<ConvexPolygon>& pieces) {
  // If there are many segments, halving the polygon first distributes them; then segments cut it one by one.
  constexpr std::size_t kFew = 24;
  constexpr int kMostHalvings = 40, kMostDepth = 4000;
  if (polygon.size() < 3 || isSliver(polygon)) return;
  std::vector<PlaneSegment> through;
  for (const PlaneSegment& segment : segments) {
    const PlaneSegment within = clipped(segment, polygon, kTouch);
    if (isLong(within)) through.push_back(within);
  }
  if (through.empty() || depth > kMostDepth) {
    pieces.push_back(polygon);
    return;
  }
  Vec2d on, along;
  if (through.size() > kFew && depth < kMostHalvings) {
    Vec2d low = polygon[0], high = polygon[0];
    for (const Vec2d& p : polygon) {
      low = {std::min(low[0], p[0]), std::min(low[1], p[1])};
      high = {std::max(high[0], p[0]), std::max(high[1], p[1])};
    }
    on = (low + high) * 0.5;
    along = high[0] - low[0] > high[1] - low[1] ? Vec2d(0, 1) : Vec2d(1, 0);
  } else {
    const PlaneSegment& chosen = through[through.size() / 2];
    on = chosen.from;
    along = (chosen.to - chosen.from) / (chosen.to - chosen.from).length();
  }
  const auto [first, second] = halves(polygon, on, along);
  cut(first, through, depth + 1, pieces);
  cut(second, through, depth + 1, pieces);
}

}  // namespace

PlaneSegment clipped(const PlaneSegment& segment, const ConvexPolygon& polygon, double inset) {
  double from = 0, to = 1;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2d &a = polygon[i], edge = polygon[(i + 1) % polygon.size()] - a;
    const double length = edge.length();
    if (!(length > 0)) continue;
    const double f = cross(edge, segment.from - a) / length - inset, t = cross(edge, segment.to - a) / length - inset;
    if (f < 0 && t < 0) return {segment.from, segment.from};
    if (f < 0) from = std::max(from, f / (f - t));
    if (t < 0) to = std::min(to, f / (f - t));
  }
  if (!(from < to)) return {segment.from, segment.from};
  const Vec2d way = segment.to - segment.from;
  return {segment.from + way * from, segment.from + way * to};
}

bool isLong(const PlaneSegment& segment) { return (segment.to - segment.from).length() > kTouch; }

std::vector<ConvexPolygon> piecesOf(const ConvexPolygon& polygon, const std::vector<PlaneSegment>& segments) {
  std::vector<ConvexPolygon> pieces;
  cut(polygon, segments, 0, pieces);
  return pieces;
}

}  // namespace vdbtools
