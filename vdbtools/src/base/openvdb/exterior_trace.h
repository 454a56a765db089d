// SPDX-License-Identifier: Apache-2.0
/// @file exterior_trace.h
/// openvdb::tools::traceExteriorBoundaries, instantiated once.
#pragma once

#include "vdbtools/base/grids.h"

namespace vdbtools {

/// Negates all values above 0.75 that a flood from outside reaches, from node to node along the axes, without crossing
/// a value of at most 0.75. The flood crosses gaps between leaves.
/// @param tree  squared distances, in voxels; has leaves wherever a value is at most 0.75
void traceExterior(openvdb::FloatTree& tree);

}  // namespace vdbtools
