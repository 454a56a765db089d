// SPDX-License-Identifier: Apache-2.0
/// @file decimate.h
/// Fewer triangles for the same shape, by OpenMesh.
#pragma once

#include "vdbtools/mesh/mesh.h"

#include <cstddef>

namespace vdbtools {

/// Collapses edges: first those shorter than @a shortest (world units), which are slivers, then those that move the
/// surface least (quadric error), until no more than @a triangles are left or no edge can go without harm to the
/// topology. Long thin triangles and folds come only where nothing else is left to collapse, and edges of flat ones are
/// turned. Points that remain stay where they are. Closed 2-manifolds stay that; the order is deterministic.
/// @throw DataError  an edge of more than two triangles, or of two that run the same way; a point where sheets touch
Mesh decimated(const Mesh& mesh, std::size_t triangles, double shortest);

}  // namespace vdbtools
