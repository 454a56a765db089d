// SPDX-License-Identifier: Apache-2.0
/// @file part_shape.h
/// Modifies a solid so that it can be manufactured: thickens or removes thin parts, and makes a flat base. All
/// functions work on level sets of one lattice, whose node (i, j, k) lies at (i, j, k) h, with bands of kPartBand
/// voxels.
#pragma once

#include "surface/part_thickness.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh.h"

#include <optional>

namespace vdbtools {

inline constexpr double kPartBand = 3;  ///< voxels on each side

/// The level set of a closed mesh, with its cavities filled.
openvdb::FloatGrid::Ptr partLevelSet(const Mesh& closed, double voxelSize, Monitor& monitor);

/// Removes the part of the level set below a height.
void cutBelow(openvdb::FloatGrid& part, double floor, Monitor& monitor);

/// Adds a ball to the level set wherever the solid is thin: around the deepest position near each thin one. Every
/// position of @a mesh then lies within @a thickness of the centre of a ball of that diameter. The surface moves
/// outward by less than half the thickness, and never inward.
/// @param mesh   the solid, closed, with normals
/// @param floor  balls stay above it
/// @return       the number of thin points of the mesh
std::size_t thicken(openvdb::FloatGrid& part, const Mesh& mesh, double thickness, std::optional<double> floor,
                    Monitor& monitor);

/// Removes what is farther than @a thickness from the centre of a ball of that diameter in the solid.
/// @param mesh  the solid, closed
/// @throw DataError  nothing would be left
void dropThin(openvdb::FloatGrid& part, const Mesh& mesh, double thickness, Monitor& monitor);

}  // namespace vdbtools
