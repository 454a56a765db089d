// SPDX-License-Identifier: Apache-2.0
/// @file dimension.h
/// How the mesh of a fractal grows with its resolution N: triangles = c N^D. D is the slope of log(triangles) over
/// log N, and an estimate of the fractal dimension of the surface, as [KD20] have it for theirs (2.1868). A smooth
/// surface has 2. After a finite number of iterations every surface is smooth at last: where the voxels are smaller
/// than its finest detail, the slope falls back to 2, so D belongs to the range of N that it was measured over.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/scene/fractal_options.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace vdbtools {

/// The resolutions that a dimension is measured over, and how many there are at least.
inline constexpr int kLeastGrowthResolution = 8, kMostGrowthResolution = 1'000'000;
inline constexpr std::size_t kLeastGrowthRows = 3;

/// The mesh of a fractal at one resolution.
struct GrowthRow {
  int resolution = 0;  ///< voxels along the longest side, as the option says
  std::uint64_t triangles = 0, points = 0, evaluatedNodes = 0;
};

/// Makes the mesh at each of these resolutions and keeps nothing of it. The distances of the target stay those that
/// @a options say.
/// @throw what makeScene() and runFractal() throw
std::vector<GrowthRow> measureGrowth(FractalOptions options, std::span<const int> resolutions, Monitor& monitor);

/// y = factor x^exponent, by least squares of the logarithms.
struct PowerLaw {
  double factor = 0, exponent = 0;
  double standardError = 0;  ///< of the exponent
  std::pair<double, double> interval{0,
                                     0};  ///< of the exponent, 95 %, by Student's t with two degrees less than points
};

/// @throw std::invalid_argument  fewer than three points, one that is not above 0, or all at one x
PowerLaw fitPowerLaw(std::span<const std::pair<double, double>> points);

/// The law of the triangles over the resolution.
PowerLaw growthLaw(std::span<const GrowthRow> rows);

}  // namespace vdbtools
