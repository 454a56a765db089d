// SPDX-License-Identifier: Apache-2.0
/// @file dimension.h
/// How the mesh of a fractal grows with its resolution N: triangles = c N^D. D is the slope of log(triangles) over log
/// N, and an estimate of the fractal dimension of the surface, as in [KD20], who found 2.1868 for theirs. A smooth
/// surface has 2. After a finite number of iterations, every surface is smooth at small scales: where the voxels are
/// smaller than its finest detail, the slope falls back to 2. D therefore belongs to the range of N over which it was
/// measured.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/scene/fractal_options.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace vdbtools {

/// The range of the resolutions over which a dimension is measured, and their minimum number.
inline constexpr int kLeastGrowthResolution = 8, kMostGrowthResolution = 1'000'000;
inline constexpr std::size_t kLeastGrowthRows = 3;

/// The mesh of a fractal at one resolution.
struct GrowthRow {
  int resolution = 0;  ///< voxels along the longest side, as in the option
  std::uint64_t triangles = 0, points = 0, evaluatedNodes = 0;
};

/// Makes the mesh at each of these resolutions, and counts and discards it. The distances of the target stay those that
/// @a options ask for.
/// @throw what makeScene() and runFractal() throw
std::vector<GrowthRow> measureGrowth(FractalOptions options, std::span<const int> resolutions, Monitor& monitor);

/// y = factor x^exponent, fitted by least squares of the logarithms.
struct PowerLaw {
  double factor = 0, exponent = 0;
  double standardError = 0;  ///< of the exponent
  /// The 95 % interval of the exponent, by Student's t with two degrees of freedom less than there are points.
  std::pair<double, double> interval{0, 0};
};

/// @throw std::invalid_argument  fewer than three points, a number that is not above 0, or the same x for all points
PowerLaw fitPowerLaw(std::span<const std::pair<double, double>> points);

/// The power law of the number of triangles over the resolution.
PowerLaw growthLaw(std::span<const GrowthRow> rows);

}  // namespace vdbtools
