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
#include <utility>

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

/// A shell that follows the shape (julia/detail.h): every point with phi <= -D tau is in the set, and every point with
/// phi >= O tau is outside, where tau is the local thickness.
struct DetailOptions {
  Control detail{0.25};          ///< D, from 0 to 1
  Control outward{0.1};          ///< O, from 0 to 1
  Control thickness{1.0};        ///< tau, world units, > 0 (local_thickness.h)
  double greatestThickness = 1;  ///< of tau anywhere
  /// For which origin the promise holds, world units. With another one the set erodes.
  openvdb::Vec3d origin{0, 0, 0};
};

struct ExponentGridOptions {
  Control alpha{40.0};  ///< thinness of the shell, > 0 everywhere
  Control beta{0.0};    ///< offset of the shell, units of fractal space
  julia::OrbitOptions orbit{};
  julia::Interpolation interpolation = julia::Interpolation::Trilinear;
  Control mask{1.0};  ///< width of the shell as a share of what it is without, from 0, the plain target, to 1
  std::optional<DetailOptions> detail{};  ///< instead of alpha and beta
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
  std::optional<double> scale;  ///< K of julia/detail.h, where ExponentGridOptions::detail is
  /// alpha and beta over the target: as they were given, or as they would have to be for this E.
  std::pair<double, double> alphaRange, betaRange;
  julia::Interpolation interpolation = julia::Interpolation::Trilinear;
};

/// Nodes of phi that are needed beyond the reach below, voxels: those that are read about a point there.
inline constexpr double kExponentMargin = 7;

/// How far outside the surface E may stay below ln(escape): the band that phi needs there, units of fractal space. Of
/// alpha and beta.
double exteriorReach(const ExponentGridOptions& options);

/// How deep inside E may stay above -@a depth, the same units. Of alpha and beta.
double interiorReach(const ExponentGridOptions& options, double depth);

/// The same of a shell of detail: how far it reaches to either side, world units.
struct DetailReach {
  double outside = 0, inside = 0;
};
DetailReach detailReach(const ExponentGridOptions& options);

/// @pre extendBand() with space.scale times exteriorReach() and the whole inside, or a band as wide. A band that is
///      shallower inside serves where the result is not tooShallow.
/// @throw std::invalid_argument  alpha not positive, or not finite; a share that is not from 0 to 1; a detail for an
///                               origin that does not lie inside the target
ExponentGrid exponentGrid(const Target& target, const FractalSpace& space, const ExponentGridOptions& options,
                          Monitor& monitor);

/// E as the dynamics reads it, at points of fractal space. Copies the grid.
template <class Real>
std::shared_ptr<const julia::ScalarField<Real>> makeExponentField(const ExponentGrid& exponent);

extern template std::shared_ptr<const julia::ScalarField<float>> makeExponentField(const ExponentGrid&);
extern template std::shared_ptr<const julia::ScalarField<double>> makeExponentField(const ExponentGrid&);

}  // namespace vdbtools
