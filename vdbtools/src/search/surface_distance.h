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

/// A place of a surface that could not be proved to be near another surface.
struct FarPlace {
  std::uint32_t triangle = 0;       ///< of the surface
  std::uint32_t otherTriangle = 0;  ///< the nearest triangle of the other surface
};

/// Finds the triangles of @a surface with a point farther than @a limit from @a other, and returns one place of each.
/// It may include triangles whose farthest point is nearer than that by a small fraction of the limit. If the result is
/// empty, it is proved that no point of the surface, vertex or not, is farther away.
///
/// The distance to a triangle is a convex function, so its maximum over a piece of the surface is at a corner. Pieces
/// are halved until one triangle of the other surface is near to all their corners, or one of the corners is far from
/// all triangles.
/// @param search  searches @a other
/// @throw Interrupted
std::vector<FarPlace> placesFartherThan(double limit, const Mesh& surface, const Mesh& other,
                                        const SurfaceSearch& search, const Monitor& monitor);

}  // namespace vdbtools
