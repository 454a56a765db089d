// SPDX-License-Identifier: Apache-2.0
/// @file attribute_options.h
/// What the vertices of a fractal's mesh carry besides their positions, and its grids besides the distances
/// (docs/attributes.md).
#pragma once

#include "vdbtools/mesh/vertex_column.h"
#include "vdbtools/recipe/recipe_reader.h"
#include "vdbtools/render/field_colour.h"

#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

enum class PointAttribute {
  Cd,          ///< the colour, linear RGB
  Direction,   ///< of the map's first step: its versor without the dropped component
  Trap,        ///< the smallest modulus among the iterates, fractal space
  Iterations,  ///< the mean number of steps of the orbits just outside
  Depth,       ///< the distance from the target's surface, world units, negative inside
  Tau,         ///< the target's local thickness, world units
  Mask,        ///< the value of --mask
};

struct AttributeOptions {
  std::vector<PointAttribute> computed;  ///< each once, in the order of the columns
  std::optional<ColourChoice> colour;    ///< as it was given
  /// What the target's nearest point has: "uv", "Cd" for its painted colour, or names of vertex attributes.
  std::vector<std::string> transferred;

  bool empty() const { return computed.empty() && transferred.empty(); }
  bool has(PointAttribute attribute) const;
};

/// --attributes, --colour and --transfer.
std::vector<OptionSpec> attributeOptionSpecs();

/// @throw std::invalid_argument  naming the option and the value; two columns of one name among them
AttributeOptions parseAttributeOptions(const RecipeReader& reader);

/// What each vertex has: the columns that a mesh sink gets.
std::vector<VertexColumn> meshColumns(const AttributeOptions& options);

}  // namespace vdbtools
