// SPDX-License-Identifier: Apache-2.0
#include "distance/hole_caps.h"

#include "base/disjoint_sets.h"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>

namespace vdbtools {
namespace {

using openvdb::Vec3d;
using openvdb::Vec3I;

/// The triangulation takes time cubic in the number of points: about 5 million areas for this many.
constexpr std::size_t kMostSpannedAtOnce = 300;

/// A part is a sheet if the cap that spans one of its loops has more than this fraction of the part's own area: 1/2 for
/// a hemisphere, 1 for a plane.
constexpr double kSheet = 0.75;

/// Two loops are sides of one gap if the distance between them is shorter than this fraction of the loop's extent.
constexpr double kNearby = 0.125;

double areaOf(const Vec3d& a, const Vec3d& b, const Vec3d& c) { return (b - a).cross(c - a).length() / 2; }

/// @pre at most kMostSpannedAtOnce points
void spanPolygon(std::span<const std::uint32_t> ring, const std::vector<Vec3d>& points, std::vector<Vec3I>& triangles) {
  const std::size_t n = ring.size();
  // least[i * n + j]: the smallest area that spans the points from i to j; best: the third point of its triangle.
  std::vector<double> least(n * n, 0);
  std::vector<std::uint16_t> best(n * n, 0);
  // All triangulations of a flat polygon have the same area; the first is taken, regardless of rounding.
  constexpr double kBetter = 1 - 1e-9;
  for (std::size_t length = 2; length < n; ++length)
    for (std::size_t i = 0; i + length < n; ++i) {
      const std::size_t j = i + length;
      double smallest = std::numeric_limits<double>::infinity();
      for (std::size_t k = i + 1; k < j; ++k) {
        const double inner = least[i * n + k] + least[k * n + j];
        if (!(inner < smallest * kBetter)) continue;
        const double area = inner + areaOf(points[ring[i]], points[ring[k]], points[ring[j]]);
        if (area < smallest * kBetter) {
          smallest = area;
          best[i * n + j] = static_cast<std::uint16_t>(k);
        }
      }
      least[i * n + j] = smallest;
    }
  std::vector<std::pair<std::size_t, std::size_t>> ways{{0, n - 1}};
  while (!ways.empty()) {
    const auto [i, j] = ways.back();
    ways.pop_back();
    if (j - i < 2) continue;
    const std::size_t k = best[i * n + j];
    triangles.emplace_back(ring[i], ring[k], ring[j]);
    ways.emplace_back(i, k);
    ways.emplace_back(k, j);
  }
}

void spanRing(std::span<const std::uint32_t> ring, const std::vector<Vec3d>& points, std::vector<Vec3I>& triangles) {
  const std::size_t n = ring.size();
  if (n < 3) return;
  if (n <= kMostSpannedAtOnce) return spanPolygon(ring, points, triangles);
  std::vector<std::uint32_t> coarse, way;
  for (std::size_t k = 0; k < kMostSpannedAtOnce; ++k) {
    const std::size_t begin = k * n / kMostSpannedAtOnce, end = (k + 1) * n / kMostSpannedAtOnce;
    coarse.push_back(ring[begin]);
    way.assign(ring.begin() + static_cast<std::ptrdiff_t>(begin), ring.begin() + static_cast<std::ptrdiff_t>(end));
    way.push_back(ring[end % n]);
    spanRing(way, points, triangles);
  }
  spanPolygon(coarse, points, triangles);
}

double extentOf(const BoundaryLoop& loop, const std::vector<Vec3d>& points) {
  openvdb::BBoxd box;
  for (const std::uint32_t p : loop) box.expand(points[p]);
  const Vec3d sides = box.extents();
  return std::max({sides[0], sides[1], sides[2]});
}

/// Whether the greater part of a loop has another loop nearby.
bool isSideOfGap(const BoundaryLoop& loop, std::size_t self, const std::vector<Vec3d>& points,
                 const std::vector<std::uint32_t>& openPoints, const std::vector<std::uint32_t>& loopOf) {
  constexpr std::size_t kMostLooked = 64;
  const double nearby = kNearby * extentOf(loop, points);
  openvdb::BBoxd box;
  for (const std::uint32_t p : loop) box.expand(points[p]);
  box.expand(nearby);
  std::vector<std::uint32_t> others;
  for (const std::uint32_t p : openPoints)
    if (loopOf[p] != self && box.isInside(points[p])) others.push_back(p);
  if (others.empty()) return false;
  const std::size_t looked = std::min(kMostLooked, loop.size());
  std::size_t near = 0;
  for (std::size_t i = 0; i < looked; ++i) {
    const Vec3d& at = points[loop[i * loop.size() / looked]];
    near += std::any_of(others.begin(), others.end(),
                        [&](std::uint32_t p) { return (points[p] - at).lengthSqr() <= nearby * nearby; });
  }
  return 2 * near > looked;
}

/// A mesh, its parts and its loops.
struct Outline {
  explicit Outline(const Mesh& welded) : loops(boundaryLoops(welded)), parts(welded.points.size()) {
    for (const Vec3I& t : welded.triangles) {
      parts.join(t[0], t[1]);
      parts.join(t[1], t[2]);
    }
    for (const BoundaryLoop& loop : loops) {
      std::vector<Vec3I>& cap = caps.emplace_back();
      spanLoop(loop, welded.points, cap);
    }
    std::map<std::uint32_t, double> areas;
    for (const Vec3I& t : welded.triangles)
      areas[parts.find(t[0])] += areaOf(welded.points[t[0]], welded.points[t[1]], welded.points[t[2]]);
    for (std::size_t l = 0; l < loops.size(); ++l) {
      const std::uint32_t part = parts.find(loops[l].front());
      bool& sheet = isSheet[part];
      sheet = sheet || vdbtools::areaOf(caps[l], welded.points) > kSheet * areas[part];
    }
    count = areas.size();
  }

