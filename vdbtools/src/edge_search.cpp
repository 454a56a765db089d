// SPDX-License-Identifier: Apache-2.0
#include "edge_search.h"

namespace vdbtools {

// F jumps where an orbit escapes one step sooner, and an edge may hold many changes of sign; bisection needs nothing
// but signs, finds the change that the papers' programs find, and gives the same result from either end.
std::vector<openvdb::Vec3d> searchEdges(const std::vector<LatticeEdge>& edges, double voxelSize,
                                        const FieldSource& source, double tolerance) {
  const auto worldAt = [&](const LatticeEdge& edge, double t) {
    openvdb::Vec3d index = edge.begin.asVec3d();
    index[edge.axis] += t;
    return index * voxelSize;
  };
  std::vector<double> low(edges.size(), 0.0);
  std::vector<julia::Point> points;
  std::vector<double> field;
  double width = 1;
  // Half the last bracket is how far the change may be from its middle.
  for (; width / 2 > tolerance; width /= 2) {
    points.clear();
    for (std::size_t i = 0; i < edges.size(); ++i)
      if (!edges[i].cut) points.push_back(source.space.toFractal(worldAt(edges[i], low[i] + width / 2)));
    field.resize(points.size());
    source.evaluator.evaluate(points, field, {});
    std::size_t k = 0;
    for (std::size_t i = 0; i < edges.size(); ++i)
      if (!edges[i].cut && (field[k++] < 0) == edges[i].beginInside) low[i] += width / 2;
  }
  std::vector<openvdb::Vec3d> positions;
  positions.reserve(edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i)
    positions.push_back(worldAt(edges[i], edges[i].cut ? 0.5 : low[i] + width / 2));
  return positions;
}

}  // namespace vdbtools
