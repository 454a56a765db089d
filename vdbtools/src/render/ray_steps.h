// SPDX-License-Identifier: Apache-2.0
/// @file ray_steps.h
/// The spacing of the samples of the field renderer's rays.
#pragma once

#include "base/elementary.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/render/field_render.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace vdbtools {

/// The distances from the eye at which rays are sampled: one sequence for all rays, t_{k+1} = t_k + length(t_k). Some
/// of its members are stored, so that a ray that skips an interval finds its next sample without all the steps in
/// between.
class RaySteps {
 public:
  RaySteps(const Clarity& clarity, double pixel, double distance)
      : mAlpha(clarity.alpha.value_or(pixel * elementary::pow(distance, 1 - clarity.delta))),
        mDelta(clarity.delta),
        mEpsilon(clarity.epsilon) {}

  double alpha() const { return mAlpha; }
  int delta() const { return mDelta; }
  double epsilon() const { return mEpsilon; }
  /// The members that are stored, in their order; the first one is the sequence's first.
  std::span<const double> members() const { return mKept; }

  double length(double t) const {
    const double power = mDelta == 1 ? t : mDelta == 0 ? 1 : t * t;
    return std::max(mAlpha * power, mEpsilon);
  }

  /// Whether every step up to the distance @a t is long enough to survive rounding.
  bool servesUpTo(double t) const {
    constexpr double kLeast = 1e-14;  // of the distance
    // With delta 2, a step is the smallest fraction of the distance where it grows beyond epsilon.
    const double least = mDelta == 2 && mAlpha > 0 ? std::min(t, std::sqrt(mEpsilon / mAlpha)) : t;
    return length(least) >= kLeast * least;
  }

  /// Builds the sequence from @a first to beyond @a last, within the limit of servesUpTo().
  /// @throw Interrupted
  void lay(double first, double last, const Monitor& monitor) {
    constexpr std::size_t kMost = 1 << 15;  // fits in the second-level cache
    constexpr std::size_t kPerLook = 1 << 20;
    std::size_t stride = 1, count = 0;
    mKept.clear();
    for (double t = first;; t = next(t), ++count) {
      if (count % kPerLook == 0) monitor.throwIfCancelled();
      if (count % stride == 0) {
        if (mKept.size() == kMost) {
          for (std::size_t i = 0; i < kMost / 2; ++i) mKept[i] = mKept[2 * i];
          mKept.resize(kMost / 2);
          stride *= 2;
        }
        if (count % stride == 0) mKept.push_back(t);
      }
      if (t >= last) break;
    }
  }

  /// The member that follows a member of the sequence.
  double next(double t) const { return t + length(t); }

  /// The sequence's first member at or after @a place, and the one before it.
  struct Reached {
    double before, t;
  };
  /// @param place  greater than the first member of the sequence
  Reached reach(double place) const {
    double before = *(std::lower_bound(mKept.begin(), mKept.end(), place) - 1), t = next(before);
    while (t < place) {
      before = t;
      t = next(t);
    }
    return {before, t};
  }

 private:
  double mAlpha;
  int mDelta;
  double mEpsilon;
  std::vector<double> mKept;
};

}  // namespace vdbtools
