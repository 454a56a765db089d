// SPDX-License-Identifier: Apache-2.0
/// @file field_shading.h
/// Shades the points where rays meet the set: normals from the field, and colours from the map.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/render/field_render.h"

#include "julia/evaluator.h"

#include <optional>
#include <span>
#include <vector>

namespace vdbtools {

/// All in fractal space.
struct FieldHit {
  openvdb::Vec3d inside;                 ///< just behind the surface
  openvdb::Vec3d view;                   ///< the ray's direction, of length 1
  double step = 0;                       ///< the length of the ray's step there
  std::optional<openvdb::Vec3d> normal;  ///< set at the faces of the region, which cut the set
};

struct FieldPoint {
  openvdb::Vec3d normal;                 ///< outward, of length 1
  std::optional<openvdb::Vec3d> albedo;  ///< linear RGB; empty: the material's
};

/// What the field is around hits: kNeighbours numbers for each of them (neighbourhood.h).
struct FieldAround {
  std::vector<double> field;
  std::vector<int> iterations;
};
FieldAround fieldAround(const julia::FieldEvaluator& evaluator, std::span<const FieldHit> hits);

/// @param field, iterations  what the field is around these hits
std::vector<FieldPoint> fieldPoints(const julia::FieldEvaluator& evaluator, const FieldRenderOptions& options,
                                    std::span<const FieldHit> hits, std::span<const double> field,
                                    std::span<const int> iterations);

}  // namespace vdbtools
