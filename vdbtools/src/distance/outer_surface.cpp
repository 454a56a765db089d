// SPDX-License-Identifier: Apache-2.0
/// The algorithm has three steps. It finds the parts; it cuts each triangle along the segments in which others meet it,
/// so that every piece lies entirely inside or entirely outside a part; and it tests at one point of each piece, or of
/// each patch of uncut triangles, on which of its two sides there is an outside. Pieces need not fit together, because
/// only distances to them are needed. Therefore nothing here depends on exact arithmetic: a rounding error makes a gap
/// of its own size. Parts that no other one meets may lie inside others; rays from them tell what they bound.
#include "distance/outer_surface.h"

#include "base/disjoint_sets.h"
#include "base/in_parallel.h"
#include "distance/connected_parts.h"
#include "distance/triangle_cut.h"

#include <tbb/concurrent_unordered_map.h>

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

constexpr std::uint32_t kNone = ConnectedParts::kNone;

/// Whether a triangle has an outside next to it.
enum class Fate : std::uint8_t { Kept, Buried, Sliver, Cut, Touched, Whole };

class Union {
 public:
  Union(const WeldedMesh& mesh, ConnectedParts parts, Monitor& monitor)
      : mWelded(mesh),
        mMesh(mesh.tree()),
        mPoints(mesh.points()),
        mTriangles(mesh.triangles()),
        mParts(std::move(parts)),
        mMonitor(monitor),
        mBuries(mParts.closure.size()),
        mBuriesItself(mParts.closure.size()),
        mMeets(mParts.closure.size()),
        mSurfaces(mParts.closure.size()) {}

