// SPDX-License-Identifier: Apache-2.0
/// @file versor_options.h
/// The versor of the shape modulus as a recipe describes it: a texture, roots, waves, a formula, a field of directions
/// or a program's own function; and two of them in layers, with a symmetry.
#pragma once

#include "vdbtools/maps/direction_grids.h"
#include "vdbtools/maps/map_descriptor.h"
#include "vdbtools/maps/map_options.h"

#include "julia/moved_versor.h"

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdbtools {

/// A formula of three or four components.
struct VersorFormula {
  std::string text;
  std::vector<std::string> components;
  std::vector<std::string> names;  ///< of the variables in it, each once
};

/// A versor as one option names it: exactly one of these.
struct VersorSource {
  std::string option;   ///< without dashes, for errors
  RootsSettings roots;  ///< a texture or roots, unless there is one of the others; and how each of them is placed
  std::optional<VersorFormula> formula;  ///< expr:A,B,C[,D]
  /// field:FILE.vdb[:GRIDS]
  struct Field {
    NamedFile file;
    std::vector<std::string> grids;
  };
  std::optional<Field> field;
  std::optional<NamedFile> waves;  ///< waves:FILE.json
  bool isFunction = false;         ///< the program's own

  bool isRoots() const { return !formula && !field && !waves && !isFunction; }
  bool followsGrain() const { return waves || (isRoots() && roots.texture); }
  bool followsThickness() const { return waves || (isRoots() && roots.texture && roots.texture->followsThickness()); }
};

struct VersorSettings {
  VersorSource under;
  std::optional<VersorSource> over;         ///< mixed over it
  ControlSetting mix;                       ///< how much of it, where there is one
  std::optional<GrainSettings> grain{};     ///< that the layers follow which can
  std::optional<julia::Symmetry> symmetry;  ///< of each; its centre is the middle of the target
};

/// Whether the value of --texture is neither a texture nor roots: a formula, a field, waves of a file, or a function.
bool isDirections(const std::string& versor);
/// Whether the value is a texture of waves, of the shelf or of a file.
bool followsThickness(const std::string& versor);

/// Whether the value is a texture that can follow a grain: one of the shelf, or waves of a file.
bool followsGrain(const std::string& versor);

/// --texture-over, --texture-over-seed, --texture-over-frequency, --texture-mix and --texture-symmetry.
std::vector<OptionSpec> layerOptions();

/// @param hasFunction  whether the program has one of its own for "function"
/// @throw std::invalid_argument  naming the option
VersorSettings parseVersor(const RecipeReader& reader, bool hasFunction);

std::vector<NamedFile> filesOf(const VersorSettings& settings);
/// The names of the five grids of a grain, in the order of julia::GrainField. @param control  the name of its
/// MapControl
std::vector<std::string> grainGridNames(const std::string& control);
/// The names of the grids that a control becomes.
std::vector<std::string> gridNames(const MapControl& control);
/// The controls that are read where the map is evaluated.
std::vector<MapControl> controlsOf(const VersorSettings& settings);
/// @throw as readRoots() and readDirectionGrids()
MapFiles readFiles(const VersorSettings& settings);

}  // namespace vdbtools
