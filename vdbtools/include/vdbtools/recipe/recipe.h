// SPDX-License-Identifier: Apache-2.0
/// @file recipe.h
/// What a run was asked to do, as text: option names and values, in the words of the command line. A recipe goes into
/// the metadata of what it made and comes back from there, so that a file says how to make it again.
///
/// The registry below is the one place that names an option, its default and its meaning; the command line and the
/// documentation take theirs from here.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/field/follow_surface.h"
#include "vdbtools/field/islands.h"
#include "vdbtools/target/control.h"

#include "julia/brick_field.h"
#include "julia/cross_map.h"
#include "julia/embedding.h"
#include "julia/mandelbulb.h"
#include "julia/orbit.h"
#include "julia/random_roots.h"

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdbtools {

/// Option name (without dashes in front) -> value. A flag that is set has the value "true".
using Recipe = std::map<std::string, std::string>;

enum class MapKind { ShapeModulus, Rational, Quadratic, Cross, Mandelbulb };

/// A set of maps, a bit each.
constexpr unsigned mapBit(MapKind map) { return 1u << static_cast<unsigned>(map); }
inline constexpr unsigned kEveryMap = ~0u;

struct OptionSpec {
  const char* name;
  const char* argument;      ///< what the help calls the value; nullptr: a flag
  const char* defaultValue;  ///< nullptr: none, or one that depends on the map
  const char* help;
  unsigned maps = kEveryMap;  ///< those that have the option; with any other it is refused
};

/// The options of each command that affect its result.
std::span<const OptionSpec> sdfOptionSpecs();
std::span<const OptionSpec> fractalOptionSpecs();
/// Of two options that say the same in two ways, the other one's name; "" if there is none.
std::string alternativeOption(const std::string& option);
/// The options of @a base that mean nothing any more when @a option gets another value: its alternative, and what
/// belongs to the map, scheme or pair that it had.
std::vector<std::string> displacedOptions(const Recipe& base, const std::string& option, const std::string& value);

/// "julia_" and the name with underscores: an identifier, as Houdini wants it.
std::string metadataName(const std::string& option);
/// A recipe's entries as metadata, with the tool's version and the command.
std::map<std::string, std::string> recipeToMetadata(const Recipe& recipe, const std::string& command);
/// What of @a metadata is a recipe, and of which command ("" if none).
std::pair<Recipe, std::string> recipeFromMetadata(const std::map<std::string, std::string>& metadata);
/// @a recipe with every option that has a default, with its map, and is not given: what is recorded does not change its
/// meaning when a later version has other defaults.
Recipe completeRecipe(Recipe recipe, std::span<const OptionSpec> specs);
/// The recipe in a VDB, PLY or OBJ that the program made. @throw DataError if there is none; MissingInputError
std::pair<Recipe, std::string> readRecipe(const std::filesystem::path& path);

/// The voxel size, given as such or as a number of voxels along the longest side.
struct VoxelChoice {
  std::optional<double> voxelSize;   ///< world units
  std::optional<double> resolution;  ///< one of the two is there

  /// @throw std::invalid_argument if that is not above 0
  double sizeFor(double longestSide) const;
};

struct SdfOptions {
  std::filesystem::path input;
  VoxelChoice voxels;
  bool repair = false;
  double gap = 0;   ///< world units; 0: found
  double band = 3;  ///< voxels on each side
  bool half = false;
};

enum class SpaceKind { Fit, World };
enum class Precision { Auto, Float, Double };

struct FractalOptions {
  std::filesystem::path input;  ///< empty: none
  std::string grid;             ///< which grid of a VDB input
  VoxelChoice voxels, sdfVoxels;
  bool repair = false;
  double gap = 0;
  MapKind map = MapKind::ShapeModulus;
  std::string alpha, beta;  ///< text of a Control, or a file name
  std::string versor;       ///< "random" or a file name
  julia::RandomRootsOptions randomRoots;
  double versorScale = 1;
  openvdb::Vec3d versorTranslate{0};
  julia::Quaternion<double> c{};  ///< of the quadratic Julia sets
  bool mandelbrot = false;        ///< of the quadratic map: c is the point
  julia::CrossOptions cross;
  julia::MandelbulbOptions mandelbulb;
  int iterations = 3;
  double escape = 20;  ///< or radius, as the cross-product maps and Mandelbulbs call it
  double slice = 0;
  openvdb::Vec3d origin{0};
  julia::DropAxis dropAxis = julia::DropAxis::K;
  SpaceKind space = SpaceKind::Fit;
  std::optional<openvdb::BBoxd> box;
  double tolerance = 1e-3;
  IslandOptions islands;
  bool cap = false;
  Precision precision = Precision::Auto;
  julia::Interpolation interpolation = julia::Interpolation::Trilinear;
  bool exhaustive = false;
  std::optional<FollowOptions> follow;  ///< if the surface is to be followed
  std::vector<std::string> grids;
  bool half = false;
  std::string sourceHash, versorHash;  ///< expected, if not empty
};

/// @throw std::invalid_argument naming the option and the value
SdfOptions parseSdfOptions(const Recipe& recipe);
FractalOptions parseFractalOptions(const Recipe& recipe);

/// The values of a list such as "0,1.5,-2". @throw std::invalid_argument unless there are @a count finite numbers
std::vector<double> parseNumbers(const std::string& option, const std::string& text, std::size_t count);
double parseNumber(const std::string& option, const std::string& text);

}  // namespace vdbtools
