// SPDX-License-Identifier: Apache-2.0
/// @file neighbourhood.h
/// The points around a point of the surface where the field's gradient and step counts are sampled.
#pragma once

#include "vdbtools/base/grids.h"

#include "julia/evaluator.h"

#include <array>
#include <span>
#include <vector>

namespace vdbtools {

/// Differences are taken along 13 axes: through the faces, edges and corners of a cube. If F jumps from one bound to
/// the other within a step, as it does on rough sets, three axes give only 26 different normals, and smooth faces
/// become facets.
inline constexpr std::size_t kAxes = 13, kNeighbours = 2 * kAxes;

/// The axes, of length 1.
const std::array<openvdb::Vec3d, kAxes>& neighbourAxes();

/// Each axis, and then the opposite direction, in turn.
const std::array<julia::Point, kNeighbours>& neighbourDirections();

/// The mean over those neighbours of one point that are outside; 0 if none is. Both spans have length kNeighbours.
double meanIterationsOutside(std::span<const double> field, std::span<const int> iterations);

}  // namespace vdbtools
