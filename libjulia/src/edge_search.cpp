// SPDX-License-Identifier: Apache-2.0
// The search on edges by an evaluator of points.
#include "julia/edge_search.h"

#include "julia/evaluator.h"

#include "kernels/elementary.h"

#include <cmath>
#include <cstdint>
#include <vector>

namespace julia {
namespace {

#include "kernels/shared/search.h"

/// Brackets of changes of sign, in voxels from the edges' beginnings, and F at their ends.
struct Brackets {
  std::vector<std::uint32_t> edge;
  std::vector<double> low, high, atLow, atHigh;

  std::size_t size() const { return edge.size(); }
  void resize(std::size_t size) {
    edge.resize(size);
    for (std::vector<double>* part : {&low, &high, &atLow, &atHigh}) part->resize(size);
  }
};

/// Whether F is not known at an end of an edge, but only its sign.
bool isSignAlone(float field) {
  constexpr float kLimit = static_cast<float>(kFieldLimit);
  return !(field < kLimit && field > -kLimit);
}

/// Evaluates F at ends where only its sign is known, and rounds it as a stored value.
void evaluateEnds(const FieldEvaluator& evaluator, std::span<const CrossedEdge> edges, const SearchLattice& lattice,
                  Brackets& brackets) {
  std::vector<Point> points;
  std::vector<double*> ends;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const CrossedEdge& edge = edges[i];
    if (isSignAlone(edge.from)) {
      points.push_back(edge.begin);
      ends.push_back(&brackets.atLow[i]);
    }
    if (isSignAlone(edge.to)) {
      points.push_back(edge.begin);
      points.back()[static_cast<std::size_t>(edge.axis)] = lattice.at(edge.index + 1, edge.axis);
      ends.push_back(&brackets.atHigh[i]);
    }
  }
  if (points.empty()) return;
  std::vector<double> field(points.size());
  evaluator.evaluate(points, field, {});
  for (std::size_t i = 0; i < ends.size(); ++i) *ends[i] = damped(static_cast<double>(storedField(field[i])));
}

/// Removes the brackets that are narrow enough. It does not branch on the test, which is unpredictable: the midpoint of
/// a remaining bracket is overwritten later.
void removeNarrow(Brackets& brackets, double width, std::span<double> found) {
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

int mostEvaluations(const SearchLattice& lattice) {
  int most = 1;
  while (std::ldexp(narrowBracket(lattice), most - 1) < 1) ++most;
  return most;
}

void FieldEvaluator::findNodeCrossings(std::span<const NodeEdge> edges, const SearchLattice& lattice,
                                       std::span<double> found) const {
  std::vector<CrossedEdge> crossed;
  crossed.reserve(edges.size());
  for (const NodeEdge& edge : edges) {
    Point begin;
    for (std::size_t axis = 0; axis < 3; ++axis)
      begin[axis] = lattice.at(static_cast<double>(edge.node[axis]), static_cast<int>(axis));
    const double index = static_cast<double>(edge.node[static_cast<std::size_t>(edge.axis)]);
    crossed.push_back({begin, edge.axis, index, edge.from, edge.to});
  }
  findCrossings(crossed, lattice, found);
}

void FieldEvaluator::findCrossings(std::span<const CrossedEdge> edges, const SearchLattice& lattice,
                                   std::span<double> found) const {
  const double width = narrowBracket(lattice);
  Brackets brackets;
  brackets.resize(edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    brackets.edge[i] = static_cast<std::uint32_t>(i);
    brackets.low[i] = 0;
    brackets.high[i] = 1;
    brackets.atLow[i] = damped(static_cast<double>(edges[i].from));
    brackets.atHigh[i] = damped(static_cast<double>(edges[i].to));
  }
  evaluateEnds(*this, edges, lattice, brackets);
  std::vector<Point> points;
  std::vector<double> next, field;
  for (int left = mostEvaluations(lattice);; --left) {
    removeNarrow(brackets, width, found);
    const std::size_t size = brackets.size();
    if (size == 0) return;
    next.resize(size);
    points.resize(size);
    field.resize(size);
    // The maximum width of a bracket for which the search ends within the remaining evaluations.
    const double most = std::ldexp(width, left - 1);
    for (std::size_t i = 0; i < size; ++i)
      next[i] = nextPoint(brackets.low[i], brackets.high[i], brackets.atLow[i], brackets.atHigh[i], most);
    for (std::size_t i = 0; i < size; ++i) {
      const CrossedEdge& edge = edges[brackets.edge[i]];
      points[i] = edge.begin;
      points[i][static_cast<std::size_t>(edge.axis)] = lattice.at(edge.index + next[i], edge.axis);
    }
    evaluate(points, field, {});
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
}

}  // namespace julia
