// SPDX-License-Identifier: Apache-2.0
/// @file shape_energy.h
/// How well a rational map has the shape of a target: the energy of [Kim15] Eqs. 5-7 and 18,
///
///   psi = (1 / eta) sum over cells of -tanh(alpha L) W,   eta = sum |W|,   L = ln|R(x)|,
///
/// -1 for a perfect match, +1 for the opposite, never outside. W carries the sign of phi. By the log-polar form
/// L = C + tau sum T_i ln|x - t_i| - beta sum B_i ln|x - b_i| is linear in the powers, so the gradient needs none of
/// the ordered products of [Kim15] Appendix A (docs/fitting.md has the proof that it is the same).
#pragma once

#include "julia/embedding.h"
#include "julia/rational.h"

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace julia {

/// A place where the energy is summed.
struct FitCell {
  Point x;           ///< units of the map's space, in the slice 0
  float phi = 0;     ///< signed distance to the target there, the same units, negative inside
  float volume = 1;  ///< of what the cell stands for, in the smallest cells
};

std::vector<Point> pointsOf(std::span<const FitCell> cells);

/// Cells; nearer to the surface a cell is cut by it, and 1 / phi says nothing.
inline constexpr double kLeastDistance = 0.5;

enum class CellWeights {
  InverseDistance,  ///< W = volume / phi, |phi| taken as at least kLeastDistance: [Kim15] Eq. 6
  Layers,           ///< W = volume / layers of cells from the surface, each side summing to one half: the 2015 program
};

/// W of every cell, signed as phi. @param cellSize  edge of the smallest cell, units of the map's space
std::vector<double> cellWeights(std::span<const FitCell> cells, CellWeights kind, double cellSize);

struct RationalGradient {
  double logScale = 0, topScale = 0, bottomScale = 0;  ///< by C, tau, beta
  std::vector<double> top, bottom;                     ///< by the T_i, the B_i
};

struct ShapeEnergyOptions {
  double alpha = 1;         ///< sharpness of the step, > 0
  double powerPenalty = 0;  ///< times the summed powers is added to psi ([KD20] asks for small sums), >= 0
  std::size_t memoryLimit = std::size_t{2} << 30;  ///< bytes for logs; beyond it they are made anew each time
};

class ShapeEnergy {
 public:
  /// @param weights  W of every cell
  /// @param roots    where the roots are; its powers do not matter
  /// @throw std::invalid_argument  no cells, sizes that differ, numbers that are not finite, weights that are all 0,
  ///                               options out of their domain
  ShapeEnergy(std::span<const Point> cells, std::vector<double> weights, const Rational& roots,
              const ShapeEnergyOptions& options);
  ~ShapeEnergy();

  /// psi and the penalty. @param rational  powers and scales; its roots are where the constructor's are
  /// @param gradient  filled if not null
  /// @throw std::invalid_argument  not as many roots
  double evaluate(const Rational& rational, RationalGradient* gradient) const;

  /// L of every cell.
  void logModuli(const Rational& rational, std::span<double> l) const;

  const std::vector<double>& weights() const;
  /// Other W, for a reweighted pass. @throw as the constructor
  void setWeights(std::vector<double> weights);
  const ShapeEnergyOptions& options() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> mParts;
};

/// [Kim15] 4.5: W scaled in two regions of the target's inside, the well-captured one, inside the fractal too, and the
/// poorly-captured rest, so that the sums of |tanh(alpha L) W| over both are equal and their sum stays. Cells outside
/// keep theirs, and so do all if either region is empty.
/// @param fractalInside  whether a cell is inside the fractal
/// @pre all spans have one size
std::vector<double> reweighted(std::span<const double> weights, std::span<const double> l, double alpha,
                               std::span<const char> fractalInside);

}  // namespace julia
