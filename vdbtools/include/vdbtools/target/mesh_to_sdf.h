// SPDX-License-Identifier: Apache-2.0
/// @file mesh_to_sdf.h
/// The room `target` turns a shape into what the dynamics needs of it: signed distances, the space that the maps are
/// iterated in, and the exponent grid. It uses the rooms up to `recipe`.
///
/// Here: from a mesh to its signed distance field, the distance to the nearest of all triangles (docs/design.md 2.9).
/// phi < 0 inside, > 0 outside, in world units. Index space is world space over the voxel size: node (i, j, k) lies at
/// (i, j, k) h, whatever the mesh's position.
///
/// There is no sign when a mesh leaks: a hole wider than about two voxels yields a field without an inside,
/// and a mesh that passes at one resolution may fail at a finer one. meshToSdf() checks its result and throws.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh.h"

#include <cstddef>

namespace vdbtools {

struct MeshToSdfOptions {
  double voxelSize = 0;          ///< h, world units, > 0
  double exteriorBandWidth = 3;  ///< voxels kept outside the surface, > 1
  double interiorBandWidth = 3;  ///< voxels kept inside, > 1; infinity keeps the whole inside
};

/// @return a level set, with the class, background and flood fill that OpenVDB expects. The background is the exterior
///         band width in world units.
/// A closed mesh may be oriented either way, cross itself, and have inner walls; cavities that it encloses are inside.
/// Of closed parts that run into each other, the outer surface of their union counts. An open mesh passes if the voxels
/// span its holes.
/// @param united  if not null, becomes the number of such parts
/// @throw std::invalid_argument  options out of their domain, or a grid of more than 2^31 nodes
/// @throw DataError              the mesh leaks or has no inside at this voxel size; the text gives the numbers (open
///                               edges, inside volume against the mesh's own) and a leak has Remedy::RepairMesh
/// @throw Interrupted
openvdb::FloatGrid::Ptr meshToSdf(const Mesh& mesh, const MeshToSdfOptions& options, Monitor& monitor,
                                  std::size_t* united = nullptr);

struct RepairedSdf {
  openvdb::FloatGrid::Ptr grid;
  /// How far the surface may have moved, world units: the largest distance from a vertex or face centre of the mesh to
  /// the new surface. Those deeper inside than half the gap belong to inner walls and do not count. It is read off the
  /// grid, so it is good to about half a voxel at sharp edges.
  double moved = 0;
  /// The widest gap that is certain to be closed, world units.
  double closedGap = 0;
  std::size_t caps = 0;    ///< holes that were capped
  std::size_t united = 0;  ///< parts that run into each other, as of meshToSdf()
};

struct RepairOptions {
  /// Gaps up to this width are closed, world units, at most the mesh's longest side. 0 stands for twice the voxel size,
  /// widened until the mesh has an inside; it is an error if a quarter of the longest side is not enough. Before that,
  /// holes are capped, however wide, and that is all where it suffices.
  double gap = 0;
};

/// For open scans and triangle soups: an unsigned field, a flood fill from outside through everything farther than half
/// the gap from the mesh, and an offset back by the same amount. Where the result bridges a hole it becomes a lid, part
/// of the mesh; elsewhere the field is the distance to the mesh itself, as meshToSdf() makes it. A lid is the envelope
/// of a ball as wide as the gap that rests on the hole's rim: it is dented inward, by no more than half the gap.
///
/// Without a gap, each loop of open edges is capped first, by the surface of least area over it ([BS95]). Not capped
/// are loops that run along each other, which are the two sides of a gap, and those of sheets, whose cap has more than
/// 3/4 of their own area.
/// @throw as meshToSdf(), where DataError means that no reasonable gap encloses a volume; Remedy::SolidifySheet says
///        that the mesh is open without being a solid with holes
RepairedSdf repairedMeshToSdf(const Mesh& mesh, const MeshToSdfOptions& options, const RepairOptions& repair,
                              Monitor& monitor);

}  // namespace vdbtools
