// SPDX-License-Identifier: Apache-2.0
/// @file fit_job.h
/// Fits a rational map to the shape of a target, from end to end: by the method of [Kim15], or by the fast fit of
/// docs/design.md 2.6.
#pragma once

#include "vdbtools/fit/fit_target.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh/mesh_sink.h"
#include "vdbtools/picture/plot.h"
#include "vdbtools/recipe/recipe.h"

#include "julia/fit/electrostatics.h"
#include "julia/fit/schedule.h"
#include "julia/fit/shape_energy.h"
#include "julia/rational.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace vdbtools::fit {

// How well a rational map fits a target: after one iteration (n = 1) by volume, by distance, and by the energy of
// [Kim15] Eq. 5; after more of them by volume.

/// Measured over the cells of the target's cube. A cell is inside the map if L = ln|R| < 0 at its centre, with slice 0
/// and k dropped.
struct FitMeasure {
  double iou = 0;                ///< cells inside both divided by cells inside either
  std::uint64_t wrongCells = 0;  ///< number of cells inside only one of the two
  /// Distances between the surface L = 0 within the cube and the target's, fractal space: the average of the mean
  /// distances in the two directions, and the maximum of either (Hausdorff). They are measured on the cells, so they
  /// are accurate to a fraction of a cell. Infinite if L is 0 nowhere.
  double meanDistance = 0, hausdorff = 0;
  /// (1/eta) sum -tanh(a L) W, W = 1/phi with |phi| at least half a cell, eta = sum |W|: -1 is a perfect fit.
  double psi = 0;
};

/// @param rational   the map, in fractal space
/// @param sharpness  a > 0
/// @throw std::invalid_argument  sharpness not positive, or as julia::requireFinite()
/// @throw Interrupted
FitMeasure measureFit(const FitTarget& target, const julia::Rational& rational, double sharpness, Monitor& monitor);

struct IteratedOptions {
  int iterations = 4;  ///< n, 1 or more; the escape radius is 20
  int every = 1;       ///< counts only every n-th cell along each axis, where n is this number: 1 / n^3 of all cells
};

/// FitMeasure::iou of the set after n iterations.
/// @throw std::invalid_argument  as julia::requireFinite()
/// @throw Interrupted
double iteratedIou(const FitTarget& target, const julia::Rational& rational, const IteratedOptions& options,
                   Monitor& monitor);

/// The number to add to C so that the set after n iterations has the largest IoU. A point inside the target stays in
/// the set only if its whole orbit stays inside, but the first step sends it to |R| < 1 in any direction, where the
/// shape may end sooner. A smaller C keeps orbits nearer to the middle, so that fewer points are lost, but it also lets
/// points from farther out into the set. The best balance is searched on some thousands of cells, to about 0.02.
/// @return 0 for n = 1, for which the map was fitted
/// @throw  as iteratedIou()
double scaleShift(const FitTarget& target, const julia::Rational& rational, int iterations, Monitor& monitor);

/// The options of `juliavdb fit` that affect its result.
OptionTable fitOptionTable();

enum class FitStart {
  BlueNoise,  ///< roots spread evenly on both sides of the surface
  Monopoles,  ///< roots where monopoles approximate the surface's electrostatic potential ([Kim15] 4.4)
};

/// A map that is meant for one iteration is also judged by its set after this many iterations.
inline constexpr int kScoredIterations = 4;

struct FitOptions {
  /// The number of iterations after which the set is judged.
  int scored() const { return iterations > 1 ? iterations : kScoredIterations; }

  FitTargetOptions target;
  std::size_t roots = 331;  ///< maximum number, on both sides together
  double targetIou = 1;     ///< the fast fit adds roots until the held-out cells reach this
  /// The passes of [Kim15]; if empty, the fast fit is used.
  std::vector<julia::FitPass> schedule;
  FitStart start = FitStart::BlueNoise;  ///< for the fast fit
  bool moveRoots = true;                 ///< whether the fast fit moves the roots
  double epsilon = 0.04;                 ///< relative residual of the monopoles
  julia::CellWeights weights = julia::CellWeights::InverseDistance;
  double powerPenalty = 0;  ///< see julia::ShapeEnergyOptions
  double alpha = 0;         ///< all powers and C are scaled until |grad L| is this near the surface; 0: no scaling
  int iterations = 3;       ///< the number of iterations for which C is chosen at the end (scaleShift())
  std::uint64_t seed = 1;
};

/// @throw std::invalid_argument
FitOptions parseFitOptions(const Recipe& recipe);

/// A line of the report, for an accepted step.
struct FitRow {
  std::string stage;                ///< "roots", "energy", or a pass such as "25(V)"
  int step = 0;                     ///< counts from 1, through all stages
  std::size_t top = 0, bottom = 0;  ///< numbers of roots
  double energy = 0;        ///< objective of the stage: the loss for "roots", else psi on its own cells and weights
  double psi = 0, iou = 0;  ///< with the paper's weights, on a sample of cells that is the same for all rows
  double topPowers = 0, bottomPowers = 0;
  double meanDistance = -1, hausdorff = -1;  ///< fractal space; -1 if they were not measured
  double seconds = 0;                        ///< since the start of the fit
};

struct FitResult {
  julia::Rational rational;
  FitTarget target;
  FitMeasure measure;     ///< on the cells of the cube, after one iteration and before C was shifted
  double scaleShift = 0;  ///< the number that was added to C (scaleShift())
  /// The result of iteratedIou() after FitOptions::scored() iterations.
  double iteratedIou = 0;
  double slope = 0;  ///< median of |L / phi| near the surface
  std::vector<FitRow> rows;
  std::size_t monopoles = 0;    ///< if electrostatics were used
  julia::SurfaceCharge charge;  ///< on the target's surface; without densities if electrostatics were not used
};

/// @param wantDistances  measures distances at the end of every round or pass, which takes about a second each
/// @throw std::invalid_argument, MissingInputError, Interrupted
/// @throw DataError  as makeFitTarget(), or no part of the target is inside the map that was found
FitResult runFit(const FitOptions& options, bool wantDistances, Monitor& monitor);

/// The rows as CSV, with a header line.
std::string fitReportCsv(std::span<const FitRow> rows);

/// psi by step as in [Kim15] Fig. 11: mapped from [-1, 1] to [0, 1], with a logarithmic axis.
Plot fitReportPlot(std::span<const FitRow> rows);

/// The fit as JSON (versor_file.h), with its placement in the world and a note of the command that reproduces it.
/// @param recipe  the requested options, completed
std::string fitToJson(const FitResult& fit, const Recipe& recipe);

/// The surface on which the roots are placed, with its electrostatic charge ([Kim15] Fig. 8), which is large on
/// protrusions and small in hollows.
struct ChargedSurface {
  Mesh mesh;                          ///< world units
  std::vector<VertexColumn> columns;  ///< the charge as a grey, black where there is none; and the charge itself
  std::vector<float> values;          ///< row by row; charges are per unit of area, 1 if spread evenly
};
/// @throw Interrupted
ChargedSurface chargedSurface(const FitResult& fit, Monitor& monitor);

/// The fit as an `.o3d`, with the fields that the format requires, on the cells of the target's cube.
/// @throw std::invalid_argument  e^C does not fit a double
std::string fitToO3d(const FitResult& fit, Monitor& monitor);

}  // namespace vdbtools::fit
