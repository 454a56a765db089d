// SPDX-License-Identifier: Apache-2.0
/// @file bounded_collapse.h
/// Collapses edges as long as the surfaces before and after stay near each other.
#pragma once

#include "decimation/halfedge_mesh.h"
#include "search/surface_search.h"
#include "vdbtools/base/monitor.h"

#include <cstdint>
#include <vector>

namespace vdbtools {

/// One point was moved onto another one.
struct Collapse {
  std::uint32_t from, to;
};

/// Collapses all edges that can be, the cheapest one first, by the quadric error [Garland and Heckbert, SIGGRAPH 1997].
/// The remaining points do not move, and what is left over of the mesh stays in it as deleted elements. The order is
/// deterministic, and closed 2-manifolds stay closed 2-manifolds.
///
/// What is tested of the surface before are samples: its points, and the midpoints of its edges and triangles. New
/// triangles are proved to be near it, unless they stay in the planes of those around.
/// @param mesh        of toHalfedges(@a before)
/// @param before      in units in which the bound is 1
/// @param search      searches @a before
/// @param tolerances  for each point, how far the samples at it may be from the surface afterwards
/// @param changed     the points whose tolerances are not those of the attempt before; all of them in the first one
/// @param history     the collapses of the attempt before, which are repeated where nothing has changed; receives those
/// of
///                    this one
/// @throw Interrupted
void collapseWithin(HalfedgeMesh& mesh, const Mesh& before, const SurfaceSearch& search,
                    const std::vector<float>& tolerances, std::vector<bool> changed, std::vector<Collapse>& history,
                    const Monitor& monitor);

}  // namespace vdbtools
