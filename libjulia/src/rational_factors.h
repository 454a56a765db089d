// SPDX-License-Identifier: Apache-2.0
/// @file rational_factors.h
/// The data of a RationalEvaluator.
#pragma once

#include "julia/rational.h"

#include "kernels/kernels.h"

#include <vector>

namespace julia {

/// The factors of a rational, in the order of multiplication. @param largest  receives the largest |power|
template <class Real>
std::vector<kernels::RootFactor<Real>> rootFactors(const Rational& rational, double& largest);

template <class Real>
struct RationalEvaluator<Real>::Factors {
  std::vector<kernels::RootFactor<Real>> roots;  ///< in the order of multiplication
  Real logScale;
  Rational rational;  ///< as it was given
};

}  // namespace julia
