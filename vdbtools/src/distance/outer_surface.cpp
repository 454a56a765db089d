// SPDX-License-Identifier: Apache-2.0
/// The algorithm has three steps. It finds the parts; it cuts each triangle along the segments in which others meet it,
/// so that every piece lies entirely inside or entirely outside a part; and it tests at one point of each piece, or of
/// each patch of uncut triangles, on which of its two sides there is an outside. Pieces need not fit together, because
/// only distances to them are needed. Therefore nothing here depends on exact arithmetic: a rounding error makes a gap
/// of its own size.
#include "distance/outer_surface.h"

#include "base/disjoint_sets.h"
#include "base/in_parallel.h"
#include "distance/triangle_boxes.h"
#include "mesh/position_table.h"

#include <tbb/concurrent_unordered_map.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>

namespace vdbtools {
namespace {

using openvdb::BBoxd;
using openvdb::Vec2d;
using openvdb::Vec3d;
using openvdb::Vec3I;

/// In voxels. Coordinates that a file stores as floats have larger errors than doubles: 2e-6 for 50 voxels about the
/// origin.
constexpr double kTouch = 1e-5;

constexpr std::uint32_t kNone = 0xffffffff;

/// How a part determines what is inside.
enum class Closure : std::uint8_t { Open, Parity, Winding };

/// Whether a triangle has an outside next to it.
enum class Fate : std::uint8_t { Kept, Buried, Sliver, Cut, Touched, Whole };

struct Parts {
  std::vector<std::uint32_t> of;       ///< the part of each triangle
  std::vector<Closure> closure;        ///< of each part
  std::vector<BBoxd> box;              ///< of each part
  std::vector<std::uint32_t> partner;  ///< three per triangle: the triangle beyond each edge, if there is exactly one
};

/// One use of an edge by a triangle.
struct EdgeUse {
  std::uint64_t edge = 0;  ///< its smaller point, then its larger one
  std::uint32_t triangle = 0;
  std::uint8_t corner = 0;
  bool forward = false;  ///< from the smaller point to the larger one

  bool operator<(const EdgeUse& other) const {
    return edge < other.edge || (edge == other.edge && triangle < other.triangle);
  }
};

bool repeatsCorner(const Vec3I& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

Parts findParts(const std::vector<Vec3d>& points, const std::vector<Vec3I>& triangles) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    if (repeatsCorner(triangles[t])) continue;
    for (std::uint8_t c = 0; c < 3; ++c) {
      const std::uint64_t a = triangles[t][c], b = triangles[t][(c + 1) % 3];
      uses.push_back({a < b ? a << 32 | b : b << 32 | a, t, c, a < b});
    }
  }
  tbb::parallel_sort(uses.begin(), uses.end());
  DisjointSets<std::uint32_t> sets(triangles.size());
  std::vector<Closure> closure(triangles.size(), Closure::Winding);
  Parts parts;
  parts.partner.assign(3 * triangles.size(), kNone);
  for (std::size_t first = 0, end = 0; first < uses.size(); first = end) {
    int balance = 0;
    for (end = first; end < uses.size() && uses[end].edge == uses[first].edge; ++end) {
      balance += uses[end].forward ? 1 : -1;
      sets.join(uses[first].triangle, uses[end].triangle);
    }
    const std::size_t count = end - first;
    Closure& here = closure[uses[first].triangle];
    if (balance != 0) here = std::min(here, count % 2 == 0 ? Closure::Parity : Closure::Open);
    if (count != 2) continue;
    const EdgeUse &a = uses[first], &b = uses[first + 1];
    parts.partner[3 * a.triangle + a.corner] = b.triangle;
    parts.partner[3 * b.triangle + b.corner] = a.triangle;
  }
  parts.of.assign(triangles.size(), kNone);
  std::vector<std::uint32_t> numbers(triangles.size(), kNone);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    if (repeatsCorner(triangles[t])) continue;
    std::uint32_t& number = numbers[sets.find(t)];
    if (number == kNone) {
      number = static_cast<std::uint32_t>(parts.closure.size());
      parts.closure.push_back(Closure::Winding);
      parts.box.emplace_back();
    }
    parts.of[t] = number;
    parts.closure[number] = std::min(parts.closure[number], closure[t]);
    for (int c = 0; c < 3; ++c) parts.box[number].expand(points[triangles[t][c]]);
  }
  return parts;
}

