// SPDX-License-Identifier: Apache-2.0
/// @file mesh_to_sdf.h
/// The room `distance` converts meshes to signed distances, and widens and reads them. It uses the rooms up to
/// `recipe`.
///
/// This header converts a mesh to its signed distance field, the distance to the nearest of all triangles
/// (docs/design.md 2.9). phi < 0 inside, > 0 outside, in world units. Index space is world space divided by the voxel
/// size: node (i, j, k) lies at (i, j, k) h, whatever the mesh's position.
///
/// There is no sign if a mesh leaks: a hole wider than about two voxels yields a field without an inside, and a mesh
/// that passes at one resolution may fail at a finer one. meshToSdf() checks its result and throws.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh.h"

#include <cstddef>
#include <cstdint>

namespace vdbtools {

/// What becomes of the hollows of a solid: closed parts within others whose orientation says that they bound cavities.
enum class Hollows : std::uint8_t { Fill, Keep };

struct MeshToSdfOptions {
  double voxelSize = 0;          ///< h, world units, > 0
  double exteriorBandWidth = 3;  ///< voxels kept outside the surface, > 1
  double interiorBandWidth = 3;  ///< voxels kept inside, > 1; infinity keeps the whole inside
  Hollows hollows = Hollows::Fill;
};

/// How many parts of a mesh touch, intersect or enclose each other. A part is a set of triangles connected across
/// edges.
struct PartCounts {
  std::size_t intersecting =
      0;                    ///< parts that intersect or touch each other; a part that intersects itself counts, too
  std::size_t hollows = 0;  ///< surfaces that bound cavities, whether these are filled or kept
  std::size_t inner = 0;    ///< surfaces within others that bound nothing, and parts there that are not closed
  bool operator==(const PartCounts&) const = default;
};

/// Converts a mesh. A closed mesh may be oriented either way, intersect itself, and have inner walls; cavities that it
/// encloses are inside. Where closed parts intersect each other, the outer surface of their union counts. An open mesh
/// is accepted if the voxels span its holes. With Hollows::Keep, a closed part that lies wholly within others bounds a
/// cavity if the winding number is 0 just inside of it, and a part within a cavity is a solid again.
/// @param counts  if not null, receives the counts of the parts
/// @return a level set, with the class, background and flood fill that OpenVDB expects. The background is the exterior
///         band width in world units.
/// @throw std::invalid_argument  options out of their domain, or a grid of more than 2^31 nodes
/// @throw DataError              the mesh leaks or has no inside at this voxel size; the message gives the numbers
///                               (open edges, inside volume against the mesh's own), and a leak has Remedy::RepairMesh
/// @throw Interrupted
openvdb::FloatGrid::Ptr meshToSdf(const Mesh& mesh, const MeshToSdfOptions& options, Monitor& monitor,
                                  PartCounts* counts = nullptr);

}  // namespace vdbtools
