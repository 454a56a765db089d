// SPDX-License-Identifier: Apache-2.0
/// @file band_growth.h
/// How far extendBand() sweeps. What it makes of a target depends on this and on the target, so bands of different
/// widths may be one.
#pragma once

#include "vdbtools/distance/target.h"

#include <optional>

namespace vdbtools {

struct BandGrowth {
  int leaves = 0;  ///< layers of leaves that are added around those of the band
  bool wholeInside = false;

  bool operator==(const BandGrowth&) const = default;
};

/// None if the band is as wide as extendBand() would make it. @throw as extendBand()
std::optional<BandGrowth> bandGrowth(const Target& target, double exteriorWidth, double interiorWidth,
                                     Monitor& monitor);

/// What extendBand() does if bandGrowth() is this.
void growBand(Target& target, const BandGrowth& growth, Monitor& monitor);

/// Where the distances inside end and the solid begins, whose nodes say no more than that they are inside.
/// @return  the largest value of an active node that has an inactive negative neighbour; -inf: nowhere
float solidBeginsAt(const openvdb::FloatGrid& phi, Monitor& monitor);

}  // namespace vdbtools
