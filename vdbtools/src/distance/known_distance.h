// SPDX-License-Identifier: Apache-2.0
/// @file known_distance.h
/// Reading a narrow band where it is known, so that a coarser level can stand in elsewhere.
#pragma once

#include "vdbtools/base/grids.h"

#include <openvdb/tree/ValueAccessor.h>

#include <optional>

namespace vdbtools {

/// Of one thread. It is not registered with its tree, so making one costs nothing; the tree must not change meanwhile.
using BandAccessor = openvdb::tree::ValueAccessor<const openvdb::FloatTree, /*IsSafe=*/false>;

/// The trilinear value at @a index, in index space, if every node that has a weight is known, that is active. At a node
/// and in a plane through nodes (both within 1e-6 voxels), the nodes beyond have none: a value that the band holds is
/// what is read there, also on the band's rim.
std::optional<double> knownDistance(const BandAccessor& band, const openvdb::Vec3d& index);

}  // namespace vdbtools
