// SPDX-License-Identifier: Apache-2.0
/// @file target.h
/// The target as signed distances, and the band in which they are known.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"

#include <optional>

namespace vdbtools {

/// The target: phi, what is known of its extent, and whether it is known beyond.
struct Target {
  openvdb::FloatGrid::Ptr phi;  ///< world units, negative inside
  openvdb::BBoxd box;           ///< of the shape, world units
  /// The nodes of a dense field, index space. Beyond them phi is the nearest face's value. A narrow band has none: it
  /// is the tiles' and the background's there.
  std::optional<openvdb::CoordBBox> denseBox;
  std::optional<double> repairMoved{};  ///< how far a repair may have moved the surface, world units
};

/// Takes phi as it is: dense (every node of its active box is active) or narrow band. Active tiles are made voxels.
/// @param box  the shape's box where it is known better than from phi
/// @throw DataError  empty, not finite, without an inside, a background that is not positive in a narrow band
Target makeTarget(openvdb::FloatGrid::Ptr phi, std::optional<openvdb::BBoxd> box);

/// Nodes of phi that are needed beyond the reach of a shell, voxels: those that are read about a point there.
inline constexpr double kExponentMargin = 7;

/// Widens the band of a narrow-band target, where it is narrower, to @a exteriorWidth and @a interiorWidth (world
/// units; infinity: over the whole inside), and kExponentMargin voxels further, by fast sweeping. Values of the band
/// stay as they are. A dense target stays as it is.
void extendBand(Target& target, double exteriorWidth, double interiorWidth, Monitor& monitor);

}  // namespace vdbtools