  bool sheetsOnly() const {
    return !isSheet.empty() &&
           std::all_of(isSheet.begin(), isSheet.end(), [](const auto& part) { return part.second; });
  }

  std::vector<BoundaryLoop> loops;
  std::vector<std::vector<Vec3I>> caps;  ///< of the loops
  DisjointSets<std::uint32_t> parts;
  std::map<std::uint32_t, bool> isSheet;  ///< of the parts with a loop
  std::size_t count = 0;                  ///< of parts
};

}  // namespace

double areaOf(std::span<const Vec3I> triangles, const std::vector<Vec3d>& points) {
  double area = 0;
  for (const Vec3I& t : triangles) area += areaOf(points[t[0]], points[t[1]], points[t[2]]);
  return area;
}

std::vector<OpenEdge> openEdges(const Mesh& welded) {
  std::vector<OpenEdge> edges, open;
  edges.reserve(3 * welded.triangles.size());
  for (std::size_t n = 0; n < welded.triangles.size(); ++n)
    for (int c = 0; c < 3; ++c)
      edges.push_back({welded.triangles[n][c], welded.triangles[n][(c + 1) % 3], static_cast<std::uint32_t>(n)});
  const auto key = [](const OpenEdge& e) { return std::minmax(e.a, e.b); };
  const auto ends = [&key](const OpenEdge& e) {
    const auto [low, high] = key(e);
    return std::uint64_t{low} << 32 | high;
  };
  std::sort(edges.begin(), edges.end(), [&](const OpenEdge& x, const OpenEdge& y) {
    return std::pair(ends(x), x.triangle) < std::pair(ends(y), y.triangle);
  });
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const bool before = e > 0 && ends(edges[e - 1]) == ends(edges[e]);
    const bool after = e + 1 < edges.size() && ends(edges[e + 1]) == ends(edges[e]);
    if (!before && !after) open.push_back(edges[e]);
  }
  return open;
}

