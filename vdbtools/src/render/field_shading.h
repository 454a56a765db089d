// SPDX-License-Identifier: Apache-2.0
/// @file field_shading.h
/// Shades the points where rays meet the set: normals from the field, colours from the map, Phong's model.
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
  std::optional<openvdb::Vec3d> normal;  ///< known at the faces of the region, which cut the set
};

struct ShadedHit {
  openvdb::Vec3d normal;  ///< outward, of length 1
  openvdb::Vec3d colour;  ///< linear RGB
};

/// Directions to the lights, of length 1.
struct FieldLights {
  openvdb::Vec3d key, head;
};

/// @param shaded  as long as @a hits
void shadeHits(const julia::FieldEvaluator& evaluator, const FieldRenderOptions& options, const FieldLights& lights,
               std::span<const FieldHit> hits, std::span<ShadedHit> shaded);

}  // namespace vdbtools
