// SPDX-License-Identifier: Apache-2.0
/// @file control.h
/// The room `control` holds the settings that may vary over space. It uses the rooms up to `repair`.
///
/// Settings that may vary over space, as alpha and beta do ([SK23] 3.2, Fig. 7).
///
/// A *source* is what a recipe specifies: a number, a ramp over the target's box, a grid in a file. It is made where
/// the option is read, and keeps the option's text and file names. *Bound* to a target it becomes a control: a function
/// of world positions with bounds over boxes. A new kind of source takes one class behind ControlSource, one behind
/// ControlField, and one line in parseControl().
#pragma once

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/mesh/mesh.h"

#include "julia/scalar_field.h"

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace vdbtools {

class RecipeReader;

/// Values over world space. Evaluation is const and keeps no state that could pass from one call to another.
class ControlField {
 public:
  virtual ~ControlField() = default;

  /// Sets values[i] to the finite value at points[i], world units. Both spans have the same size.
  virtual void sample(std::span<const openvdb::Vec3d> points, std::span<double> values) const = 0;

  /// Bounds of all values.
  virtual std::pair<double, double> range() const = 0;

  /// The value, if it is the same everywhere.
  virtual std::optional<double> constant() const { return std::nullopt; }
};

/// A ramp from one value to another along an axis of the target's box; constant before and after.
struct Ramp {
  int axis = 0;                   ///< 0 X, 1 Y, 2 Z
  double from = 0, to = 0;        ///< the values
  double startAt = 0, endAt = 1;  ///< positions of the two values, as fractions of the target's box; startAt < endAt
  bool smooth = false;            ///< cubic 3t^2 - 2t^3 instead of linear, without a crease at either end
};

/// A control as a value.
class Control {
 public:
  Control(double value = 0);
  /// @throw std::invalid_argument  values not finite, or startAt >= endAt
  Control(const Ramp& ramp, const openvdb::BBoxd& targetBox);
  /// Reads the grid trilinearly, in its own world space. @throw DataError if a value is not finite
  explicit Control(openvdb::FloatGrid::ConstPtr grid);
  /// @pre not nullptr
  explicit Control(std::shared_ptr<const ControlField> field) : mField(std::move(field)) {}

  void sample(std::span<const openvdb::Vec3d> points, std::span<double> values) const {
    mField->sample(points, values);
  }
  double at(const openvdb::Vec3d& point) const;
  std::pair<double, double> range() const { return mField->range(); }
  std::optional<double> constant() const { return mField->constant(); }

 private:
  std::shared_ptr<const ControlField> mField;
};

/// The parts of the target that a source may refer to.
struct ControlContext {
  openvdb::BBoxd targetBox;            ///< world units
  std::shared_ptr<const Mesh> mesh{};  ///< the target as it was read, world units; nullptr if it was a VDB
  // For sources whose needsTarget() is true.
  FractalSpace space{};                ///< the space in which expressions have their coordinates
  openvdb::FloatGrid::ConstPtr phi{};  ///< the target's distances, world units
  /// Returns the local thickness, world units, which is computed on the first call.
  std::function<openvdb::FloatGrid::ConstPtr()> tau{};
};

/// A control as a recipe specifies it, before there is a target. Immutable.
class ControlSource {
 public:
  virtual ~ControlSource() = default;

  /// Its text in a recipe; parseControl() makes the same source from it.
  virtual std::string text() const = 0;
  /// The files on which its values depend.
  virtual std::vector<NamedFile> files() const { return {}; }
  /// Whether bind() needs more of the context than the box and the mesh, which are known before distances are computed.
  virtual bool needsTarget() const { return false; }
  /// @throw DataError, MissingInputError, IoError  as when reading its files
  virtual Control bind(const ControlContext& context) const = 0;
};

/// The source that an option of a recipe specifies, or none. Two are equal if a recipe has the same text for both; the
/// contents of their files may still differ.
class ControlSetting {
 public:
  ControlSetting() = default;
  ControlSetting(std::shared_ptr<const ControlSource> source) : mSource(std::move(source)) {}

  explicit operator bool() const { return mSource != nullptr; }
  const ControlSource* operator->() const { return mSource.get(); }
  const ControlSource& operator*() const { return *mSource; }
  bool operator==(const ControlSetting& other) const {
    return mSource && other.mSource ? mSource->text() == other.mSource->text() : mSource == other.mSource;
  }

 private:
  std::shared_ptr<const ControlSource> mSource;
};

/// A constant number. @param text  its text in a recipe
std::shared_ptr<const ControlSource> numberSource(double value, std::string text);

/// Makes the source that an option of a recipe describes:
///   - a number: "40"
///   - a ramp, "AXIS:FROM[@POS]:TO[@POS][:smooth]": "x:10:300:smooth" or "y:10@0.2:300@0.8"
///   - a grid: "FILE.vdb" or "FILE.vdb:GRID"
///   - a vertex attribute of the target's mesh or of another one: "paint:NAME[@FILE][:LOW:HIGH]". 0 becomes LOW and 1
///     becomes HIGH, linearly; without them the values stay unchanged.
///   - a picture through the texture coordinates of the target's mesh: "texture:FILE[:CHANNEL]:LOW:HIGH". v = 0 is the
///     picture's lowest row. CHANNEL is r, g, b, a or luminance.
///   - the distance to another mesh: "near:FILE:DISTANCE:NEAR:FAR". The value is NEAR on its surface, and inside if it
///     is closed, and FAR from DISTANCE on, a fraction of the target's longest side.
///   - an expression: "expr:TEXT" over x y z (fractal space), nx ny nz (the direction away from the surface), phi and
///     tau (fractions of the target's longest side), curvature (the mean curvature of the nearby surface, which is 1 /
///     r for a ball of radius r, with the longest side as unit), hx hy hz (0..1 along the sides of the target's box),
///     height (= hy) and the attributes of the target's mesh. It has the functions of julia/expression.h.
///
/// The last four are evaluated on a lattice of 100 nodes along the target's longest side, over its box and a tenth of
/// that side beyond, and read trilinearly. A value that is known only on a surface is extended: each point gets the
/// value of the nearest point of the surface. No path may contain a ':'.
/// @throw std::invalid_argument  names the option, the value and what is wrong with it
std::shared_ptr<const ControlSource> parseControl(const RecipeReader& reader, const std::string& option);

// A grid as a control; points outside its nodes get the value of the nearest node.

struct Target;

/// Reads the grid trilinearly, in its world space. Interpolation stays within the range of the values.
/// @param nodes  points outside them get the nearest node's value; empty: the tiles and the background apply there
/// @pre all values are finite
Control clampedControl(openvdb::FloatGrid::ConstPtr grid, const std::optional<openvdb::CoordBBox>& nodes);

/// The control of a grid that is active at every node of its box.
Control clampedControl(const openvdb::FloatGrid::ConstPtr& grid);

/// The distance from the target's surface, as far as it is known (distance/target.h).
Control distanceControl(const Target& target);

// Controls in the form that the dynamics reads: values on a lattice, at points of fractal space.

struct ControlGrid {
  openvdb::FloatGrid::Ptr grid;  ///< every node of its box is active
  FractalSpace space{};          ///< its world space is the grid's
};

/// Grids by the names that a map gives them.
using ControlGrids = std::map<std::string, ControlGrid>;

/// Samples a control on the lattice of 100 nodes along the target's longest side. The grid lies in fractal
/// space itself, so its own space is the identity.
/// @param space  the space of the map
ControlGrid controlGrid(const Control& control, const ControlContext& context, const FractalSpace& space);

/// Reads the grid trilinearly; a point outside the lattice gets the value of the nearest point of the lattice.
template <class Real>
std::shared_ptr<const julia::ScalarField<Real>> makeControlField(const ControlGrid& grid);

extern template std::shared_ptr<const julia::ScalarField<float>> makeControlField(const ControlGrid&);
extern template std::shared_ptr<const julia::ScalarField<double>> makeControlField(const ControlGrid&);

}  // namespace vdbtools
