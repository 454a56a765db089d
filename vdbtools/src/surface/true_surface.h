// SPDX-License-Identifier: Apache-2.0
/// @file true_surface.h
/// From points of a mesh to the true surface F = 0 that the mesh stands for.
#pragma once

#include "vdbtools/field/fractal_field.h"
#include "vdbtools/search/spaced_points.h"

namespace vdbtools {

/// Moves each point along its normal, outward if F < 0 there and inward if not, to the nearest change of sign of F that
/// is found in steps of an eighth of @a reach, and marks it as lost if there is none within @a reach.
/// @param source     of F; outlives the result
/// @param reach      world units
/// @param tolerance  world units: F changes sign within this of the result
PointMover toTrueSurface(const FieldSource& source, double reach, double tolerance);

}  // namespace vdbtools
