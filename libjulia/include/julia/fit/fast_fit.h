// SPDX-License-Identifier: Apache-2.0
/// @file fast_fit.h
/// The fit that the log-polar form makes possible (DESIGN.md 2.6). With the roots fixed, L is linear in the powers, so
/// a weighted logistic loss of its sign is convex: Newton's method, each step a quadratic program over powers >= 0,
/// finds its minimum in a few passes. Roots are added greedily, those whose power would lower the loss the most, and
/// dropped where their power comes to 0. The energy psi of [Kim15] then sharpens what was found.
///
/// A root inside the target is a top root and one outside a bottom root, so that no root leaves a bubble of its own on
/// the other side. The first top root lies at the origin, which should be inside, with a power of 2 or more: 0 stays
/// super-attracting. The summed powers of the top are held at least 2 above those of the
/// bottom, by a spring that gives a little: far away the map is steeper than q, and infinity attracts.
#pragma once

#include "julia/fit/shape_energy.h"

#include <cstdint>
#include <functional>
#include <string_view>

namespace julia {

/// A place where a root may be.
struct RootCandidate {
  Point x;  ///< units of the map's space
  enum class Side : std::uint8_t { Top, Bottom, Either } side = Side::Either;
};

/// Where a fit stands.
struct FitStep {
  std::string_view stage;  ///< "roots" or "energy"
  int index = 0;           ///< steps so far
  std::size_t roots = 0;
  double energy = 0;                   ///< what the stage lowers; loss or psi with its penalty
  double psi = 0;                      ///< Eq. 5 on the cells of the fit
  double iou = 0;                      ///< on the held-out cells
  const Rational* rational = nullptr;  ///< as it is now
  bool roundEnds = false;              ///< with a new set of roots, or a sharper energy, to come
};

struct FastFitOptions {
  std::size_t maxRoots = 331;  ///< on both sides together, the origin's too
  double targetIou = 1;        ///< stops adding roots when the held-out cells reach it
  double cellSize = 0;         ///< edge of the smallest cell, units of the map's space, > 0
  CellWeights weights = CellWeights::InverseDistance;
  double powerPenalty = 0;                         ///< see ShapeEnergyOptions
  std::size_t memoryLimit = std::size_t{2} << 30;  ///< bytes for logs
  std::uint64_t seed = 1;                          ///< which cells are held out, and the order of the rest
  std::vector<Point> start;  ///< roots to begin with, such as monopoles; the greedy choice adds to them
  std::function<void(const FitStep&)> onStep;
  std::function<bool()> cancelled;
};

struct FastFit {
  Rational rational;
  double iou = 0;  ///< on the held-out cells
  double psi = 0;
  int steps = 0;
};

/// @param cells       of both sides, near the surface finer; a tenth of them is held out
/// @param candidates  enough to choose from: ten a root; without any, the first roots are all
/// @throw std::invalid_argument  no cell inside or none outside, numbers that are not finite, options out of their
///                               domain
/// @throw Cancelled
FastFit fastFit(std::span<const FitCell> cells, std::span<const RootCandidate> candidates,
                const FastFitOptions& options);

}  // namespace julia
