// SPDX-License-Identifier: Apache-2.0
/// @file attribute_options.h
/// What the vertices of a fractal's mesh carry besides their positions, and its grids besides the distances
/// (docs/attributes.md).
#pragma once

#include "vdbtools/mesh/mesh_sink.h"
#include "vdbtools/recipe/recipe_reader.h"
#include "vdbtools/render/field_colour.h"

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
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
  Velocity,    ///< of the target's surface that carries the point, world units per second
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

// The names that grids have in files, so that the volume shaders of other programs find them without being told.

/// The names that grids get in a file, by the program's own names; grids that are not listed keep theirs.
using GridNames = std::map<std::string, std::string>;

/// --grid-names: a program, or pairs such as trap=temperature, or both, with commas between them.
OptionSpec gridNamesOption();

/// @param text   the value of --grid-names; empty: all grids keep their names
/// @param grids  the grids that are made, by the program's own names
/// @param ofOthers  whether grids may have the names of one of the programs, as in a file that is read: such a name is
///                  replaced too, so that each program's names lead to those of every other
/// @throw std::invalid_argument  no such program; a pair for a grid that is not made; two grids that would have one
///                               name
GridNames parseGridNames(const std::string& text, std::span<const std::string> grids, bool ofOthers = false);

/// The metadata of a file in which the grid of distances called @a own has another name; empty if it has not.
std::map<std::string, std::string> distanceGridMetadata(const GridNames& names, const std::string& own);

}  // namespace vdbtools
