// SPDX-License-Identifier: Apache-2.0
/// @file evaluator.h
/// The seam between the dynamics and whoever fills grids and searches edges: points in, field values out.
#pragma once

#include "julia/ball.h"
#include "julia/cartesian_map.h"
#include "julia/embedding.h"
#include "julia/map.h"
#include "julia/orbit.h"

#include <algorithm>
#include <memory>
#include <span>

namespace julia {

/// Evaluates F. Const and free of state, so one evaluator serves many threads; a point's value does not depend on the
/// batch it came in.
class FieldEvaluator {
 public:
  virtual ~FieldEvaluator() = default;

  /// field[i] = F(points[i]), finite; iterations[i] = the number of steps taken, if iterations is not empty.
  virtual void evaluate(std::span<const Point> points, std::span<double> field, std::span<int> iterations) const = 0;

  /// 4, or 3 for a map of R^3.
  virtual int dimension() const { return 4; }

  /// versors[i] = f/|f| at points[i], of the map's first step; of a Cartesian map, what its direction() says.
  virtual void versors(std::span<const Point> points, std::span<Quaternion<double>> versors) const = 0;

  /// nearest[i] = ln of the smallest modulus among the iterates of points[i], its own apart: an orbit trap about 0.
  virtual void orbitTraps(std::span<const Point> points, std::span<double> nearest) const {
    evaluate(points, nearest, {});
  }

  /// out[i] = what is known of F's sign, as evaluate() computes it, at all points within @a radius of centres[i].
  /// Undecided says nothing; the other answers are proofs.
  virtual void decide(std::span<const Point> centres, double radius, std::span<Decision> out) const {
    (void)centres, (void)radius;
    std::fill(out.begin(), out.end(), Decision::Undecided);
  }
};

/// The one back end: batches through the vector kernels, in Real (float or double).
template <class Real>
std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const Map<Real>> map, const Embedding& embedding,
                                                   const OrbitOptions& options);

extern template std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const Map<float>>, const Embedding&,
                                                                   const OrbitOptions&);
extern template std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const Map<double>>, const Embedding&,
                                                                   const OrbitOptions&);

/// The same for a Cartesian map; what it can prove is what imageOf() knows. @throw std::invalid_argument if the
/// embedding has a slice or another dropped axis than k and the map is one of three dimensions.
template <class Real>
std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const CartesianMap<Real>> map,
                                                   const Embedding& embedding, const OrbitOptions& options);

extern template std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const CartesianMap<float>>,
                                                                   const Embedding&, const OrbitOptions&);
extern template std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const CartesianMap<double>>,
                                                                   const Embedding&, const OrbitOptions&);

}  // namespace julia
