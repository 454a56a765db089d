// SPDX-License-Identifier: Apache-2.0
/// @file volume_levels.h
/// Makes level sets of grids of other kinds, and of grids with the opposite sign.
#pragma once

#include "distance/leaves.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"

#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tree/LeafManager.h>

namespace vdbtools {

/// The smallest and the largest value of a grid, including inactive ones and the background.
struct ValueRange {
  float least = 0, greatest = 0;
};
/// @throw DataError  a value that is not finite
ValueRange valueRange(const openvdb::FloatGrid& grid);

/// Whether all active nodes lie in one box that has no other nodes.
bool isDense(const openvdb::FloatGrid& grid);

/// Whether a narrow band is negative outside, where no node is active, instead of inside.
/// @throw DataError  no value is negative
bool isNegativeOutside(const openvdb::FloatGrid& grid);

/// A copy with the signs of all values reversed. Its background is positive.
openvdb::FloatGrid::Ptr withOtherSign(const openvdb::FloatGrid& grid);

/// The exact distances, in a narrow band, to the surface where a sampled field has the given value: a level set in
/// world units, with the sign that the field has at each node. It has the field's lattice. If the field's voxels
/// are not cubes, it has cubes of their smallest side, parallel to the axes of the world, and node 0 in the same place.
/// @param insideAbove  whether the inside is where the field is larger than the value, and not where it is smaller
/// @throw DataError  a value that is not finite, no such surface, an inside without an end, or more than 2^31 nodes
/// @throw MemoryError  they, or the surface, take more memory than is left
/// @throw Interrupted
openvdb::FloatGrid::Ptr levelSetOfVolume(const openvdb::FloatGrid& field, double isovalue, bool insideAbove,
                                         Monitor& monitor);

/// Makes distances negative inside, and gives every node beyond the band its side.
/// @param makeTest  makes, for one thread, the function that tells whether a node is inside
/// @throw Interrupted
template <class MakeTest>
void giveSigns(openvdb::FloatGrid& distances, Monitor& monitor, const MakeTest& makeTest) {
  openvdb::tree::LeafManager<openvdb::FloatTree> leaves(distances.tree());
  monitor.begin(PhaseKind::Signs, leaves.leafCount());
  forEachLeaf(leaves.leafCount(), monitor, [&](std::size_t i) {
    const auto isInside = makeTest();
    for (auto value = leaves.leaf(i).beginValueAll(); value; ++value)
      if (isInside(value.getCoord())) value.setValue(-*value);
  });
  const float width = distances.background();
  openvdb::tools::signedFloodFillWithValues(distances.tree(), width, -width);
}

}  // namespace vdbtools
