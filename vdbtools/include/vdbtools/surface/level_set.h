// SPDX-License-Identifier: Apache-2.0
/// @file level_set.h
/// The grids that are exported to other programs (docs/design.md).
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/field/fractal_field.h"
#include "vdbtools/mesh/mesh.h"

#include <string>

namespace vdbtools {

/// Half width of an exported level set, in voxels: slightly above the 3 that OpenVDB's check requires, because exactly
/// 3 fails by rounding.
inline constexpr double kHalfWidth = 3.01;

/// Computes the part of a level set that lies over some nodes: their distances to @a mesh, with the sign of F. The
/// nodes within the band are active; the others have no value yet. finishLevelSet() turns one or several parts into a
/// level set.
/// @param field   the field of a window that reaches five nodes beyond @a nodes, unless the domain ends there
/// @param source  evaluates F at nodes where the field has no leaf
/// @param mesh    the mesh of the same field with Border::Cap
/// @param nodes   may include nodes outside the domain
openvdb::FloatGrid::Ptr levelSetPart(const FractalField& field, const FieldSource& source, const Mesh& mesh,
                                     const openvdb::CoordBBox& nodes, Monitor& monitor);

/// Fills the nodes outside the band with its width, signed inside or outside, prunes the tree, and names the grid
/// "surface".
void finishLevelSet(openvdb::FloatGrid& grid);

/// Computes the level set of the fractal: the distance to @a mesh, with the sign that F has at the node. It has the
/// class level set, a uniform scale and no active tile, is flood filled, and is named "surface".
/// @param mesh  the mesh of the same field with Border::Cap
openvdb::FloatGrid::Ptr levelSet(const FractalField& field, const Mesh& mesh, Monitor& monitor);

/// Fog whose density is 1 inside and falls to 0 at the surface over the half width; named "density".
openvdb::FloatGrid::Ptr densityGrid(const openvdb::FloatGrid& surface);

/// F at the nodes that were evaluated, of class unknown; named "logmodulus".
openvdb::FloatGrid::Ptr logModulusGrid(const FractalField& field);

/// The three imaginary components of the map's versor over the band of @a surface; named "versor".
openvdb::Vec3SGrid::Ptr versorGrid(const openvdb::FloatGrid& surface, const FieldSource& source, Monitor& monitor);

/// The findings of OpenVDB's checkLevelSet.
struct LevelSetCheck {
  std::string failure;  ///< the failure in tests 1 to 8; empty: none
  /// The fraction of the active voxels for which | |grad phi| - 1 | < 0.5; 0 if voxels are not cubes.
  double gradientFraction = 0;
};

LevelSetCheck checkSurface(const openvdb::FloatGrid& surface);

// Converts any level set to a mesh, by the same marching cubes as for a fractal: closed and 2-manifold. A vertex lies
// where the grid, interpolated linearly along the edge, is 0. For a fractal the result is a coarse approximation; its
// own field gives the true surface.

/// Positions are in the grid's world space. The mesh has no normals; see computeNormals().
/// @param levelSet  negative inside; a positive background
/// @throw DataError  no change of sign, values that are not finite
Mesh meshOfLevelSet(const openvdb::FloatGrid& levelSet, Monitor& monitor);

/// The distances to the mesh of meshOfLevelSet() at the nodes of the same lattice, with the sign that the level set has
/// there. They are exact for that mesh at any distance, where sweeping adds an error at each voxel.
/// @param band  half width, voxels, above 1
/// @return a level set in world units, flood filled
/// @throw DataError  as meshOfLevelSet(), or the voxels are not cubes
/// @throw std::invalid_argument  more than 2^31 nodes
/// @throw Interrupted
openvdb::FloatGrid::Ptr redistanced(const openvdb::FloatGrid& levelSet, double band, Monitor& monitor);

}  // namespace vdbtools
