// SPDX-License-Identifier: Apache-2.0
/// @file exponent_law.h
/// What phi becomes at a node before the shell is known: the exponent E itself, or, where a depth of detail is wanted,
/// the place w in the shell of detail that julia/detail.h makes an exponent of.
///
/// For detail D and outward reach O, as shares of the local thickness tau, and a mask m,
///
///   h = m (D + O) tau    the width of the shell
///   w = phi / h - O / (D + O)
///
/// so that w is -1 at phi = -m D tau and 0 at phi = m O tau. h is nowhere below kLeastShell voxels.
#pragma once

#include "vdbtools/exponent/exponent_grid.h"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

namespace vdbtools {

class ExponentLaw {
 public:
  /// @param voxel  of the target's distances, world units
  /// @throw std::invalid_argument  a control has values that it must not have
  ExponentLaw(const ExponentGridOptions& options, double scale, double voxel);

  /// @param points  world units
  /// @param values  phi there, world units; becomes E or w
  void apply(std::span<const openvdb::Vec3d> points, std::span<float> values) const;
  /// The same where it does not depend on the point.
  bool isUniform() const { return mAlpha && mBeta; }
  float uniform(float phi) const { return static_cast<float>(*mAlpha * (phi / mScale - *mBeta)); }

  /// An upper bound of it wherever phi is @a phi or less, world units.
  double greatestInside(double phi) const;
  /// The ranges of alpha and beta: those given, or those that E = ln(escape) + scale w amounts to.
  std::pair<std::pair<double, double>, std::pair<double, double>> ranges(std::optional<double> scale) const;

 private:
  const ExponentGridOptions& mOptions;
  double mScale;
  std::optional<double> mAlpha, mBeta;     ///< where neither they nor the mask vary
  double mLeastShell;                      ///< of h, world units
  double mMostShell = 0, mMostInward = 0;  ///< of h and m D tau, world units
};

}  // namespace vdbtools
