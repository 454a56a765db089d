// SPDX-License-Identifier: Apache-2.0
#include "surface/edge_search.h"

namespace vdbtools {

std::vector<openvdb::Vec3d> searchEdges(const std::vector<LatticeEdge>& edges, double voxelSize,
                                        const FieldSource& source, double tolerance) {
  const auto worldAt = [&](const LatticeEdge& edge, double t) {
    openvdb::Vec3d index = edge.begin.asVec3d();
    index[edge.axis] += t;
    return index * voxelSize;
  };
  const FractalSpace& space = source.space;
  const julia::SearchLattice lattice = source.lattice(voxelSize, tolerance);
  std::vector<double> found;
  if (source.evaluator.preferredNodes() > 0) {
    std::vector<julia::NodeEdge> crossed;
    crossed.reserve(edges.size());
    for (const LatticeEdge& edge : edges)
      if (!edge.cut) crossed.push_back({{edge.begin[0], edge.begin[1], edge.begin[2]}, edge.axis, edge.from, edge.to});
    found.resize(crossed.size());
    source.evaluator.findNodeCrossings(crossed, lattice, found);
  } else {
    std::vector<julia::CrossedEdge> crossed;
    crossed.reserve(edges.size());
    for (const LatticeEdge& edge : edges)
      if (!edge.cut)
        crossed.push_back({space.toFractal(worldAt(edge, 0)), edge.axis, static_cast<double>(edge.begin[edge.axis]),
                           edge.from, edge.to});
    found.resize(crossed.size());
    source.evaluator.findCrossings(crossed, lattice, found);
  }
  std::vector<openvdb::Vec3d> positions;
  positions.reserve(edges.size());
  auto place = found.begin();
  for (const LatticeEdge& edge : edges) positions.push_back(worldAt(edge, edge.cut ? *edge.cut : *place++));
  return positions;
}

}  // namespace vdbtools