/// Whether the box of a closed part meets that of another part.
bool mayMeet(const Parts& parts) {
  std::vector<std::uint32_t> order(parts.box.size());
  for (std::uint32_t p = 0; p < order.size(); ++p) order[p] = p;
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double x = parts.box[a].min()[0], y = parts.box[b].min()[0];
    return x < y || (x == y && a < b);
  });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const BBoxd& box = parts.box[order[i]];
    for (std::size_t k = i + 1; k < order.size() && parts.box[order[k]].min()[0] <= box.max()[0]; ++k)
      if (box.hasOverlap(parts.box[order[k]]) &&
          (parts.closure[order[i]] != Closure::Open || parts.closure[order[k]] != Closure::Open))
        return true;
  }
  return false;
}

/// In the plane of a triangle.
struct Segment {
  Vec2d from, to;
};

using Polygon = std::vector<Vec2d>;  ///< convex, counter-clockwise

double cross(const Vec2d& a, const Vec2d& b) { return a[0] * b[1] - a[1] * b[0]; }

/// A triangle's plane, and positions in it.
class Plane {
 public:
  /// @pre not a sliver
  Plane(const Vec3d& a, const Vec3d& b, const Vec3d& c) : mOrigin(a) {
    mFirst = b - a;
    mFirst.normalize();
    mNormal = (b - a).cross(c - a);
    mNormal.normalize();
    mSecond = mNormal.cross(mFirst);
  }

  const Vec3d& normal() const { return mNormal; }
  double height(const Vec3d& p) const { return mNormal.dot(p - mOrigin); }
  Vec2d flat(const Vec3d& p) const { return {mFirst.dot(p - mOrigin), mSecond.dot(p - mOrigin)}; }
  Vec3d space(const Vec2d& p) const { return mOrigin + mFirst * p[0] + mSecond * p[1]; }

 private:
  Vec3d mOrigin, mFirst, mSecond, mNormal;
};

