// SPDX-License-Identifier: Apache-2.0
#include "surface/edge_search.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace vdbtools {
namespace {

/// Brackets of sign changes, in voxels from the edges' beginnings, and F at their ends.
struct Brackets {
  std::vector<std::uint32_t> edge;
  std::vector<double> low, high, atLow, atHigh;

  std::size_t size() const { return edge.size(); }
  void resize(std::size_t size) {
    edge.resize(size);
    for (std::vector<double>* part : {&low, &high, &atLow, &atHigh}) part->resize(size);
  }
  void push(std::size_t of, double from, double to) {
    edge.push_back(static_cast<std::uint32_t>(of));
    low.push_back(0);
    high.push_back(1);
    atLow.push_back(from);
    atHigh.push_back(to);
  }
};

/// F guides the search but is unreliable: it spans many orders of magnitude and jumps where an orbit escapes one step
/// earlier. Far from 0, little more than its sign matters.
double damped(double field) { return field / (1 + std::abs(field)); }

/// Where to evaluate next: the step of the ITP method (Oliveira and Takahashi, ACM TOMS 47(1), 2020), which
/// interpolates but never lets the bracket become wider than @a most.
double nextPoint(double low, double high, double atLow, double atHigh, double most) {
  constexpr double kTruncation = 0.1;
  const double size = high - low, middle = low + size / 2;
  const double interpolated = (high * atLow - low * atHigh) / (atLow - atHigh);
  // Shifted slightly towards the middle, so that the sign change is likely to be on the short side.
  const double towards = middle >= interpolated ? 1 : -1;
  const double truncation = kTruncation * size * size;
  const double truncated = truncation <= std::abs(middle - interpolated) ? interpolated + towards * truncation : middle;
  const double reach = std::max(0.0, most - size / 2);
  return std::abs(truncated - middle) <= reach ? truncated : middle - towards * reach;
}

/// Evaluates F at ends of which only the sign is known, as it would have been stored.
void evaluateEnds(const std::vector<LatticeEdge>& edges, double voxelSize, const FieldSource& source,
                  Brackets& brackets) {
  constexpr float kUnknown = static_cast<float>(julia::kFieldLimit);
  std::vector<julia::Point> points;
  std::vector<double*> ends;
  for (std::size_t i = 0; i < brackets.size(); ++i) {
    const LatticeEdge& edge = edges[brackets.edge[i]];
    if (edge.from < kUnknown && edge.to < kUnknown) continue;
    const bool atEnd = edge.to >= kUnknown;
    openvdb::Coord node = edge.begin;
    node[edge.axis] += atEnd ? 1 : 0;
    points.push_back(source.space.toFractal(node.asVec3d() * voxelSize));
    ends.push_back(atEnd ? &brackets.atHigh[i] : &brackets.atLow[i]);
  }
  if (points.empty()) return;
  std::vector<double> field(points.size());
  source.evaluator.evaluate(points, field, {});
  for (std::size_t i = 0; i < ends.size(); ++i) *ends[i] = damped(static_cast<double>(julia::storedField(field[i])));
}

/// Removes the brackets that are narrow enough. It does not branch on the test, which is unpredictable: the midpoint of
/// a remaining bracket is overwritten later.
void removeNarrow(Brackets& brackets, double width, std::vector<double>& found) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < brackets.size(); ++i) {
    const std::uint32_t edge = brackets.edge[i];
    const double low = brackets.low[i], high = brackets.high[i], size = high - low;
    found[edge] = low + size / 2;
    brackets.edge[kept] = edge;
    brackets.low[kept] = low;
    brackets.high[kept] = high;
    brackets.atLow[kept] = brackets.atLow[i];
    brackets.atHigh[kept] = brackets.atHigh[i];
    kept += size > width ? 1 : 0;
  }
  brackets.resize(kept);
}

}  // namespace

std::vector<openvdb::Vec3d> searchEdges(const std::vector<LatticeEdge>& edges, double voxelSize,
                                        const FieldSource& source, double tolerance) {
  const auto worldAt = [&](const LatticeEdge& edge, double t) {
    openvdb::Vec3d index = edge.begin.asVec3d();
    index[edge.axis] += t;
    return index * voxelSize;
  };
  // The midpoint of the last bracket is within half its width of the sign change.
  const double width = 2 * tolerance;
  int left = 1;  // evaluations: those of bisection, and one more for interpolation; rounding may take another
  while (std::ldexp(width, left - 1) < 1) ++left;

  std::vector<double> found(edges.size(), 0.5);
  std::vector<julia::Point> begins(edges.size()), points;
  std::vector<double> next, field;
  Brackets brackets;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    begins[i] = source.space.toFractal(worldAt(edges[i], 0));
    if (!edges[i].cut)
      brackets.push(i, damped(static_cast<double>(edges[i].from)), damped(static_cast<double>(edges[i].to)));
  }
  evaluateEnds(edges, voxelSize, source, brackets);
  for (;; --left) {
    removeNarrow(brackets, width, found);
    const std::size_t size = brackets.size();
    if (size == 0) break;
    next.resize(size);
    points.resize(size);
    field.resize(size);
    // The maximum width of a bracket for which the search ends within the remaining evaluations.
    const double most = std::ldexp(width, left - 1);
    for (std::size_t i = 0; i < size; ++i)
      next[i] = nextPoint(brackets.low[i], brackets.high[i], brackets.atLow[i], brackets.atHigh[i], most);
    for (std::size_t i = 0; i < size; ++i) {
      const LatticeEdge& edge = edges[brackets.edge[i]];
      points[i] = begins[brackets.edge[i]];
      points[i][static_cast<std::size_t>(edge.axis)] =
          source.space.toFractal((edge.begin[edge.axis] + next[i]) * voxelSize, edge.axis);
    }
    source.evaluator.evaluate(points, field, {});
    for (std::size_t i = 0; i < size; ++i) {
      // The sign at the low end stays that of the edge's beginning.
      const bool likeLow = (field[i] < 0) == (brackets.atLow[i] < 0);
      const double at = damped(field[i]), where = next[i];
      brackets.low[i] = likeLow ? where : brackets.low[i];
      brackets.high[i] = likeLow ? brackets.high[i] : where;
      brackets.atLow[i] = likeLow ? at : brackets.atLow[i];
      brackets.atHigh[i] = likeLow ? brackets.atHigh[i] : at;
    }
  }
  std::vector<openvdb::Vec3d> positions;
  positions.reserve(edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) positions.push_back(worldAt(edges[i], found[i]));
  return positions;
}

}  // namespace vdbtools
