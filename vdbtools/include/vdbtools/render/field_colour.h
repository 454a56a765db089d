// SPDX-License-Identifier: Apache-2.0
/// @file field_colour.h
/// How the points of a set are coloured, both in pictures of the set and at the vertices of its mesh.
#pragma once

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/control/control.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/picture/gradient.h"
#include "vdbtools/recipe/recipe_reader.h"

#include "julia/evaluator.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdbtools {

enum class FieldColour {
  Direction,   ///< the direction of the first step in R^3; with cross products f x g / |f x g|, as in [ZB25]
  Versor,      ///< the imaginary components of the same versor, as in slices
  Iterations,  ///< how many steps orbits just outside the surface take to escape
  Trap,        ///< how near the orbit comes to the origin
  Depth,       ///< the distance from the target's surface
  Clay,        ///< the same colour everywhere
};

/// What FieldColour::Depth needs to know about the target.
struct DepthColouring {
  Control distance;           ///< distance from the target's surface, world units, negative inside
  FractalSpace space;         ///< the space of the points
  double low = -1, high = 1;  ///< the distances at the two ends of the gradient, low < high
};

/// The numbers at the two ends of a gradient, low < high.
struct GradientRange {
  double low = 0, high = 1;

  bool operator==(const GradientRange&) const = default;
};

struct FieldColouring {
  FieldColouring(FieldColour what = FieldColour::Direction) : by(what) {}

  FieldColour by;
  Gradient gradient{};                    ///< for Iterations, Trap and Depth
  std::optional<DepthColouring> depth{};  ///< for Depth, which requires it
  /// The range of the gradient. If empty: 0 to 1 for Trap, 0 to the largest number of steps for Iterations, and the
  /// range of @a depth for Depth.
  std::optional<GradientRange> range{};
};

/// Properties of the evaluator that are needed to interpret its answers.
struct ColourContext {
  int maxIterations = 1;
  julia::DropAxis dropAxis = julia::DropAxis::K;
};

/// Returns the colours of points of fractal space, linear RGB. A point's colour does not depend on the others.
/// @param iterations  one for each point, as meanIterations() returns them; only FieldColour::Iterations reads them
std::vector<openvdb::Vec3d> fieldColours(const FieldColouring& colouring, const julia::FieldEvaluator& evaluator,
                                         const ColourContext& context, std::span<const julia::Point> points,
                                         std::span<const double> iterations);

/// Returns the numbers of Iterations, Trap and Depth that the gradient maps to colours; empty for other colourings.
std::vector<double> colourNumbers(const FieldColouring& colouring, const julia::FieldEvaluator& evaluator,
                                  std::span<const julia::Point> points, std::span<const double> iterations);

/// Returns the directions of the first step from points of fractal space, as FieldColour::Direction uses them.
std::vector<openvdb::Vec3s> firstDirections(const julia::FieldEvaluator& evaluator, julia::DropAxis dropAxis,
                                            std::span<const julia::Point> points);

/// Returns the smallest modulus among the iterates of each point, not counting the point itself.
std::vector<double> trapRadii(const julia::FieldEvaluator& evaluator, std::span<const julia::Point> points);

/// Returns for each point the mean number of steps of the orbits around it. Of the 26 points at the distance @a step
/// from it, the ones outside the set count; 0 if there are none. @param step  units of fractal space
std::vector<double> meanIterations(const julia::FieldEvaluator& evaluator, std::span<const julia::Point> points,
                                   double step);

/// The value of --colour, before any file is read.
struct ColourChoice {
  FieldColour by = FieldColour::Direction;
  std::string gradient{};                ///< the name of a gradient or a list of colours; empty: the default gradient
  std::optional<NamedFile> picture{};    ///< a picture whose first row is the gradient instead
  std::optional<GradientRange> range{};  ///< empty: the range of the numbers that occur
};

/// The option --colour; it has no default.
OptionSpec colourOptionSpec();
/// @throw std::invalid_argument naming the option and the value
std::optional<ColourChoice> parseColour(const RecipeReader& reader);

/// Returns the colouring without what the target and the set add. The first row of a picture runs from 0 at its left to
/// 1 at its right.
/// @throw MissingInputError, DataError, IoError  as when reading the picture
FieldColouring colouringOf(const ColourChoice& choice);

}  // namespace vdbtools
