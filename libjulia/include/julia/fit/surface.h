// SPDX-License-Identifier: Apache-2.0
/// @file surface.h
/// The target's surface as the fitting of [Kim15] uses it: triangles, and points spread evenly over them.
#pragma once

#include "julia/embedding.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace julia {

struct TriangleSurface {
  std::vector<Point> points;  ///< units of the map's space
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// @throw std::invalid_argument naming the first index that does not belong to a point, or the first coordinate that is
///                              not between -1e9 and 1e9
void requireValid(const TriangleSurface& surface);

/// The summed area of the triangles, in squared units. Where triangles overlap, each counts.
/// @throw std::invalid_argument  as requireValid()
double area(const TriangleSurface& surface);

/// Blue noise: @a count points on the surface at nearly equal distances, by sample elimination [Yuksel, Sample
/// Elimination for Generating Poisson Disk Sample Sets, CGF 34(2), 2015]. Distances are measured in R^3, so two sheets
/// that lie close together count as one.
///
/// The order is progressive: every prefix is blue noise of fewer points. The same seed gives the same bytes everywhere.
/// @throw std::invalid_argument  as requireValid(), a surface without area, or a count that is not from 1 to 100000000
std::vector<Point> blueNoise(const TriangleSurface& surface, std::size_t count, std::uint64_t seed);

}  // namespace julia
