// SPDX-License-Identifier: Apache-2.0
/// @file surface_distance.h
/// Proofs that one surface lies near another.
#pragma once

#include "search/surface_search.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh.h"

#include <cstdint>
#include <vector>

namespace vdbtools {

/// A place of a surface that was not proved to be near another one.
struct FarPlace {
  std::uint32_t triangle = 0;       ///< of the surface
  std::uint32_t otherTriangle = 0;  ///< the nearest of the other surface
};

/// The triangles of @a surface that hold a point farther than @a limit from @a other, and perhaps some whose farthest
/// point is nearer than that by a small part of the limit: one place of each. If there are none, it is proved that no
/// point of the surface, vertices and all others, is farther away.
///
/// The distance to a triangle is a convex function, so over a piece of the surface it is greatest at a corner. Pieces
/// are halved until one triangle of the other surface is near to all their corners, or one of these is far from all.
/// @param search  of @a other
/// @throw Interrupted
std::vector<FarPlace> placesFartherThan(double limit, const Mesh& surface, const Mesh& other,
                                        const SurfaceSearch& search, const Monitor& monitor);

}  // namespace vdbtools
