// SPDX-License-Identifier: Apache-2.0
/// @file exponent_law.h
/// What phi is converted to at a node before the shell is known: the exponent E itself or, if a depth of detail is
/// requested, the position w in the shell of detail, from which julia/detail.h computes an exponent.
///
/// For detail D and outward reach O, as fractions of the local thickness tau, and a mask m,
///
///   h = 0.96 m (D + O) tau    the width of the shell, which leaves 2 % of m (D + O) tau free at each end
///   w = phi / h - (O / (D + O) - 0.02) / 0.96
///
/// so that w is -1 at phi = -m (D - 0.02 (D + O)) tau and 0 at phi = m (O - 0.02 (D + O)) tau. h is nowhere below
/// kLeastShell voxels.
#pragma once

#include "vdbtools/exponent/exponent_grid.h"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

namespace vdbtools {

class ExponentLaw {
 public:
  /// @param voxel  voxel size of the target's distances, world units
  /// @throw std::invalid_argument  a control has invalid values
  ExponentLaw(const ExponentGridOptions& options, double scale, double voxel);

  /// @param points  world units
  /// @param values  phi there, world units; becomes E or w
  void apply(std::span<const openvdb::Vec3d> points, std::span<float> values) const;
  /// The case in which the law does not depend on the point.
  bool isUniform() const { return mAlpha && mBeta; }
  float uniform(float phi) const { return static_cast<float>(*mAlpha * (phi / mScale - *mBeta)); }

  /// An upper bound of E or w wherever phi is @a phi or less, world units.
  double greatestInside(double phi) const;
  /// The ranges of alpha and beta: those given, or those that correspond to E = ln(escape) + scale w.
  std::pair<std::pair<double, double>, std::pair<double, double>> ranges(std::optional<double> scale) const;

 private:
  /// h. @param sum  D + O
  double shellHeight(double mask, double sum, double tau) const;

  const ExponentGridOptions& mOptions;
  double mScale;
  std::optional<double> mAlpha, mBeta;     ///< set if they are constant and the mask is too
  double mLeastShell;                      ///< minimum of h, world units
  double mMostShell = 0, mMostInward = 0;  ///< maxima of h and m D tau, world units
};

}  // namespace vdbtools
