// SPDX-License-Identifier: Apache-2.0
/// @file level_set.h
/// The grids that are handed on to other programs (docs/design.md).
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/field/fractal_field.h"
#include "vdbtools/mesh/mesh.h"

#include <string>

namespace vdbtools {

/// Half width of a level set that leaves the program, in voxels: a little over the 3 that OpenVDB's check asks for, as
/// exactly 3 fails it by rounding.
inline constexpr double kHalfWidth = 3.01;

/// The part of a level set that lies over some nodes: their distances to @a mesh, with the sign of F. The nodes within
/// the band are active; the others have no value yet. finishLevelSet() makes a level set of one or several parts.
/// @param field   of a window that reaches five nodes beyond @a nodes, unless the domain ends there
/// @param source  of F, for nodes where the field has no leaf
/// @param mesh    of the same field with Border::Cap
/// @param nodes   those beyond the domain may be among them
openvdb::FloatGrid::Ptr levelSetPart(const FractalField& field, const FieldSource& source, const Mesh& mesh,
                                     const openvdb::CoordBBox& nodes, Monitor& monitor);

/// Fills the nodes beyond the band with its width, inside or outside, prunes the tree, and names the grid "surface".
void finishLevelSet(openvdb::FloatGrid& grid);

/// The level set of the fractal: the distance to @a mesh, with the sign that F has at the node. Class, uniform scale,
/// no active tile, flood filled; named "surface".
/// @param mesh  of the same field with Border::Cap
openvdb::FloatGrid::Ptr levelSet(const FractalField& field, const Mesh& mesh, Monitor& monitor);

/// Fog whose density is 1 inside and falls to 0 at the surface over the half width; named "density".
openvdb::FloatGrid::Ptr densityGrid(const openvdb::FloatGrid& surface);

/// F at the nodes that were evaluated, of class unknown; named "logmodulus".
openvdb::FloatGrid::Ptr logModulusGrid(const FractalField& field);

/// The three imaginary components of the map's versor over the band of @a surface; named "versor".
openvdb::Vec3SGrid::Ptr versorGrid(const openvdb::FloatGrid& surface, const FieldSource& source, Monitor& monitor);

/// What OpenVDB's checkLevelSet finds.
struct LevelSetCheck {
  std::string failure;  ///< of tests 1 to 8; empty: none
  /// Of the active voxels, those where | |grad phi| - 1 | < 0.5; 0 where voxels are not cubes.
  double gradientFraction = 0;
};

LevelSetCheck checkSurface(const openvdb::FloatGrid& surface);

}  // namespace vdbtools
