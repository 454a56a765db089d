// SPDX-License-Identifier: Apache-2.0
/// @file target.h
/// The target as signed distances, and the band in which they are known.
#pragma once

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

}  // namespace vdbtools
