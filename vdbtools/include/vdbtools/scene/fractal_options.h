// SPDX-License-Identifier: Apache-2.0
/// @file fractal_options.h
/// The options of `juliavdb fractal` as values: a part for each room that the job goes through. Text is read here and
/// nowhere later; files are named, not yet opened.
#pragma once

#include "vdbtools/field/lattice_options.h"
#include "vdbtools/maps/map_registry.h"
#include "vdbtools/motion/motion_options.h"
#include "vdbtools/recipe/recipe.h"
#include "vdbtools/scene/attribute_options.h"
#include "vdbtools/scene/file_axes.h"
#include "vdbtools/surface/surface_options.h"
#include "vdbtools/target/space_options.h"
#include "vdbtools/target/target_input.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

enum class Precision { Auto, Float, Double };

/// The grids of a VDB, by the names "surface", "density", "logmodulus", "iterations" and "versor".
enum class OutputGrid { Surface, Density, LogModulus, Iterations, Versor };

/// What is made of the field.
struct OutputOptions {
  std::vector<OutputGrid> grids{OutputGrid::Surface};  ///< each once, in the order of the file
  bool half = false;                                   ///< 16-bit floats in the VDB
  FileAxes axes;
  std::vector<double> levels{};  ///< of detail in a GLB besides the mesh itself: shares of its triangles, falling
  AttributeOptions attributes;   ///< of the mesh and, by the same names, of the VDB
  GridNames gridNames{};         ///< of both kinds of grids, in a file of grids
};

struct FractalOptions {
  std::optional<TargetOptions> target;
  std::optional<RestOptions> rest{};          ///< where its points are at rest; none: the target does not move
  std::optional<VelocityOptions> velocity{};  ///< if velocities are wanted
  SpaceOptions space;
  std::shared_ptr<const MapSettings> map;
  LatticeOptions lattice;
  SurfaceOptions surface;
  OutputOptions output;
  Precision precision = Precision::Auto;
  /// Whether `--sampling auto` is quadratic, as for pictures of the set itself: the eye sees creases of the distances
  /// that voxels hide. parseFractalOptions() leaves it off; see forPictures().
  bool picture = false;
};

/// The options that affect the result, --map among them with those of each of the maps.
OptionTable fractalOptionTable(const MapRegistry& maps = builtInMaps());

/// @throw std::invalid_argument naming the option and the value
FractalOptions parseFractalOptions(const Recipe& recipe, const MapRegistry& maps = builtInMaps());

/// The same options for pictures of the set itself: `picture` is on where `--sampling auto` decides something.
FractalOptions forPictures(FractalOptions options);

/// The options of the same fractal about the target at rest: FractalOptions::rest is its target. Options without it
/// stay as they are. @throw as targetAtRest()
FractalOptions optionsAtRest(FractalOptions options);

/// Whether crumbs are dropped; for Crumbs::Auto the map decides.
bool dropsCrumbs(const FractalOptions& options);
/// Whether islands are looked for, to drop some.
bool dropsIslands(const FractalOptions& options);

/// @throw std::invalid_argument  there is no target, and the map makes its fractal around one; or velocities are
///                               wanted, and nothing says how it moves
void requireTarget(const FractalOptions& options);

}  // namespace vdbtools
