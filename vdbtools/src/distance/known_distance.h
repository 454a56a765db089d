// SPDX-License-Identifier: Apache-2.0
/// @file known_distance.h
/// Reads a narrow band only where it is known, so that a coarser level can replace it elsewhere.
#pragma once

#include "vdbtools/base/grids.h"

#include <openvdb/tree/ValueAccessor.h>

#include <optional>

namespace vdbtools {

/// For use by one thread. It is not registered with its tree, so creating one costs nothing; the tree must not change
/// meanwhile.
using BandAccessor = openvdb::tree::ValueAccessor<const openvdb::FloatTree, /*IsSafe=*/false>;

/// The trilinear value at @a index, in index space, if every node with a non-zero weight is known, i.e. active. At a
/// node and in a plane through nodes (both within 1e-6 voxels), the nodes beyond have zero weight, so a stored value of
/// the band is always read exactly, even on the band's rim.
std::optional<double> knownDistance(const BandAccessor& band, const openvdb::Vec3d& index);

}  // namespace vdbtools
