// SPDX-License-Identifier: Apache-2.0
/// @file exterior_trace.h
/// openvdb::tools::traceExteriorBoundaries, instantiated once.
#pragma once

#include "vdbtools/base/grids.h"

namespace vdbtools {

/// Negates the values above 0.75 that a flood from outside reaches, from node to node along the axes, without passing a
/// value up to 0.75. Gaps between leaves are passed.
/// @param tree  squared distances, in voxels: leaves wherever a value is up to 0.75
void traceExterior(openvdb::FloatTree& tree);

}  // namespace vdbtools
