// SPDX-License-Identifier: Apache-2.0
/// @file map_descriptor.h
/// The room `maps` contains the maps that the program iterates. Everything that is peculiar to one map is in one file,
/// and jobs refer to no map by its name. The room uses the rooms up to `render`.
///
/// A map goes through three stages, each of them a class to derive from:
///
///   MapDescriptor   what the map is: its name, its options, what it needs
///   MapSettings     the map's part of a recipe: values and names of files, before any file is read
///   MapInstance     the map in a scene, with its target and the content of its files: makes the evaluators
///
/// To add a map, derive from these three classes, and add the descriptor to a MapRegistry (map_registry.h).
/// samples/own_map.cpp does so outside the library.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/control/control.h"
#include "vdbtools/exponent/exponent_grid.h"
#include "vdbtools/exponent/local_thickness.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/formats/versor_file.h"
#include "vdbtools/maps/direction_grids.h"
#include "vdbtools/maps/grain_options.h"
#include "vdbtools/recipe/option_table.h"
#include "vdbtools/recipe/recipe_reader.h"

#include "julia/device/device.h"
#include "julia/embedding.h"
#include "julia/evaluator.h"
#include "julia/orbit.h"
#include "julia/rational.h"

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

/// The arithmetic of an evaluator.
enum class Arithmetic { Float, Double };

/// The content of a map's files.
struct MapFiles {
  std::optional<RationalFile> roots;
  std::optional<RationalFile> overRoots{};                       ///< for the second layer of the texture
  std::optional<DirectionGrids> directions{}, overDirections{};  ///< instead of roots
  std::optional<WaveFile> waves{}, overWaves{};                  ///< likewise
  std::optional<openvdb::BBoxd> region{};  ///< where the map's set lies, world units, if a file says so
};

/// The parts of a scene that a map is made from.
struct MapContext {
  const MapFiles& files;
  const Target* target = nullptr;          ///< nullptr: none
  const FractalSpace& space;               ///< the space in which the map is iterated
  const FractalSpace& unmovedSpace;        ///< that space before its origin was moved; random roots are placed in it
  const ExponentGrid* exponent = nullptr;  ///< for a map with MapSettings::shell(); otherwise nullptr
  const OctaveGrid* octave = nullptr;      ///< for a map with MapSettings::frequency(); otherwise nullptr
  const ControlGrids* controls = nullptr;  ///< for MapSettings::controls(); nullptr if there are none
};

/// A control that a map reads at every point, by a name of its own.
struct MapControl {
  enum class Kind {
    Any,
    Share,      ///< from 0 to 1
    Frequency,  ///< the frequency of a texture, which the map receives as an octave (local_thickness.h)
    Grain,      ///< the frequency of a texture that follows a grain, which the map receives as the grids of GrainGrids
  };
  std::string name;    ///< letters, digits, underscores and dashes
  std::string option;  ///< without dashes, for errors
  ControlSetting control;
  Kind kind = Kind::Any;
  std::optional<GrainSettings> grain{};  ///< for Grain
};

/// The map in a scene. Immutable; it does not refer to the MapContext any more.
class MapInstance {
 public:
  virtual ~MapInstance() = default;

  /// @param orbit  with the trap that the scene's exponent proves, if there is an exponent
  virtual std::unique_ptr<julia::FieldEvaluator> evaluator(Arithmetic arithmetic,
                                                           const julia::OrbitOptions& orbit) const = 0;

  /// Whether 32-bit floats are as accurate as 64 bits for the map's powers and this number of steps. The caller decides
  /// whether they suffice for the size of the voxels. Also false for maps of which this has not been measured
  /// (docs/precision.md).
  virtual bool floatsServe(const julia::OrbitOptions& /*orbit*/) const { return false; }

  /// The roots of its versor or rational, as the evaluators have them; nullptr if it has none.
  virtual const julia::Rational* roots() const { return nullptr; }

  /// The seed of its random roots; none if they are not random.
  virtual std::optional<std::uint64_t> seed() const { return std::nullopt; }
  /// The same map with random roots from another seed, as settings with that seed would make it.
  /// @throw std::logic_error  there is no seed
  virtual std::shared_ptr<const MapInstance> reseeded(std::uint64_t seed) const;