std::vector<BoundaryLoop> boundaryLoops(const Mesh& welded) {
  const std::vector<OpenEdge> edges = openEdges(welded);
  std::map<std::uint32_t, std::vector<std::size_t>> at;  // the edges at each point
  for (std::size_t e = 0; e < edges.size(); ++e) {
    at[edges[e].a].push_back(e);
    at[edges[e].b].push_back(e);
  }
  std::vector<bool> used(edges.size(), false);
  // The next edge from a point, preferably one that its triangle has in this direction.
  const auto nextFrom = [&](std::uint32_t p) {
    std::optional<std::size_t> next;
    for (const std::size_t e : at[p]) {
      if (used[e]) continue;
      if (edges[e].a == p) return std::optional(e);
      if (!next) next = e;
    }
    return next;
  };
  std::vector<BoundaryLoop> loops;
  for (std::size_t first = 0; first < edges.size(); ++first) {
    if (used[first]) continue;
    std::vector<std::uint32_t> path{edges[first].a};
    std::vector<int> forward;  // for each edge of the path: 1, or -1 if the triangle has it reversed
    std::map<std::uint32_t, std::size_t> place{{path.front(), 0}};
    for (std::optional<std::size_t> e = nextFrom(path.back()); e; e = nextFrom(path.back())) {
      used[*e] = true;
      const bool ahead = edges[*e].a == path.back();
      const std::uint32_t to = ahead ? edges[*e].b : edges[*e].a;
      forward.push_back(ahead ? 1 : -1);
      const auto met = place.find(to);
      if (met == place.end()) {
        place.emplace(to, path.size());
        path.push_back(to);
        continue;
      }
      const auto begin = static_cast<std::ptrdiff_t>(met->second);
      BoundaryLoop loop(path.begin() + begin, path.end());
      int direction = 0;
      for (auto way = forward.begin() + begin; way != forward.end(); ++way) direction += *way;
      if (direction < 0) std::reverse(loop.begin(), loop.end());
      if (loop.size() > 2) loops.push_back(std::move(loop));
      for (std::size_t i = met->second + 1; i < path.size(); ++i) place.erase(path[i]);
      path.resize(met->second + 1);
      forward.resize(met->second);
    }
  }
  return loops;
}

void spanLoop(std::span<const std::uint32_t> loop, const std::vector<Vec3d>& points, std::vector<Vec3I>& triangles) {
  // A neighbour has the edge in the opposite direction.
  const std::vector<std::uint32_t> ring(loop.rbegin(), loop.rend());
  spanRing(ring, points, triangles);
}

HoleCappedMesh capHoles(Mesh welded, bool gapsToo) {
  Outline outline(welded);
  HoleCappedMesh result{.sheetsOnly = outline.sheetsOnly()};
  std::vector<std::uint32_t> openPoints, loopOf(welded.points.size(), ~std::uint32_t{0});
  for (std::size_t l = 0; l < outline.loops.size(); ++l)
    for (const std::uint32_t p : outline.loops[l]) {
      openPoints.push_back(p);
      loopOf[p] = static_cast<std::uint32_t>(l);
    }
  for (std::size_t l = 0; l < outline.loops.size(); ++l) {
    const BoundaryLoop& loop = outline.loops[l];
    if (outline.isSheet.at(outline.parts.find(loop.front()))) continue;
    if (!gapsToo && isSideOfGap(loop, l, welded.points, openPoints, loopOf)) {
      ++result.gaps;
      continue;
    }
    welded.triangles.insert(welded.triangles.end(), outline.caps[l].begin(), outline.caps[l].end());
    result.widest = std::max(result.widest, extentOf(loop, welded.points));
    ++result.caps;
  }
  result.mesh = std::move(welded);
  return result;
}

Mesh capInnerLoops(Mesh welded) {
  Outline outline(welded);
  std::map<std::uint32_t, std::size_t> longest;  // loop of each part
  const auto length = [&](std::size_t l) {
    const BoundaryLoop& loop = outline.loops[l];
    double sum = 0;
    for (std::size_t i = 0; i < loop.size(); ++i)
      sum += (welded.points[loop[(i + 1) % loop.size()]] - welded.points[loop[i]]).length();
    return sum;
  };
  for (std::size_t l = 0; l < outline.loops.size(); ++l) {
    const auto [kept, isNew] = longest.emplace(outline.parts.find(outline.loops[l].front()), l);
    if (!isNew && length(l) > length(kept->second)) kept->second = l;
  }
  for (std::size_t l = 0; l < outline.loops.size(); ++l)
    if (longest.at(outline.parts.find(outline.loops[l].front())) != l)
      welded.triangles.insert(welded.triangles.end(), outline.caps[l].begin(), outline.caps[l].end());
  return welded;
}

bool isOneSheet(const Mesh& welded) {
  const Outline outline(welded);
  return outline.count == 1 && outline.sheetsOnly();
}

}  // namespace vdbtools
