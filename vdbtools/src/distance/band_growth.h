// SPDX-License-Identifier: Apache-2.0
/// @file band_growth.h
/// How far extendBand() sweeps. The result depends only on this and on the target, so requests for different widths may
/// give the same band.
#pragma once

#include "vdbtools/distance/target.h"

#include <optional>

namespace vdbtools {

struct BandGrowth {
  int leaves = 0;  ///< layers of leaves added around the band's leaves
  bool wholeInside = false;

  bool operator==(const BandGrowth&) const = default;
};

/// Empty if the band is already as wide as extendBand() would make it. @throw as extendBand()
std::optional<BandGrowth> bandGrowth(const Target& target, double exteriorWidth, double interiorWidth,
                                     Monitor& monitor);

/// Does what extendBand() does for this result of bandGrowth().
void growBand(Target& target, const BandGrowth& growth, Monitor& monitor);

/// Finds where the known distances inside end and the solid begins, whose nodes are only known to be inside.
/// @return the largest value of an active node with an inactive negative neighbour; -inf: there is none
float solidBeginsAt(const openvdb::FloatGrid& phi, Monitor& monitor);

}  // namespace vdbtools
