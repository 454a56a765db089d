// SPDX-License-Identifier: Apache-2.0
/// @file mesh_repair.h
/// The room `repair` makes solids from inputs that bound no volume: meshes with holes, terrain, sheets, point clouds.
/// It uses the rooms up to `distance`.
///
/// This header computes signed distances of meshes with holes and gaps.
#pragma once

#include "vdbtools/distance/mesh_to_sdf.h"

#include <cstddef>

namespace vdbtools {

struct RepairedSdf {
  openvdb::FloatGrid::Ptr grid;
  /// How far the surface may have moved, world units: the largest distance from a vertex or face centre of the mesh to
  /// the new surface. Those deeper inside than half the gap belong to inner walls and do not count. The distance is
  /// read from the grid, so it is accurate to about half a voxel at sharp edges.
  double moved = 0;
  /// The widest gap that is guaranteed to be closed, world units.
  double closedGap = 0;
  std::size_t caps = 0;  ///< holes that were capped
  PartCounts parts{};    ///< as in meshToSdf()
};

struct RepairOptions {
  /// Gaps up to this width are closed, world units, at most the mesh's longest side. 0 stands for twice the voxel size,
  /// widened until the mesh has an inside; if a quarter of the longest side is not enough, it is an error. With 0,
  /// holes of any width are capped first, and no gap is closed if the caps suffice.
  double gap = 0;
};

/// Serves open scans and triangle soups. It computes an unsigned field, floods it from outside through everything
/// farther than half the gap from the mesh, and offsets the result back by the same amount. Where the result bridges a
/// hole it becomes a lid, part of the mesh; elsewhere the field is the distance to the mesh itself, as in meshToSdf().
/// A lid is the envelope of a ball as wide as the gap that rests on the hole's rim: it is dented inward by at most half
/// the gap.
///
/// Without a gap, each loop of open edges is first capped by the surface of least area that spans it ([BS95]). Two
/// kinds of loops are not capped: loops that run along each other, which are the two sides of a gap, and loops of
/// sheets, whose cap has more than 3/4 of the sheet's own area.
/// @throw as meshToSdf(), where DataError means that no reasonable gap encloses a volume; Remedy::SolidifySheet says
///           that the mesh is open without being a solid with holes
RepairedSdf repairedMeshToSdf(const Mesh& mesh, const MeshToSdfOptions& options, const RepairOptions& repair,
                              Monitor& monitor);

}  // namespace vdbtools
