// SPDX-License-Identifier: Apache-2.0
/// @file target.h
/// The target as signed distances, and the band in which they are known.
#pragma once

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"

#include <map>
#include <optional>
#include <string>

namespace vdbtools {

/// The target: phi, its known extent, and whether phi is known beyond the active nodes.
struct Target {
  openvdb::FloatGrid::Ptr phi;  ///< world units, negative inside
  openvdb::BBoxd box;           ///< of the shape, world units
  /// The nodes of a dense field, index space. Outside them phi equals the nearest value on the box. A narrow band has
  /// no such box; there, phi is given by the tiles and the background.
  std::optional<openvdb::CoordBBox> denseBox;
  std::optional<double> repairMoved{};         ///< how far a repair may have moved the surface, world units
  std::map<std::string, std::string> facts{};  ///< metadata that say how the target was read
};

/// Takes phi unchanged: dense (every node of its active box is active) or narrow band. Active tiles are turned into
/// voxels.
/// @param box  the shape's box if it is known more exactly than from phi
/// @throw DataError  phi is empty, not finite, without an inside, or a narrow band that is not positive outside
Target makeTarget(openvdb::FloatGrid::Ptr phi, std::optional<openvdb::BBoxd> box);

/// The width, in voxels, of phi beyond a shell that is needed to read a neighbourhood of every point of the shell.
inline constexpr double kExponentMargin = 7;

/// Widens the band of a narrow-band target by fast sweeping to at least @a exteriorWidth and @a interiorWidth (world
/// units; infinity: the whole inside) plus kExponentMargin voxels. Values of the existing band stay unchanged, and so
/// does a dense target.
void extendBand(Target& target, double exteriorWidth, double interiorWidth, Monitor& monitor);

// The fractal space (fractal_space.h) of a target, from its signed distances: phi < 0 inside, world units.

/// The bounding box of the nodes where phi < 0, in index space, including tiles.
/// @throw DataError if phi is nowhere negative
openvdb::CoordBBox insideNodeBox(const openvdb::FloatGrid& phi);

/// The bounding box of phi < 0 in world units. Its faces lie where phi, interpolated linearly between nodes, crosses 0.
/// @throw DataError if phi is nowhere negative
openvdb::BBoxd insideBox(const openvdb::FloatGrid& phi);

/// Whether phi < 0 at the centre of the box. If so, fitFractalSpace() needs no distances deep inside.
bool centreIsInside(const openvdb::FloatGrid& phi, const openvdb::BBoxd& box);

/// The space of a target. Its centre is the centre of the box if phi < 0 there, else the deepest node (the first in the
/// order of the tree). Fits to a target use this space.
/// @throw DataError if phi is nowhere negative; std::invalid_argument if the box has no extent
FractalSpace fitFractalSpace(const openvdb::FloatGrid& phi, const openvdb::BBoxd& box);

}  // namespace vdbtools
