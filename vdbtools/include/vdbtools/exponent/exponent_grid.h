// SPDX-License-Identifier: Apache-2.0
/// @file exponent_grid.h
/// The room `exponent` derives from distances what the shape modulus reads: the exponent, the local thickness and the
/// octave. It uses the rooms up to `control`.
///
/// This header declares the exponent E(x) = alpha(x) (phi(x) - beta(x)) of the shape modulus, computed once as a grid.
/// It contains all that the dynamics needs to know about the target. E < 0 inside, > 0 outside; phi and beta are in
/// units of fractal space.
///
/// E matters only in the open shell interval (docs/design.md 2.4). The grid holds v, from which E is computed when it
/// is read. A node has its true v if it is read for some place in a cell that touches that interval; elsewhere the grid
/// holds a constant beyond the nearer end of the interval.
#pragma once

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/control/control.h"
#include "vdbtools/distance/target.h"

#include "julia/brick_field.h"
#include "julia/orbit.h"
#include "julia/scalar_field.h"
#include "julia/shell.h"

#include <memory>
#include <optional>
#include <utility>

namespace vdbtools {

/// A shell that follows the shape (julia/detail.h): every point with phi <= -D tau is in the set, and every point with
/// phi >= O tau is outside, where tau is the local thickness.
struct DetailOptions {
  Control detail{0.25};          ///< D, from 0 to 1
  Control outward{0.1};          ///< O, from 0 to 1
  Control thickness{1.0};        ///< tau, world units, > 0 (local_thickness.h)
  double greatestThickness = 1;  ///< maximum of tau anywhere
  /// The origin for which the guarantee holds, world units. With another origin the set erodes.
  openvdb::Vec3d origin{0, 0, 0};
};

struct ExponentGridOptions {
  Control alpha{40.0};  ///< thinness of the shell, > 0 everywhere
  Control beta{0.0};    ///< offset of the shell, units of fractal space
  julia::OrbitOptions orbit{};
  julia::Interpolation interpolation = julia::Interpolation::Trilinear;
  Control mask{1.0};  ///< width of the shell as a fraction of its full width, from 0, the plain target, to 1
  std::optional<DetailOptions> detail{};  ///< instead of alpha and beta
};

struct ExponentGrid {
  openvdb::FloatGrid::Ptr grid;  ///< v on phi's nodes; tiles and the background have the sign of v
  FractalSpace space;
  julia::Knee knee;            ///< how E follows from v where it is read (julia/detail.h); none unless detail was given
  julia::ShellInterval shell;  ///< of E
  julia::ShellInterval shellOfNodes;  ///< the interval of v that corresponds to the interval of E in shell
  /// The orbit for which E was made, with the trap that the shell proves. An evaluator of E must use it.
  julia::OrbitOptions orbit;
  std::optional<openvdb::CoordBBox> denseBox;  ///< see Target
  /// Whether the target's distances end before E is as low as the shell's lower end; they must then be extended further
  /// inward.
  bool tooShallow = false;
  std::optional<double> scale;  ///< K of julia/detail.h, if ExponentGridOptions::detail was given
  /// alpha and beta over the target: as given, or the values that would result in this E.
  std::pair<double, double> alphaRange, betaRange;
  julia::Interpolation interpolation = julia::Interpolation::Trilinear;
};

/// The distance outside the surface up to which E may stay below ln(escape), and therefore the band that phi needs
/// there, units of fractal space. Follows from alpha and beta.
double exteriorReach(const ExponentGridOptions& options);

/// The depth up to which E may stay above -@a depth, units of fractal space. Follows from alpha and beta.
double interiorReach(const ExponentGridOptions& options, double depth);

/// How far a shell of detail reaches to either side, world units.
struct DetailReach {
  double outside = 0, inside = 0;
};
DetailReach detailReach(const ExponentGridOptions& options);

/// @pre extendBand() with space.scale times exteriorReach() and the whole inside, or an equally wide band. A band that
/// is shallower inside suffices if the result is not tooShallow.
/// @throw std::invalid_argument  alpha not positive, or not finite; a mask that is not from 0 to 1; a detail for an
///                               origin that does not lie inside the target
ExponentGrid exponentGrid(const Target& target, const FractalSpace& space, const ExponentGridOptions& options,
                          Monitor& monitor);

/// E in the form that the dynamics reads, at points of fractal space. Copies the grid.
template <class Real>
std::shared_ptr<const julia::ScalarField<Real>> makeExponentField(const ExponentGrid& exponent);

extern template std::shared_ptr<const julia::ScalarField<float>> makeExponentField(const ExponentGrid&);
extern template std::shared_ptr<const julia::ScalarField<double>> makeExponentField(const ExponentGrid&);

}  // namespace vdbtools
