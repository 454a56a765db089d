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
  const julia::SearchLattice lattice{.voxelSize = voxelSize,
                                     .centre = {space.centre[0], space.centre[1], space.centre[2]},
                                     .scale = space.scale,
                                     .tolerance = tolerance};
  std::vector<julia::CrossedEdge> crossed;
  crossed.reserve(edges.size());
  for (const LatticeEdge& edge : edges)
    if (!edge.cut)
      crossed.push_back({space.toFractal(worldAt(edge, 0)), edge.axis, static_cast<double>(edge.begin[edge.axis]),
                         edge.from, edge.to});
  std::vector<double> found(crossed.size());
  source.evaluator.findCrossings(crossed, lattice, found);
  std::vector<openvdb::Vec3d> positions;
  positions.reserve(edges.size());
  auto place = found.begin();
  for (const LatticeEdge& edge : edges) positions.push_back(worldAt(edge, edge.cut ? *edge.cut : *place++));
  return positions;
}

}  // namespace vdbtools
