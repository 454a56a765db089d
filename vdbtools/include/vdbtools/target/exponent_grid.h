// SPDX-License-Identifier: Apache-2.0
/// @file exponent_grid.h
/// The exponent E(x) = alpha(x) (phi(x) - beta(x)) of the shape modulus, baked once: all that the dynamics needs of the
/// target. E < 0 inside, > 0 outside; phi and beta in units of fractal space.
///
/// E matters in the open shell interval only (docs/design.md 2.4). The grid holds its true value at every node that is
/// read anywhere in a cell which touches that interval, and a constant beyond either end elsewhere.
#pragma once

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/target/control.h"

#include "julia/brick_field.h"
#include "julia/orbit.h"
#include "julia/scalar_field.h"
#include "julia/shell.h"

#include <memory>
#include <optional>

namespace vdbtools {

/// The target: phi, what is known of its extent, and whether it is known beyond.
struct Target {
  openvdb::FloatGrid::Ptr phi;  ///< world units, negative inside
  openvdb::BBoxd box;           ///< of the shape, world units
  /// The nodes of a dense field, index space. Beyond them phi is the nearest face's value. A narrow band has none: it
  /// is the tiles' and the background's there.
  std::optional<openvdb::CoordBBox> denseBox;
  std::optional<double> repairMoved{};  ///< how far a repair may have moved the surface, world units
};

/// Takes phi as it is: dense (every node of its active box is active) or narrow band. Active tiles are made voxels.
/// @param box  the shape's box where it is known better than from phi
/// @throw DataError  empty, not finite, without an inside, a background that is not positive in a narrow band
Target makeTarget(openvdb::FloatGrid::Ptr phi, std::optional<openvdb::BBoxd> box);

/// Widens the band of a narrow-band target, where it is narrower, to @a exteriorWidth and @a interiorWidth (world
/// units; infinity: over the whole inside), and kExponentMargin voxels further, by fast sweeping. Values of the band
/// stay as they are. A dense target stays as it is.
void extendBand(Target& target, double exteriorWidth, double interiorWidth, Monitor& monitor);

struct ExponentGridOptions {
  Control alpha{40.0};  ///< thinness of the shell, > 0 everywhere
  Control beta{0.0};    ///< offset of the shell, units of fractal space
  julia::OrbitOptions orbit{};
  julia::Interpolation interpolation = julia::Interpolation::Trilinear;
};

struct ExponentGrid {
  openvdb::FloatGrid::Ptr grid;  ///< E on phi's nodes; E's sign in every tile and in the background
  FractalSpace space;
  julia::ShellInterval shell;
  /// The orbit that it was made for, with the trap that the shell proves: what an evaluator of E is to be given.
  julia::OrbitOptions orbit;
  std::optional<openvdb::CoordBBox> denseBox;  ///< see Target
  /// The target's distances end before E is as low as the shell's lower end: they must be extended further inward.
  bool tooShallow = false;
  julia::Interpolation interpolation = julia::Interpolation::Trilinear;
};

/// Nodes of phi that are needed beyond the reach below, voxels: those that are read about a point there.
inline constexpr double kExponentMargin = 7;

/// How far outside the surface E may stay below ln(escape): the band that phi needs there, units of fractal space.
double exteriorReach(const ExponentGridOptions& options);

/// How deep inside E may stay above -@a depth, the same units.
double interiorReach(const ExponentGridOptions& options, double depth);

/// @pre extendBand() with space.scale times exteriorReach() and the whole inside, or a band as wide. A band that is
///      shallower inside serves where the result is not tooShallow.
/// @throw std::invalid_argument  alpha not positive, or not finite
ExponentGrid exponentGrid(const Target& target, const FractalSpace& space, const ExponentGridOptions& options,
                          Monitor& monitor);

/// E as the dynamics reads it, at points of fractal space. Copies the grid.
template <class Real>
std::shared_ptr<const julia::ScalarField<Real>> makeExponentField(const ExponentGrid& exponent);

extern template std::shared_ptr<const julia::ScalarField<float>> makeExponentField(const ExponentGrid&);
extern template std::shared_ptr<const julia::ScalarField<double>> makeExponentField(const ExponentGrid&);

}  // namespace vdbtools