/// The part of a segment that is at least @a inset within the polygon's edges; from = to: none.
Segment clipped(const Segment& segment, const Polygon& polygon, double inset) {
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

bool isLong(const Segment& segment) { return (segment.to - segment.from).length() > kTouch; }

/// Whether a polygon is a sliver, by twice its area over its diameter, which is approximately its width.
bool isSliver(const Polygon& polygon) {
  double area = 0, squared = 0;
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    area += cross(polygon[i] - polygon[0], polygon[i + 1] - polygon[0]);
  for (std::size_t i = 0; i < polygon.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) squared = std::max(squared, (polygon[i] - polygon[k]).lengthSqr());
  return !(area > kTouch * std::sqrt(squared));
}

/// The two parts of a polygon on either side of a line; one may be empty.
std::pair<Polygon, Polygon> halves(const Polygon& polygon, const Vec2d& on, const Vec2d& along) {
  std::pair<Polygon, Polygon> result;
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
void cut(const Polygon& polygon, const std::vector<Segment>& segments, int depth, std::vector<Polygon>& pieces) {
  // If there are many segments, halving the polygon first distributes them; then segments cut it one by one.
  constexpr std::size_t kFew = 24;
  constexpr int kMostHalvings = 40, kMostDepth = 4000;
  if (polygon.size() < 3 || isSliver(polygon)) return;
  std::vector<Segment> through;
  for (const Segment& segment : segments) {
    const Segment within = clipped(segment, polygon, kTouch);
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
    const Segment& chosen = through[through.size() / 2];
    on = chosen.from;
    along = (chosen.to - chosen.from) / (chosen.to - chosen.from).length();
  }
  const auto [first, second] = halves(polygon, on, along);
  cut(first, through, depth + 1, pieces);
  cut(second, through, depth + 1, pieces);
}

class Union {
 public:
  Union(const std::vector<Vec3d>& points, std::vector<Vec3I> triangles, Parts parts, Monitor& monitor)
      : mPoints(points),
        mTriangles(std::move(triangles)),
        mParts(std::move(parts)),
        mMonitor(monitor),
        mBoxes(points, mTriangles),
        mFate(mTriangles.size(), Fate::Whole),
        mBuries(mParts.closure.size()) {}

  void find() {
    mMonitor.begin({PhaseKind::Sides, "of parts"}, 2 * mTriangles.size());
    inParallel(mTriangles.size(), 64, mMonitor, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) cutTriangle(static_cast<std::uint32_t>(t));
      mMonitor.advance(end - begin);
    });
    decideWholeOnes();
  }

  bool buriesAnything() const {
    return std::any_of(mFate.begin(), mFate.end(), [](Fate fate) { return fate == Fate::Buried || fate == Fate::Cut; });
  }

  OuterSurface surface(const std::vector<Vec3d>& points, const std::vector<Vec3I>& triangles) {
    OuterSurface result{.points = points, .triangles = {}, .parts = 0};
    for (std::size_t t = 0; t < mFate.size(); ++t) {
      if (mFate[t] == Fate::Kept) result.triangles.push_back(triangles[t]);
      if (mFate[t] != Fate::Cut) continue;
      const Plane plane = planeOf(static_cast<std::uint32_t>(t));
      for (const Polygon& piece : mPieces.at(static_cast<std::uint32_t>(t))) {
        const auto first = static_cast<std::uint32_t>(result.points.size());
        for (const Vec2d& p : piece) result.points.push_back(plane.space(p));
        for (std::uint32_t k = 1; k + 1 < piece.size(); ++k)
          result.triangles.emplace_back(first, first + k, first + k + 1);
      }
    }
    for (const std::atomic<bool>& buries : mBuries) result.parts += buries ? 1 : 0;
    return result;
  }

 private:
  const Vec3d& corner(std::uint32_t triangle, int c) const { return mPoints[mTriangles[triangle][c]]; }
  Plane planeOf(std::uint32_t t) const { return {corner(t, 0), corner(t, 1), corner(t, 2)}; }

  /// The intersection of another triangle with the plane of a triangle: no segment, one, or three edges if it lies in
  /// the plane.
  void addSegments(const Plane& plane, const Vec3I& own, const Vec3I& other, std::vector<Segment>& segments) const {
    double heights[3];
    int above = 0, below = 0;
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t p = other[c];
      double& h = heights[c] = plane.height(mPoints[p]);
      if (std::abs(h) <= kTouch || p == own[0] || p == own[1] || p == own[2]) h = 0;
      above += h > 0;
      below += h < 0;
    }
    if (above == 3 || below == 3) return;
    if (above + below == 0) {
      for (int c = 0; c < 3; ++c)
        segments.push_back({plane.flat(mPoints[other[c]]), plane.flat(mPoints[other[(c + 1) % 3]])});
      return;
    }
    Vec2d found[3];
    int count = 0;
    for (int c = 0; c < 3; ++c) {
      const double a = heights[c], b = heights[(c + 1) % 3];
      const Vec3d& p = mPoints[other[c]];
      if (a == 0) found[count++] = plane.flat(p);
      if (a * b < 0) found[count++] = plane.flat(p + (mPoints[other[(c + 1) % 3]] - p) * (a / (a - b)));
    }
    if (count == 2) segments.push_back({found[0], found[1]});
  }

  /// Whether a segment of another triangle lies at a corner that both triangles have. Where they meet in one point
  /// alone, the outside does not end.
  static bool isAtSharedCorner(const Segment& segment, const Vec3I& own, const Vec3I& other, const Polygon& polygon) {
    constexpr double kAt = 4 * kTouch;
    for (int c = 0; c < 3; ++c) {
      if (own[c] != other[0] && own[c] != other[1] && own[c] != other[2]) continue;
      const Vec2d& corner = polygon[static_cast<std::size_t>(c)];
      if ((segment.from - corner).length() <= kAt && (segment.to - corner).length() <= kAt) return true;
    }
    return false;
  }

  void cutTriangle(std::uint32_t t) {
    const Vec3I& own = mTriangles[t];
    const Vec3d &a = corner(t, 0), &b = corner(t, 1), &c = corner(t, 2);
    const double longest = std::sqrt(std::max({(b - a).lengthSqr(), (c - b).lengthSqr(), (a - c).lengthSqr()}));
    if (mParts.of[t] == kNone || !((b - a).cross(c - a).length() > kTouch * longest)) {
      mFate[t] = Fate::Sliver;
      return;
    }
    const Plane plane(a, b, c);
    BBoxd box(a, a);
    box.expand(b);
    box.expand(c);
    box.expand(kTouch);
    std::vector<std::uint32_t> others;
    mBoxes.meeting(box, [&](std::uint32_t other) {
      if (other != t && mParts.of[other] != kNone) others.push_back(other);
    });
    std::sort(others.begin(), others.end());
    const Polygon polygon = {plane.flat(a), plane.flat(b), plane.flat(c)};
    std::vector<Segment> segments;
    bool touched = false, crossed = false;
    for (const std::uint32_t other : others) {
      const Vec3I& corners = mTriangles[other];
      // Neighbours across an edge meet there and nowhere else.
      const std::uint32_t* const partners = &mParts.partner[3 * std::size_t{t}];
      if (std::find(partners, partners + 3, other) != partners + 3) continue;
      const std::size_t first = segments.size();
      addSegments(plane, own, corners, segments);
      for (std::size_t k = first; k < segments.size(); ++k) {
        const Segment along = clipped(segments[k], polygon, -kTouch);
        touched |= isLong(along) && !isAtSharedCorner(along, own, corners, polygon);
        crossed |= isLong(clipped(segments[k], polygon, kTouch));
      }
    }
    if (!touched && !crossed) return;
    mFate[t] = Fate::Touched;
    if (!crossed) return;
    std::vector<Polygon> pieces, kept;
    cut(polygon, segments, 0, pieces);
    for (Polygon& piece : pieces) {
      Vec2d middle(0, 0);
      for (const Vec2d& p : piece) middle += p;
      if (hasOutside(t, plane.normal(), plane.space(middle / static_cast<double>(piece.size()))))
        kept.push_back(std::move(piece));
    }
    mFate[t] = kept.size() == pieces.size() ? Fate::Kept : kept.empty() ? Fate::Buried : Fate::Cut;
    if (mFate[t] == Fate::Cut) mPieces.emplace(t, std::move(kept));
  }

  /// Triangles that nothing cuts or touches have the fate of their neighbours: three triangles of each patch are
  /// tested, so that a single rounding error does not decide over all of it.
  void decideWholeOnes() {
    const auto count = static_cast<std::uint32_t>(mTriangles.size());
    DisjointSets<std::uint32_t> patches(count);
    for (std::uint32_t t = 0; t < count; ++t)
      for (int c = 0; c < 3 && mFate[t] == Fate::Whole; ++c) {
        const std::uint32_t other = mParts.partner[3 * t + static_cast<std::uint32_t>(c)];
        if (other != kNone && mFate[other] == Fate::Whole) patches.join(t, other);
      }
    // The triangles of each patch stand together in members; those of the patch that i represents end at ends[i].
    std::vector<std::uint32_t> members, ends(count + 1, 0);
    for (std::uint32_t t = 0; t < count; ++t)
      if (mFate[t] == Fate::Whole) ++ends[patches.find(t) + 1];
    std::partial_sum(ends.begin(), ends.end(), ends.begin());
    members.resize(ends.back());
    ends.pop_back();
    for (std::uint32_t t = 0; t < count; ++t)
      if (mFate[t] == Fate::Whole) members[ends[patches.find(t)]++] = t;
    const auto ask = [this](std::uint32_t t) {
      const Plane plane = planeOf(t);
      return hasOutside(t, plane.normal(), (corner(t, 0) + corner(t, 1) + corner(t, 2)) / 3.0) ? Fate::Kept
                                                                                               : Fate::Buried;
    };
    inParallel(count, 64, mMonitor, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const auto t = static_cast<std::uint32_t>(i);
        if (mFate[t] == Fate::Touched) mFate[t] = ask(t);
        const std::size_t first = i == 0 ? 0 : ends[i - 1];
        const std::span patch = std::span(members).subspan(first, ends[i] - first);
        if (patch.empty()) continue;
        const Fate fate = ask(patch.front());
        const bool agree = ask(patch[patch.size() / 2]) == fate && ask(patch.back()) == fate;
        for (const std::uint32_t member : patch) mFate[member] = agree ? fate : ask(member);
      }
      mMonitor.advance(end - begin);
    });
  }

  /// How a ray from a point of a triangle leaves a part: the crossings beyond the point, and those at it.
  struct Passed {
    std::uint32_t part = 0;
    int beyond = 0, here = 0;            ///< winding
    int timesBeyond = 0, timesHere = 0;  ///< parity
  };

  /// Whether there is an outside on one of the sides of a triangle at a point of it.
  bool hasOutside(std::uint32_t t, const Vec3d& normal, const Vec3d& point) {
    // Directions of no lattice, because meshes made by programs often have edges along lattice directions.
    static const Vec3d kDirections[] = {{1, 0.37139, 0.21131},   {0.23417, 1, 0.35813},  {0.36121, 0.19777, 1},
                                        {1, -0.33971, 0.24359},  {-0.21713, 1, 0.34651}, {0.37957, -0.22369, 1},
                                        {1, -0.61871, -0.58237}, {0.57193, 1, -0.63127}, {-0.59771, 0.60913, 1},
                                        {1, 0.63533, 0.56431}};
    std::array<std::pair<double, const Vec3d*>, std::size(kDirections)> order;
    for (std::size_t i = 0; i < order.size(); ++i)
      order[i] = {-std::abs(normal.dot(kDirections[i])) / kDirections[i].length(), &kDirections[i]};
    std::sort(order.begin(), order.end());
    std::vector<Passed> passed[3];
    const bool first = seesOutside(t, point, *order[0].second, passed[0]),
               second = seesOutside(t, point, *order[1].second, passed[1]);
    const bool outside = first == second ? first : seesOutside(t, point, *order[2].second, passed[2]);
    if (!outside) {
      mBuries[mParts.of[t]] = true;
      for (const Passed& p : passed[0])
        if (isWithin(p.part, p.beyond, p.timesBeyond) ||
            isWithin(p.part, p.beyond + p.here, p.timesBeyond + p.timesHere))
          mBuries[p.part] = true;
    }
    return outside;
  }

  bool isWithin(std::uint32_t part, int winding, int times) const {
    switch (mParts.closure[part]) {
      case Closure::Winding: return winding != 0;
      case Closure::Parity: return times % 2 != 0;
      case Closure::Open: break;
    }
    return false;
  }

  bool seesOutside(std::uint32_t t, const Vec3d& point, const Vec3d& direction, std::vector<Passed>& passed) const {
    constexpr double kSlack = 1e-3;
    const int k = std::abs(direction[0]) == 1   ? 0
                  : std::abs(direction[1]) == 1 ? 1
                                                : 2,
              i = (k + 1) % 3, j = (k + 2) % 3;
    mBoxes.along(point, direction, kSlack, [&](std::uint32_t other) {
      const std::uint32_t part = mParts.of[other];
      if (part == kNone || mParts.closure[part] == Closure::Open) return;
      // Projected along the ray. An edge has the same bits in each of its triangles, so the ray passes on one side of
      // it consistently.
      const Vec3I& corners = mTriangles[other];
      Vec3d at[3];
      for (int c = 0; c < 3; ++c) {
        const Vec3d way = mPoints[corners[c]] - point;
        at[c] = {way[i] - way[k] * direction[i], way[j] - way[k] * direction[j], way[k]};
      }
      double weights[3];
      int left = 0;
      for (int c = 0; c < 3; ++c) {
        int a = c, b = (c + 1) % 3;
        const bool turned = corners[a] > corners[b];
        if (turned) std::swap(a, b);
        const double area = at[a][0] * at[b][1] - at[a][1] * at[b][0];
        left += (area >= 0) != turned;
        weights[(c + 2) % 3] = turned ? -area : area;
      }
      if (other != t && left != 0 && left != 3) return;
      const double sum = weights[0] + weights[1] + weights[2];
      bool here = other == t;
      if (!here) {
        if (sum == 0) return;
        const double along = (weights[0] * at[0][2] + weights[1] * at[1][2] + weights[2] * at[2][2]) / sum;
        if (along < -kSlack) return;
        Vec3d upright = (mPoints[corners[1]] - mPoints[corners[0]]).cross(mPoints[corners[2]] - mPoints[corners[0]]);
        upright.normalize();
        here = std::abs(along) < kSlack && std::abs(upright.dot(point - mPoints[corners[0]])) <= 2 * kTouch;
        if (!here && along < 0) return;
      }
      auto found = std::find_if(passed.begin(), passed.end(), [part](const Passed& p) { return p.part == part; });
      if (found == passed.end()) found = passed.insert(passed.end(), {.part = part});
      const int turn = sum > 0 ? 1 : -1;
      (here ? found->here : found->beyond) += turn;
      ++(here ? found->timesHere : found->timesBeyond);
    });
    bool beyond = true, before = true;
    for (const Passed& p : passed) {
      beyond &= !isWithin(p.part, p.beyond, p.timesBeyond);
      before &= !isWithin(p.part, p.beyond + p.here, p.timesBeyond + p.timesHere);
    }
    return beyond || before;
  }

  const std::vector<Vec3d>& mPoints;
  const std::vector<Vec3I> mTriangles;
  const Parts mParts;
  Monitor& mMonitor;
  const TriangleBoxes mBoxes;
  std::vector<Fate> mFate;
  tbb::concurrent_unordered_map<std::uint32_t, std::vector<Polygon>> mPieces;  ///< of triangles with Fate::Cut
  std::vector<std::atomic<bool>> mBuries;  ///< parts that lie in others or have others in them
};

}  // namespace

std::optional<OuterSurface> outerSurface(const std::vector<Vec3d>& points, const std::vector<Vec3I>& triangles,
                                         bool within, Monitor& monitor) {
  std::vector<Vec3d> places;
  std::vector<Vec3I> welded(triangles.size());
  {
    PositionTable table(places, points.size());
    std::vector<std::uint32_t> numbers(points.size());
    for (std::size_t p = 0; p < points.size(); ++p) numbers[p] = table.numberOf(points[p]);
    for (std::size_t t = 0; t < triangles.size(); ++t)
      for (int c = 0; c < 3; ++c) welded[t][c] = numbers[triangles[t][c]];
  }
  monitor.throwIfCancelled();
  Parts parts = findParts(places, welded);
  const bool closed =
      std::any_of(parts.closure.begin(), parts.closure.end(), [](Closure closure) { return closure != Closure::Open; });
  if (!closed || (!within && !mayMeet(parts))) return std::nullopt;
  Union all(places, std::move(welded), std::move(parts), monitor);
  all.find();
  if (!all.buriesAnything()) return std::nullopt;
  return all.surface(points, triangles);
}

}  // namespace vdbtools
