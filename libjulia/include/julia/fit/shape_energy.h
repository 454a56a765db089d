// SPDX-License-Identifier: Apache-2.0
/// @file shape_energy.h
/// How well a rational map matches the shape of a target: the energy of [Kim15] Eqs. 5-7 and 18,
///
///   psi = (1 / eta) sum over cells of -tanh(alpha L) W,   eta = sum |W|,   L = ln|R(x)|,
///
/// which is -1 for a perfect match, +1 for the opposite, and never outside that interval. W has the sign of phi. In
/// log-polar form L = C + tau sum T_i ln|x - t_i| - beta sum B_i ln|x - b_i| is linear in the powers, so the gradient
/// does not need the ordered products of [Kim15] Appendix A (docs/fitting.md proves that it is the same).
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
  float volume = 1;  ///< the volume that the cell represents, in units of the smallest cell
};

std::vector<Point> pointsOf(std::span<const FitCell> cells);

/// In cells. The surface cuts cells nearer than this, and 1 / phi is meaningless there.
inline constexpr double kLeastDistance = 0.5;

enum class CellWeights {
  InverseDistance,  ///< W = volume / phi, with |phi| at least kLeastDistance: [Kim15] Eq. 6
  Layers,  ///< W = volume / layers of cells from the surface, where each side sums to one half, as in the program of
           ///< [Kim15]
};

/// W of every cell, with the sign of phi.
/// @param cells     where the energy is summed
/// @param kind      the definition of W
/// @param cellSize  edge of the smallest cell, units of the map's space
std::vector<double> cellWeights(std::span<const FitCell> cells, CellWeights kind, double cellSize);

struct RationalGradient {
  double logScale = 0, topScale = 0, bottomScale = 0;  ///< derivatives with respect to C, tau and beta
  std::vector<double> top, bottom;                     ///< derivatives with respect to the T_i and the B_i
  /// Derivatives with respect to the coordinates of the t_i and the b_i. Empty unless they are asked for.
  std::vector<Quaternion<double>> topPlaces, bottomPlaces;
};

enum class GradientOf {
  Powers,           ///< C, tau, beta and the powers
  PowersAndPlaces,  ///< the positions of the roots as well, which takes several times as long
};

struct ShapeEnergyOptions {
  double alpha = 1;         ///< sharpness of the step, > 0
  double powerPenalty = 0;  ///< this times the summed powers is added to psi ([KD20] asks for small sums), >= 0
  std::size_t memoryLimit = std::size_t{2} << 30;  ///< bytes for stored logarithms; others are recomputed each time
};

class ShapeEnergy {
 public:
  /// @param cells    where the energy is summed, units of the map's space
  /// @param weights  W of every cell
  /// @param roots    gives the positions of the roots, which only moveRoots() changes; its powers are ignored
  /// @param options  see ShapeEnergyOptions
  /// @throw std::invalid_argument  no cells, different sizes, numbers that are not finite, weights that are all 0, or
  ///                               options out of their domain
  ShapeEnergy(std::span<const Point> cells, std::vector<double> weights, const Rational& roots,
              const ShapeEnergyOptions& options);
  ~ShapeEnergy();

  /// The sum of psi and the penalty.
  /// @param rational  powers and scales; its roots must be those of the energy
  /// @param gradient  filled if not null
  /// @param of        which derivatives
  /// @throw std::invalid_argument  another number of roots
  double evaluate(const Rational& rational, RationalGradient* gradient, GradientOf of = GradientOf::Powers) const;

  /// Moves the roots of the energy. @throw std::invalid_argument  another number of roots, or one that is not finite
  void moveRoots(const Rational& roots);

  /// L of every cell.
  void logModuli(const Rational& rational, std::span<double> l) const;

  const std::vector<double>& weights() const;
  /// Replaces W, for a reweighted pass. @throw std::invalid_argument  as the constructor does
  void setWeights(std::vector<double> weights);
  const ShapeEnergyOptions& options() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> mParts;
};

/// [Kim15] 4.5: scales W separately in the two regions of the target's inside, the well-captured one (inside the
/// fractal too) and the poorly-captured rest, so that the sums of |tanh(alpha L) W| over both are equal and their total
/// is unchanged. Cells outside the target keep their weights, and so do all cells if either region is empty.
/// @param weights        W of every cell
/// @param l              L of every cell
/// @param alpha          the energy's sharpness
/// @param fractalInside  whether each cell is inside the fractal
/// @pre all spans have the same size
std::vector<double> reweighted(std::span<const double> weights, std::span<const double> l, double alpha,
                               std::span<const char> fractalInside);

}  // namespace julia