  /// The facts about the map that files record in addition to the recipe, by the names of metadata.
  virtual std::map<std::string, std::string> metadata() const { return {}; }
};

/// The shell of a map whose values come from a target's exponent E: either alpha and beta, E = alpha (phi - beta), or
/// detail and outward, the fractions of the local thickness to which the shell reaches (exponent_grid.h). The other two
/// are not set.
struct ShellSettings {
  ControlSetting alpha, beta;
  ControlSetting detail, outward;
  ControlSetting mask;                                ///< always set
  std::optional<julia::Interpolation> interpolation;  ///< empty: chosen according to FractalOptions::picture

  /// Those of the five controls that are set.
  std::vector<ControlSetting> controls() const;

  bool operator==(const ShellSettings&) const = default;
};

/// A map as a recipe describes it. Immutable.
class MapSettings {
 public:
  MapSettings(const julia::OrbitOptions& orbit, const julia::Embedding& embedding)
      : mOrbit(orbit), mEmbedding(embedding) {}
  virtual ~MapSettings() = default;

  const julia::OrbitOptions& orbit() const { return mOrbit; }
  const julia::Embedding& embedding() const { return mEmbedding; }

  /// The files whose content the map depends on.
  virtual std::vector<NamedFile> files() const { return {}; }
  /// @throw DataError, MissingInputError, IoError, std::invalid_argument
  virtual MapFiles readFiles() const { return {}; }

  /// The shell of a map that is made from an exponent grid; nullptr for the others, which are evaluated in a region.
  virtual const ShellSettings* shell() const { return nullptr; }
  /// For a map whose texture follows the target's local thickness, the number of features across that thickness;
  /// nullptr for the others.
  virtual const ControlSetting* frequency() const { return nullptr; }
  /// Other controls over the target that the map reads.
  virtual std::vector<MapControl> controls() const { return {}; }
  /// How deep inside the target the map needs distances for anything but its shell, as a fraction of the target's
  /// longest side.
  virtual double interiorReach() const { return 0; }

  /// The radius, in fractal space, of a ball about the dynamics' origin that contains the whole set; empty if no such
  /// ball is known.
  virtual std::optional<double> radius() const { return std::nullopt; }

  /// How far the set is moved relative to the lattice, as a fraction of the tolerance. It serves maps that are
  /// exceptional on planes through the origin, on which no node may lie.
  virtual openvdb::Vec3d latticeShift() const { return openvdb::Vec3d(0); }

  /// @pre the context has what targetUse(), shell(), frequency() and controls() require
  virtual std::shared_ptr<const MapInstance> instance(const MapContext& context) const = 0;

 private:
  julia::OrbitOptions mOrbit;
  julia::Embedding mEmbedding;
};

enum class TargetUse { Needed, Optional, None };

/// What a map is. Immutable.
class MapDescriptor {
 public:
  virtual ~MapDescriptor() = default;

  virtual std::string name() const = 0;     ///< the value of --map
  virtual std::string summary() const = 0;  ///< one line
  /// A sentence for the documentation that says where the sign of F is proved without evaluating each node.
  virtual std::string proofs() const = 0;

  /// Its options, including those that it shares with other maps (map_options.h).
  virtual std::vector<OptionSpec> options() const = 0;
  virtual TargetUse targetUse() const = 0;
  /// Whether it has a versor that is made from roots.
  virtual bool hasRoots() const { return false; }
  virtual int dimension() const { return 4; }  ///< 4: quaternions; 3: points of R^3

  /// @throw std::invalid_argument  naming the option
  virtual std::shared_ptr<const MapSettings> parse(const RecipeReader& reader) const = 0;
};

/// Makes the evaluator of a map that exists in both arithmetics, on the current device if there is one.
/// @param makeMap  called as `makeMap.operator()<Real>()`
template <class MakeMap>
std::unique_ptr<julia::FieldEvaluator> makeEvaluator(Arithmetic arithmetic, const julia::Embedding& embedding,
                                                     const julia::OrbitOptions& orbit, const MakeMap& makeMap) {
  return julia::onCurrentDevice(
      arithmetic == Arithmetic::Float
          ? julia::makeFieldEvaluator<float>(makeMap.template operator()<float>(), embedding, orbit)
          : julia::makeFieldEvaluator<double>(makeMap.template operator()<double>(), embedding, orbit));
}

}  // namespace vdbtools
