// SPDX-License-Identifier: Apache-2.0
/// @file fast_fit.h
/// The fit that the log-polar form makes possible (docs/design.md 2.6). With the roots fixed, L is linear in the
/// powers, so a weighted logistic loss of its sign is convex. Newton's method, in which each step is a quadratic
/// program over powers >= 0, finds the minimum in a few passes. A greedy method adds the roots whose power would lower
/// the loss the most, and removes roots whose power falls to 0. The energy psi of [Kim15] then sharpens the result,
/// by the powers and the positions of the roots in turn.
///
/// A root inside the target is a top root and one outside it a bottom root, so that no root creates a bubble of its own
/// on the other side. The first top root lies at the origin, which should be inside the target, and has a power of 2 or
/// more, so that 0 stays super-attracting. A penalty with a little slack keeps the sum of the top powers at least 2
/// above that of the bottom powers: far away the map is then steeper than q, and infinity attracts.
#pragma once

#include "julia/fit/shape_energy.h"

#include <cstdint>
#include <functional>
#include <string_view>

namespace julia {

/// A place where a root may be put.
struct RootCandidate {
  Point x;  ///< units of the map's space
  enum class Side : std::uint8_t { Top, Bottom, Either } side = Side::Either;
};

/// The progress of a fit.
struct FitStep {
  std::string_view stage;  ///< "roots" or "energy"
  int index = 0;           ///< steps so far
  std::size_t roots = 0;
  double energy = 0;                   ///< what the stage lowers: the loss or psi, with the penalty
  double psi = 0;                      ///< Eq. 5 on the cells of the fit
  double iou = 0;                      ///< on the held-out cells
  const Rational* rational = nullptr;  ///< as it is now
  bool roundEnds = false;              ///< whether another set of roots, or a sharper energy, follows this step
};

struct FastFitOptions {
  std::size_t maxRoots = 331;  ///< on both sides together, including the root at the origin
  double targetIou = 1;        ///< adding roots stops when the held-out cells reach this
  double cellSize = 0;         ///< edge of the smallest cell, units of the map's space, > 0
  CellWeights weights = CellWeights::InverseDistance;
  double powerPenalty = 0;                         ///< see ShapeEnergyOptions
  bool moveRoots = true;                           ///< whether the roots move while the energy is lowered
  std::size_t memoryLimit = std::size_t{2} << 30;  ///< bytes for stored logarithms
  std::uint64_t seed = 1;                          ///< decides which cells are held out
  std::vector<Point> start;                        ///< initial roots, such as monopoles; the greedy choice adds to them
  std::function<void(const FitStep&)> onStep;
  std::function<bool()> cancelled;
};

struct FastFit {
  Rational rational;
  double iou = 0;  ///< on the held-out cells
  double psi = 0;
  int steps = 0;
};

/// Fits a rational to the cells of a target.
/// @param cells       cells on both sides, finer near the surface; a tenth of them is held out
/// @param candidates  ten for each root are enough; without any, the fit keeps to its initial roots
/// @param options     see FastFitOptions
/// @throw std::invalid_argument  no cell inside or none outside, numbers that are not finite, or options out of their
///                               domain
/// @throw Cancelled              options.cancelled returned true
FastFit fastFit(std::span<const FitCell> cells, std::span<const RootCandidate> candidates,
                const FastFitOptions& options);

}  // namespace julia
