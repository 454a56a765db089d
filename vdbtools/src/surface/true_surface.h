// SPDX-License-Identifier: Apache-2.0
/// @file true_surface.h
/// Moves points of a mesh to the true surface F = 0 that the mesh approximates.
#pragma once

#include "search/spaced_points.h"
#include "vdbtools/field/fractal_field.h"

namespace vdbtools {

/// Moves each point along its normal, outward if F < 0 there and inward if not, to the nearest change of sign of F
/// found in steps of an eighth of @a reach, and marks it as lost if there is none within @a reach.
/// @param source     evaluates F; must outlive the result
/// @param reach      world units
/// @param tolerance  world units: F changes sign within this of the result
PointMover toTrueSurface(const FieldSource& source, double reach, double tolerance);

}  // namespace vdbtools