  /// Whether one of some places lies within a part.
  bool hidesOne(std::span<const HiddenPlace> places) const {
    std::atomic<bool> hides = false;
    inParallel(places.size(), 16, mMonitor, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end && !hides; ++i)
        if (hidesPlace(places[i])) hides = true;
    });
    return hides;
  }

  void find() {
    mMonitor.begin({PhaseKind::Sides, "of parts"}, 2 * mTriangles.size());
    mFate.assign(mTriangles.size(), Fate::Whole);
    mPartner.assign(3 * mTriangles.size(), kNone);
    forEachEdge(mWelded, mMonitor, [this](std::span<const EdgeUse> uses) {
      if (uses.size() != 2) return;
      mPartner[uses[0].side] = uses[1].triangle();
      mPartner[uses[1].side] = uses[0].triangle();
    });
    inParallel(mTriangles.size(), 64, mMonitor, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) cutTriangle(static_cast<std::uint32_t>(t));
      mMonitor.advance(end - begin);
    });
    decideWholeOnes();
  }

  bool buriesAnything() const {
    return std::any_of(mFate.begin(), mFate.end(), [](Fate fate) { return fate == Fate::Buried || fate == Fate::Cut; });
  }

  OuterSurface surface() {
    OuterSurface result{.points = mMesh.points(), .triangles = {}, .source = {}, .parts = nesting().counts};
    for (std::uint32_t t = 0; t < mFate.size(); ++t) {
      if (mFate[t] == Fate::Kept) result.triangles.push_back(mMesh.triangles()[t]);
      if (mFate[t] == Fate::Cut) {
        const TrianglePlane plane = planeOf(t);
        for (const ConvexPolygon& piece : mPieces.at(t)) {
          const auto first = static_cast<std::uint32_t>(result.points.size());
          for (const Vec2d& p : piece) result.points.push_back(plane.space(p));
          for (std::uint32_t k = 1; k + 1 < piece.size(); ++k)
            result.triangles.emplace_back(first, first + k, first + k + 1);
        }
      }
      result.source.resize(result.triangles.size(), t);
    }
    return result;
  }

  NestedSurfaces layers() {
    const Nesting nests = nesting();
    NestedSurfaces result{.layers = {}, .parts = nests.counts};
    result.layers.resize(1 + *std::max_element(nests.layer.begin(), nests.layer.end()));
    for (std::size_t t = 0; t < mTriangles.size(); ++t) {
      const std::uint32_t part = mParts.of[t];
      result.layers[part == kNone ? 0 : nests.layer[part]].push_back(mMesh.triangles()[t]);
    }
    return result;
  }

 private:
  const Vec3d& corner(std::uint32_t triangle, int c) const { return mPoints[mTriangles[triangle][c]]; }
  TrianglePlane planeOf(std::uint32_t t) const { return {corner(t, 0), corner(t, 1), corner(t, 2)}; }
  Vec3d middleOf(std::uint32_t t) const { return (corner(t, 0) + corner(t, 1) + corner(t, 2)) / 3.0; }

  BBoxd boxOf(std::uint32_t t) const {
    BBoxd box(corner(t, 0), corner(t, 0));
    box.expand(corner(t, 1));
    box.expand(corner(t, 2));
    return box;
  }

  bool isSliver(std::uint32_t t) const {
    const Vec3d &a = corner(t, 0), &b = corner(t, 1), &c = corner(t, 2);
    const double longest = std::sqrt(std::max({(b - a).lengthSqr(), (c - b).lengthSqr(), (a - c).lengthSqr()}));
    return mParts.of[t] == kNone || !((b - a).cross(c - a).length() > kTouch * longest);
  }

  bool hidesPlace(const HiddenPlace& place) const {
    // Beside the edges, where a ray would meet the neighbour, too.
    constexpr double kInwards = 0.1;
    if (isSliver(place.triangle)) return true;
    const Vec3d way = middleOf(place.triangle) - place.point;
    const Vec3d point = place.point + way * std::min(kInwards, kInwards / (way.length() + 1e-30));
    std::vector<Passed> passed;
    return !hasOutside(place.triangle, planeOf(place.triangle).normal(), point, passed);
  }

  /// The intersection of another triangle with the plane of a triangle: no segment, one, or three edges if it lies in
  /// the plane.
  void addSegments(const TrianglePlane& plane, const Vec3I& own, const Vec3I& other,
                   std::vector<PlaneSegment>& segments) const {
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
  static bool isAtSharedCorner(const PlaneSegment& segment, const Vec3I& own, const Vec3I& other,
                               const ConvexPolygon& polygon) {
    constexpr double kAt = 4 * kTouch;
    for (int c = 0; c < 3; ++c) {
      if (own[c] != other[0] && own[c] != other[1] && own[c] != other[2]) continue;
      const Vec2d& corner = polygon[static_cast<std::size_t>(c)];
      if ((segment.from - corner).length() <= kAt && (segment.to - corner).length() <= kAt) return true;
    }
    return false;
  }

  void noteMeeting(std::uint32_t part, std::uint32_t other) {
    if (part == other) return;
    // Stores that change nothing would make the threads wait for each other.
    for (const std::uint32_t p : {part, other})
      if (!mMeets[p]) mMeets[p] = true;
    if (mParts.closure[part] != Closure::Open && mParts.closure[other] != Closure::Open) mSurfaces.join(part, other);
  }

  void cutTriangle(std::uint32_t t) {
    const Vec3I& own = mTriangles[t];
    const Vec3d &a = corner(t, 0), &b = corner(t, 1), &c = corner(t, 2);
    if (isSliver(t)) {
      mFate[t] = Fate::Sliver;
      return;
    }
    const TrianglePlane plane(a, b, c);
    BBoxd box = boxOf(t);
    box.expand(kTouch);
    std::vector<std::uint32_t> others;
    mMesh.meeting(box, [&](std::uint32_t other) {
      if (other != t && mParts.of[other] != kNone && boxOf(other).hasOverlap(box)) others.push_back(other);
    });
    std::sort(others.begin(), others.end());
    const ConvexPolygon polygon = {plane.flat(a), plane.flat(b), plane.flat(c)};
    std::vector<PlaneSegment> segments;
    bool touched = false, crossed = false;
    for (const std::uint32_t other : others) {
      const Vec3I& corners = mTriangles[other];
      // Neighbours across an edge meet there and nowhere else.
      const std::uint32_t* const partners = &mPartner[3 * std::size_t{t}];
      if (std::find(partners, partners + 3, other) != partners + 3) continue;
      const std::size_t first = segments.size();
      addSegments(plane, own, corners, segments);
      bool meets = false;
      for (std::size_t k = first; k < segments.size(); ++k) {
        const PlaneSegment along = clipped(segments[k], polygon, -kTouch);
        const bool touches = isLong(along) && !isAtSharedCorner(along, own, corners, polygon),
                   crosses = isLong(clipped(segments[k], polygon, kTouch));
        touched |= touches;
        crossed |= crosses;
        meets |= touches || crosses;
      }
      if (meets) noteMeeting(mParts.of[t], mParts.of[other]);
    }
    if (!touched && !crossed) return;
    mFate[t] = Fate::Touched;
    if (!crossed) return;
    std::vector<ConvexPolygon> pieces = piecesOf(polygon, segments), kept;
    for (ConvexPolygon& piece : pieces) {
      Vec2d middle(0, 0);
      for (const Vec2d& p : piece) middle += p;
      if (keeps(t, plane.normal(), plane.space(middle / static_cast<double>(piece.size()))))
        kept.push_back(std::move(piece));
    }
    mFate[t] = kept.size() == pieces.size() ? Fate::Kept : kept.empty() ? Fate::Buried : Fate::Cut;
    if (mFate[t] == Fate::Cut) mPieces.emplace(t, std::move(kept));
  }

  /// Triangles that nothing cuts or touches have the fate of their neighbours: three triangles of each patch are
  /// tested, so that a single rounding error does not decide over all of it. One that is touched is a patch of its own.
  void decideWholeOnes() {
    const auto count = static_cast<std::uint32_t>(mTriangles.size());
    DisjointSets<std::uint32_t> patches(count);
    for (std::uint32_t t = 0; t < count; ++t)
      for (int c = 0; c < 3 && mFate[t] == Fate::Whole; ++c) {
        const std::uint32_t other = mPartner[3 * t + static_cast<std::uint32_t>(c)];
        if (other != kNone && mFate[other] == Fate::Whole) patches.join(t, other);
      }
    // In members, the triangles of a patch follow each other; the patch that i represents ends at ends[i]. No thread
    // reads the fate of a triangle of another patch.
    std::vector<std::uint32_t> members, ends(count + 1, 0);
    const auto isUndecided = [this](std::uint32_t t) { return mFate[t] == Fate::Whole || mFate[t] == Fate::Touched; };
    for (std::uint32_t t = 0; t < count; ++t)
      if (isUndecided(t)) ++ends[patches.find(t) + 1];
    std::partial_sum(ends.begin(), ends.end(), ends.begin());
    members.resize(ends.back());
    ends.pop_back();
    for (std::uint32_t t = 0; t < count; ++t)
      if (isUndecided(t)) members[ends[patches.find(t)]++] = t;
    const auto ask = [this](std::uint32_t t) {
      const TrianglePlane plane = planeOf(t);
      return keeps(t, plane.normal(), middleOf(t)) ? Fate::Kept : Fate::Buried;
    };
    inParallel(count, 64, mMonitor, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::size_t first = i == 0 ? 0 : ends[i - 1];
        const std::span patch = std::span(members).subspan(first, ends[i] - first);
        if (patch.empty()) continue;
        const Fate fate = ask(patch.front());
        const bool agree = patch.size() == 1 || (ask(patch[patch.size() / 2]) == fate && ask(patch.back()) == fate);
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

  /// Ten directions, those along which a ray leaves a plane most steeply first.
  static auto directionsFrom(const Vec3d& normal) {
    // Directions of no lattice, because meshes made by programs often have edges along lattice directions.
    static const Vec3d kDirections[] = {{1, 0.37139, 0.21131},   {0.23417, 1, 0.35813},  {0.36121, 0.19777, 1},
                                        {1, -0.33971, 0.24359},  {-0.21713, 1, 0.34651}, {0.37957, -0.22369, 1},
                                        {1, -0.61871, -0.58237}, {0.57193, 1, -0.63127}, {-0.59771, 0.60913, 1},
                                        {1, 0.63533, 0.56431}};
    std::array<std::pair<double, const Vec3d*>, std::size(kDirections)> order;
    for (std::size_t i = 0; i < order.size(); ++i)
      order[i] = {-std::abs(normal.dot(kDirections[i])) / kDirections[i].length(), &kDirections[i]};
    std::sort(order.begin(), order.end());
    return order;
  }

  /// Whether there is an outside on one of the sides of a triangle at a point of it.
  /// @param first  how a ray leaves the parts
  bool hasOutside(std::uint32_t t, const Vec3d& normal, const Vec3d& point, std::vector<Passed>& first) const {
    const auto order = directionsFrom(normal);
    std::vector<Passed> second, third;
    const bool sees = seesOutside(t, point, *order[0].second, first);
    return sees == seesOutside(t, point, *order[1].second, second) ? sees
                                                                   : seesOutside(t, point, *order[2].second, third);
  }

  /// The same, noting the parts that hide others and those that are hidden.
  bool keeps(std::uint32_t t, const Vec3d& normal, const Vec3d& point) {
    std::vector<Passed> passed;
    if (hasOutside(t, normal, point, passed)) return true;
    mBuries[mParts.of[t]] = true;
    for (const Passed& p : passed) {
      const bool beyond = isWithinBeyond(p), before = isWithinBefore(p);
      if (beyond || before) mBuries[p.part] = true;
      if (beyond && before && p.part == mParts.of[t]) mBuriesItself[p.part] = true;
    }
    return false;
  }

  bool isWithinBeyond(const Passed& p) const { return isWithin(p.part, p.beyond, p.timesBeyond); }
  bool isWithinBefore(const Passed& p) const {
    return isWithin(p.part, p.beyond + p.here, p.timesBeyond + p.timesHere);
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
    mMesh.along(point, direction, kSlack, [&](std::uint32_t other) {
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
      beyond &= !isWithinBeyond(p);
      before &= !isWithinBefore(p);
    }
    return beyond || before;
  }

  /// Where a part lies.
  struct Surroundings {
    int own = 0;                          ///< the winding number of the part, just inside of it, if it has one
    int others = 0;                       ///< the sum of the winding numbers of other surfaces
    std::vector<std::uint32_t> surfaces;  ///< those that enclose the part
    bool areOriented = true;              ///< whether these have winding numbers
    bool operator==(const Surroundings&) const = default;
  };

  bool isOriented(std::uint32_t part) const { return mParts.closure[part] == Closure::Winding; }

  /// The surroundings of a part as a ray from one of its triangles sees them.
  /// @return empty if the triangle lies within its own surface
  std::optional<Surroundings> seenFrom(std::uint32_t t, const Vec3d& direction) {
    std::vector<Passed> passed;
    seesOutside(t, middleOf(t), direction, passed);
    const std::uint32_t part = mParts.of[t], surface = mSurfaces.find(part);
    Surroundings result;
    for (const Passed& p : passed) {
      const bool beyond = isWithinBeyond(p), before = isWithinBefore(p);
      if (p.part == part) {
        if (beyond == before) return std::nullopt;
        if (isOriented(part)) result.own = beyond ? p.beyond : p.beyond + p.here;
      } else if (beyond != before || (beyond && mSurfaces.find(p.part) == surface)) {
        return std::nullopt;
      } else if (beyond) {
        if (isOriented(p.part)) result.others += p.beyond;
        result.surfaces.push_back(mSurfaces.find(p.part));
        result.areOriented &= isOriented(p.part);
      }
    }
    std::sort(result.surfaces.begin(), result.surfaces.end());
    result.surfaces.erase(std::unique(result.surfaces.begin(), result.surfaces.end()), result.surfaces.end());
    return result;
  }

  /// @param triangles  the triangles of a part; only the largest ones are examined
  /// @return empty if they lie within other parts of the surface, so that these decide
  std::optional<Surroundings> surroundings(const std::vector<std::uint32_t>& triangles) {
    constexpr std::size_t kMostAsked = 256;
    const auto area = [this](std::uint32_t t) {
      return (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).lengthSqr();
    };
    std::vector<std::pair<double, std::uint32_t>> order;
    for (const std::uint32_t t : triangles)
      if (!isSliver(t)) order.emplace_back(-area(t), t);
    const auto asked = order.begin() + static_cast<std::ptrdiff_t>(std::min(order.size(), kMostAsked));
    std::partial_sort(order.begin(), asked, order.end());
    order.erase(asked, order.end());
    for (const auto& [size, t] : order) {
      const auto directions = directionsFrom(planeOf(t).normal());
      std::optional<Surroundings> seen = seenFrom(t, *directions[0].second);
      if (seen && seen == seenFrom(t, *directions[1].second)) return seen;
    }
    return std::nullopt;
  }

  struct Nesting {
    std::vector<std::uint32_t> layer;  ///< of each part, as in NestedSurfaces
    PartCounts counts;
  };

  Nesting nesting() {
    const std::size_t count = mParts.closure.size();
    // A surface that has any triangle left lies within no other one.
    std::vector<char> isOuter(count, 0);
    for (std::uint32_t t = 0; t < mTriangles.size(); ++t)
      if (mFate[t] == Fate::Kept || mFate[t] == Fate::Cut) isOuter[mSurfaces.find(mParts.of[t])] = 1;
    std::vector<std::vector<std::uint32_t>> triangles(count);
    for (std::uint32_t t = 0; t < mTriangles.size(); ++t) {
      const std::uint32_t part = mParts.of[t];
      if (part != kNone && mParts.closure[part] != Closure::Open && !isOuter[mSurfaces.find(part)])
        triangles[part].push_back(t);
    }
    std::vector<std::optional<Surroundings>> around(count);
    inParallel(count, 1, mMonitor, [&](std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) around[p] = surroundings(triangles[p]);
    });
    // The surfaces have the numbers of their first parts.
    enum class Kind : std::uint8_t { Solid, Hollow, Neither };
    struct Surface {
      const Surroundings* around = nullptr;
      bool endsInside = true;  ///< whether the winding number is 0 just inside of each part
      Kind kind = Kind::Solid;
    };
    std::vector<Surface> surfaces(count);
    for (std::uint32_t p = 0; p < count; ++p) {
      Surface& surface = surfaces[mSurfaces.find(p)];
      if (!around[p]) continue;
      if (!surface.around) surface.around = &*around[p];
      surface.endsInside &= isOriented(p) && around[p]->areOriented && around[p]->others + around[p]->own == 0;
    }
    for (Surface& surface : surfaces)
      if (surface.around && !surface.around->surfaces.empty()) {
        const bool isInSolid = surface.around->others != 0 || !surface.around->areOriented;
        surface.kind = !isInSolid ? Kind::Solid : surface.endsInside ? Kind::Hollow : Kind::Neither;
      }
    Nesting result;
    result.layer.assign(count, 0);
    for (std::uint32_t s = 0; s < count; ++s) {
      const Surface& surface = surfaces[s];
      if (surface.kind == Kind::Neither) ++result.counts.inner;
      if (surface.kind == Kind::Neither || !surface.around) continue;
      const std::vector<std::uint32_t>& enclosing = surface.around->surfaces;
      const auto depth = std::count_if(enclosing.begin(), enclosing.end(),
                                       [&](std::uint32_t other) { return surfaces[other].kind != Kind::Neither; });
      // Where surfaces cross, a winding number may say otherwise; such a surface bounds nothing.
      if ((depth % 2 == 1) != (surface.kind == Kind::Hollow)) continue;
      result.layer[s] = static_cast<std::uint32_t>(depth);
      if (surface.kind == Kind::Hollow) ++result.counts.hollows;
    }
    for (std::uint32_t p = 0; p < count; ++p) {
      const std::uint32_t s = mSurfaces.find(p);
      result.layer[p] = result.layer[s];
      if (mBuriesItself[p] || (mBuries[p] && mMeets[p]))
        ++result.counts.intersecting;
      else if (mBuries[p] && mParts.closure[p] == Closure::Open)
        ++result.counts.inner;
    }
    return result;
  }

  const WeldedMesh& mWelded;
  const TriangleTree& mMesh;
  const std::vector<Vec3d>& mPoints;     ///< welded
  const std::vector<Vec3I>& mTriangles;  ///< welded
  const ConnectedParts mParts;
  Monitor& mMonitor;
  std::vector<Fate> mFate;
  std::vector<std::uint32_t> mPartner;  ///< three per triangle: the triangle beyond each edge, if there is exactly one
  tbb::concurrent_unordered_map<std::uint32_t, std::vector<ConvexPolygon>> mPieces;  ///< of triangles with Fate::Cut
  std::vector<std::atomic<bool>> mBuries;                ///< parts that lie in others or have others in them
  std::vector<std::atomic<bool>> mBuriesItself, mMeets;  ///< mMeets: parts that intersect or touch others
  DisjointSets<std::uint32_t> mSurfaces;                 ///< closed parts that intersect or touch each other
};

}  // namespace

std::optional<OuterSurface> outerSurface(const TriangleTree& mesh, std::span<const HiddenPlace> hidden,
                                         Monitor& monitor) {
  // To examine all triangles then costs less than to ask about each place.
  const bool many = hidden.size() > mesh.triangles().size() / 4;
  const WeldedMesh welded(mesh);
  monitor.throwIfCancelled();
  ConnectedParts parts = findParts(welded, monitor);
  if (std::all_of(parts.closure.begin(), parts.closure.end(), [](Closure c) { return c == Closure::Open; }))
    return std::nullopt;
  const bool meet = parts.closedOneBranches || mayMeet(parts);
  Union all(welded, std::move(parts), monitor);
  if (!meet && (hidden.empty() || (!many && !all.hidesOne(hidden)))) return std::nullopt;
  all.find();
  if (!all.buriesAnything()) return std::nullopt;
  return all.surface();
}

std::optional<NestedSurfaces> nestedSurfaces(const TriangleTree& mesh, Monitor& monitor) {
  const WeldedMesh welded(mesh);
  monitor.throwIfCancelled();
  ConnectedParts parts = findParts(welded, monitor);
  if (!mayMeet(parts)) return std::nullopt;
  Union all(welded, std::move(parts), monitor);
  all.find();
  NestedSurfaces result = all.layers();
  if (result.parts.hollows == 0) return std::nullopt;
  return result;
}

}  // namespace vdbtools
