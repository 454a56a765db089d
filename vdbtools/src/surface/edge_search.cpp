// SPDX-License-Identifier: Apache-2.0
#include "surface/edge_search.h"

#include <algorithm>
#include <cmath>

namespace vdbtools {
namespace {

/// A bracket of a change of sign, in voxels from the edge's beginning, and F at its ends.
struct Bracket {
  std::size_t edge;
  julia::Point point;  ///< where F was asked for last; two of its coordinates stay
  double low = 0, high = 1;
  double atLow, atHigh;
};

/// F guides the search, but it cannot be trusted: it spans many orders of magnitude and jumps where an orbit escapes
/// one step sooner. Far from 0, little more than its sign matters.
double damped(double field) { return field / (1 + std::abs(field)); }

/// Where to evaluate next: the step of the ITP method (Oliveira and Takahashi, ACM TOMS 47(1), 2020), which
/// interpolates but never lets the bracket become wider than @a most.
double nextPoint(const Bracket& bracket, double most) {
  constexpr double kTruncation = 0.1;
  const double size = bracket.high - bracket.low, middle = bracket.low + size / 2;
  const double interpolated =
      (bracket.high * bracket.atLow - bracket.low * bracket.atHigh) / (bracket.atLow - bracket.atHigh);
  // A little towards the middle, so that the change is likely to lie on the short side.
  const double towards = middle >= interpolated ? 1 : -1;
  const double truncation = kTruncation * size * size;
  const double truncated = truncation <= std::abs(middle - interpolated) ? interpolated + towards * truncation : middle;
  const double reach = std::max(0.0, most - size / 2);
  return std::abs(truncated - middle) <= reach ? truncated : middle - towards * reach;
}

}  // namespace

std::vector<openvdb::Vec3d> searchEdges(const std::vector<LatticeEdge>& edges, double voxelSize,
                                        const FieldSource& source, double tolerance) {
  const auto worldAt = [&](const LatticeEdge& edge, double t) {
    openvdb::Vec3d index = edge.begin.asVec3d();
    index[edge.axis] += t;
    return index * voxelSize;
  };
  // The middle of the last bracket is within half its width of the change.
  const double width = 2 * tolerance;
  int left = 1;  // evaluations at the most: bisection's, and one to spare for interpolating
  while (std::ldexp(width, left - 1) < 1) ++left;

  std::vector<double> found(edges.size(), 0.5);
  std::vector<Bracket> brackets;
  brackets.reserve(edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i)
    if (!edges[i].cut)
      brackets.push_back({.edge = i,
                          .point = source.space.toFractal(worldAt(edges[i], 0)),
                          .atLow = damped(edges[i].from),
                          .atHigh = damped(edges[i].to)});
  std::vector<julia::Point> points;
  std::vector<double> next, field;
  for (;; --left) {
    // Brackets that are narrow enough leave the batch.
    std::erase_if(brackets, [&](const Bracket& bracket) {
      if (bracket.high - bracket.low > width) return false;
      found[bracket.edge] = bracket.low + (bracket.high - bracket.low) / 2;
      return true;
    });
    if (brackets.empty()) break;
    points.clear();
    next.clear();
    // As wide as a bracket may be for the search to end within the evaluations that are left.
    const double most = std::ldexp(width, left - 1);
    for (Bracket& bracket : brackets) {
      next.push_back(nextPoint(bracket, most));
      const LatticeEdge& edge = edges[bracket.edge];
      bracket.point[static_cast<std::size_t>(edge.axis)] =
          source.space.toFractal((edge.begin[edge.axis] + next.back()) * voxelSize, edge.axis);
      points.push_back(bracket.point);
    }
    field.resize(points.size());
    source.evaluator.evaluate(points, field, {});
    for (std::size_t i = 0; i < brackets.size(); ++i) {
      Bracket& bracket = brackets[i];
      const bool likeLow = (field[i] < 0) == (edges[bracket.edge].from < 0);
      (likeLow ? bracket.low : bracket.high) = next[i];
      (likeLow ? bracket.atLow : bracket.atHigh) = damped(field[i]);
    }
  }
  std::vector<openvdb::Vec3d> positions;
  positions.reserve(edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) positions.push_back(worldAt(edges[i], found[i]));
  return positions;
}

}  // namespace vdbtools
