// SPDX-License-Identifier: Apache-2.0
/// @file part_shape.h
/// What is done to a solid so that it can be made: thin parts thickened or taken off, a flat base. All on level sets of
/// one lattice, whose node (i, j, k) lies at (i, j, k) h, with bands of kPartBand voxels.
#pragma once

#include "surface/part_thickness.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh.h"

#include <optional>

namespace vdbtools {

inline constexpr double kPartBand = 3;  ///< voxels on each side

/// The level set of a closed mesh, cavities filled.
openvdb::FloatGrid::Ptr partLevelSet(const Mesh& closed, double voxelSize, Monitor& monitor);

/// The part of the level set above a height.
void cutBelow(openvdb::FloatGrid& part, double floor, Monitor& monitor);

/// Adds a ball to the level set wherever the solid is thin: around the deepest place near each thin one. Every place
/// of @a mesh then lies within @a thickness of the centre of a ball of that diameter. The surface moves outward by less
/// than half the thickness, and nowhere inward.
/// @param mesh   the solid, closed, with normals
/// @param floor  balls stay above it
/// @return       how many points of the mesh were thin
std::size_t thicken(openvdb::FloatGrid& part, const Mesh& mesh, double thickness, std::optional<double> floor,
                    Monitor& monitor);

/// Takes off what is farther than @a thickness from the centre of a ball of that diameter in the solid.
/// @param mesh  the solid, closed
/// @throw DataError  nothing would be left
void dropThin(openvdb::FloatGrid& part, const Mesh& mesh, double thickness, Monitor& monitor);

}  // namespace vdbtools
