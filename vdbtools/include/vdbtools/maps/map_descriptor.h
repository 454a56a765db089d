// SPDX-License-Identifier: Apache-2.0
/// @file map_descriptor.h
/// The room `maps` holds the maps that the program iterates: everything that is peculiar to one map stands in the one
/// file of that map, and the jobs know none of them by name. It may use all rooms but job.
///
/// A map goes through three stages, each of them a class to derive from:
///
///   MapDescriptor   what the map is: its name, its options, what it needs
///   MapSettings     what a recipe says of it: values and names of files, nothing read yet
///   MapInstance     the map in a scene, over its target and from its files: makes the evaluators
///
/// To add a map, write these three, and add the descriptor to a MapRegistry (map_registry.h). samples/own_map.cpp does
/// that from outside of the library.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/control/control_grid.h"
#include "vdbtools/exponent/exponent_grid.h"
#include "vdbtools/exponent/octave_grid.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/formats/versor_file.h"
#include "vdbtools/maps/direction_grids.h"
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

/// What a map's files hold.
struct MapFiles {
  std::optional<RationalFile> roots;
  std::optional<RationalFile> overRoots{};                       ///< of the layer over these
  std::optional<DirectionGrids> directions{}, overDirections{};  ///< instead of roots
  std::optional<WaveFile> waves{}, overWaves{};                  ///< likewise
  std::optional<openvdb::BBoxd> region{};  ///< where the map's set lies, world units, if a file says so
};

/// The parts of a scene that a map is made from.
struct MapContext {
  const MapFiles& files;
  const Target* target = nullptr;          ///< nullptr: none
  const FractalSpace& space;               ///< where the map lives
  const FractalSpace& unmovedSpace;        ///< the same before its origin was moved: where random roots are strewn
  const ExponentGrid* exponent = nullptr;  ///< of a map with MapSettings::shell(); else nullptr
  const OctaveGrid* octave = nullptr;      ///< of a map with MapSettings::frequency(); else nullptr
  const ControlGrids* controls = nullptr;  ///< those of MapSettings::controls(); nullptr: there are none
};

/// A control that a map reads at every point, by a name of its own.
struct MapControl {
  enum class Kind {
    Any,
    Share,      ///< from 0 to 1
    Frequency,  ///< of a texture: what the map gets is its octave (octave_grid.h)
  };
  std::string name;    ///< letters, digits, underscores and dashes
  std::string option;  ///< without dashes, for errors
  ControlSetting control;
  Kind kind = Kind::Any;
};

/// The map in a scene. Immutable; what it needs of the context it has taken.
class MapInstance {
 public:
  virtual ~MapInstance() = default;

  /// @param orbit  with the trap that the scene's exponent proves, if there is an exponent
  virtual std::unique_ptr<julia::FieldEvaluator> evaluator(Arithmetic arithmetic,
                                                           const julia::OrbitOptions& orbit) const = 0;

  /// Whether 32-bit floats are as good as 64, as far as the map's powers and the number of steps go. What the size of
  /// the voxels has to say is left to the caller. False also where nobody has measured it (docs/precision.md).
  virtual bool floatsServe(const julia::OrbitOptions& /*orbit*/) const { return false; }

  /// The roots of its versor or rational, as the evaluators have them; nullptr if it has none.
  virtual const julia::Rational* roots() const { return nullptr; }

  /// The seed of its random roots; none if they are not random.
  virtual std::optional<std::uint64_t> seed() const { return std::nullopt; }
  /// The same map with the random roots of another seed, as settings with that seed would make it.
  /// @throw std::logic_error  there is no seed
  virtual std::shared_ptr<const MapInstance> reseeded(std::uint64_t seed) const;

  /// The facts about it that files record besides the recipe, by the names of metadata.
  virtual std::map<std::string, std::string> metadata() const { return {}; }
};

/// The shell of a map whose values come from a target's exponent E: either alpha and beta, E = alpha (phi - beta), or
/// detail and outward, the shares of the local thickness that it is to reach to (exponent_grid.h). The others of the
/// four are not there.
struct ShellSettings {
  ControlSetting alpha, beta;
  ControlSetting detail, outward;
  ControlSetting mask;                                ///< always there
  std::optional<julia::Interpolation> interpolation;  ///< none: as FractalOptions::picture needs it

  /// Those of the five that are there.
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

  /// Of a map that is made from an exponent grid; nullptr for the others, which are evaluated in a region.
  virtual const ShellSettings* shell() const { return nullptr; }
  /// Of a map whose texture follows the target's local thickness: the number of its features across that; nullptr for
  /// the others.
  virtual const ControlSetting* frequency() const { return nullptr; }
  /// Other controls over the target that it reads.
  virtual std::vector<MapControl> controls() const { return {}; }
  /// How deep inside the target the map must know distances for other reasons, as a share of its longest side.
  virtual double interiorReach() const { return 0; }

  /// A ball about the dynamics' origin in which the whole set lies, by its radius in fractal space; none if no such
  /// ball is known.
  virtual std::optional<double> radius() const { return std::nullopt; }

  /// How far the set is moved against the lattice, as a share of the tolerance: for maps that are special on planes
  /// through the origin, where no node is to lie.
  virtual openvdb::Vec3d latticeShift() const { return openvdb::Vec3d(0); }

  /// @pre the context has what TargetUse and shell() promise
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

  virtual std::string name() const = 0;     ///< as --map has it
  virtual std::string summary() const = 0;  ///< one line
  /// Where its set's sign is proved without evaluating each node: a sentence for the documentation.
  virtual std::string proofs() const = 0;

  /// Its options, those that it shares with other maps among them (map_options.h).
  virtual std::vector<OptionSpec> options() const = 0;
  virtual TargetUse targetUse() const = 0;
  /// Whether its values have a versor that roots make.
  virtual bool hasRoots() const { return false; }
  virtual int dimension() const { return 4; }  ///< 4: quaternions; 3: points of R^3

  /// @throw std::invalid_argument  naming the option
  virtual std::shared_ptr<const MapSettings> parse(const RecipeReader& reader) const = 0;
};

/// Makes the evaluator of a map that both arithmetics have, on the current device if there is one. @param makeMap
/// called as `makeMap.operator()<Real>()`
template <class MakeMap>
std::unique_ptr<julia::FieldEvaluator> makeEvaluator(Arithmetic arithmetic, const julia::Embedding& embedding,
                                                     const julia::OrbitOptions& orbit, const MakeMap& makeMap) {
  return julia::onCurrentDevice(
      arithmetic == Arithmetic::Float
          ? julia::makeFieldEvaluator<float>(makeMap.template operator()<float>(), embedding, orbit)
          : julia::makeFieldEvaluator<double>(makeMap.template operator()<double>(), embedding, orbit));
}

}  // namespace vdbtools
