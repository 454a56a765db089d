// SPDX-License-Identifier: Apache-2.0
/// @file feature_sizes.h
/// Measures the details of a fractal that a lattice has to show, at places spread evenly over the target's surface. The
/// lattice of the result plays no part in this, so the sizes are valid for any lattice.
#pragma once

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/exponent/exponent_grid.h"

#include "julia/evaluator.h"

#include <optional>
#include <vector>

namespace vdbtools {

/// Sizes in ascending order, one for each measured place; world units.
class SortedSizes {
 public:
  SortedSizes() = default;
  explicit SortedSizes(std::vector<double> sizes);

  bool empty() const { return mSizes.empty(); }
  std::size_t count() const { return mSizes.size(); }
  /// The fraction of the places where the size is less than @a size, 0 to 1.
  double shareBelow(double size) const;
  /// The largest size that no more than @a share of the places are below.
  double quantile(double share) const;
  /// The same for the places where the size is above 0; 0 if there are none.
  double positiveQuantile(double share) const;

 private:
  std::vector<double> mSizes;
};

struct FeatureSizes {
  /// The width of the texture: the length over which the versor of the first step makes a whole turn in the direction
  /// in which it turns fastest; infinity where nothing turns. Places where the mask is 0 are left out.
  SortedSizes texture;
  /// For a shell of detail, the thickness of the guaranteed core (exponent_grid.h): L - 2 m D tau, where L is the
  /// length of a straight line through the target, and m D tau is taken in its middle. 0 where nothing is guaranteed,
  /// and infinity where it is more than 1/50 of the target's longest side.
  SortedSizes core;
  double area = 0;  ///< area of the target's surface within the box; world units squared
};

/// The maximum number of measured places.
inline constexpr std::size_t kMeasuredPlaces = 2048;

/// @param shell      the options from which the exponent was made
/// @param evaluator  of any arithmetic for which differences over 1/4096 of the target's longest side are well above
///                   the rounding of coordinates
/// @param space      the space of the evaluator
/// @param box        if given, only places in it, or up to a few voxels of the distances outside it, are measured;
///                   world units
FeatureSizes measureFeatureSizes(const Target& target, const ExponentGridOptions& shell,
                                 const julia::FieldEvaluator& evaluator, const FractalSpace& space,
                                 const std::optional<openvdb::BBoxd>& box, Monitor& monitor);

}  // namespace vdbtools
