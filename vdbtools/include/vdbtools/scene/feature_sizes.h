// SPDX-License-Identifier: Apache-2.0
/// @file feature_sizes.h
/// How large the details of a fractal are that a lattice is to show, measured at places spread evenly over the target's
/// surface. No lattice of the result takes part in this, so what is found holds for all of them.
#pragma once

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/exponent/exponent_grid.h"

#include "julia/evaluator.h"

#include <optional>
#include <vector>

namespace vdbtools {

/// Sizes at as many places, from the smallest; world units.
class SortedSizes {
 public:
  SortedSizes() = default;
  explicit SortedSizes(std::vector<double> sizes);

  bool empty() const { return mSizes.empty(); }
  std::size_t count() const { return mSizes.size(); }
  /// The share of the places where it is less than @a size, 0 to 1.
  double shareBelow(double size) const;
  /// The largest size that no more than @a share of the places are below.
  double quantile(double share) const;
  /// The same of the places where the size is above 0; 0 if there are none.
  double positiveQuantile(double share) const;

 private:
  std::vector<double> mSizes;
};

struct FeatureSizes {
  /// The width of the texture: the length over which the versor of the first step turns once, 2 pi, in the direction in
  /// which it turns fastest. Not where the mask is 0, and none where nothing turns.
  SortedSizes texture;
  /// Of a shell of detail, the thickness of the core that is promised (exponent_grid.h): where a straight line through
  /// the target is L long, L - 2 m D tau, with the m D tau of its middle. 0 where nothing is promised, and infinity
  /// where it is more than 1/50 of the target's longest side.
  SortedSizes core;
  double area = 0;  ///< of the target's surface, within the box; world units
};

/// The measured places, at most.
inline constexpr std::size_t kMeasuredPlaces = 2048;

/// @param shell      what the exponent was made with
/// @param evaluator  of any arithmetic for which differences over 1/4096 of the target's longest side are well above
///                   the rounding of coordinates
/// @param space      the evaluator's
/// @param box        world units; only places in it, and those a few voxels of the distances about it
FeatureSizes measureFeatureSizes(const Target& target, const ExponentGridOptions& shell,
                                 const julia::FieldEvaluator& evaluator, const FractalSpace& space,
                                 const std::optional<openvdb::BBoxd>& box, Monitor& monitor);

}  // namespace vdbtools
