// SPDX-License-Identifier: Apache-2.0
/// @file quadratic_map.h
/// q^2 + c: the quaternion Julia sets of [Nor82] and [HSK89], where c is fixed, and their Mandelbrot set, where c =
/// q_0. A point of R^3 is squared as the quaternion [x y z S], where S is the slice: the sets in three dimensions are
/// sections of those in four.
#pragma once

#include "julia/cartesian_map.h"
#include "julia/map.h"

namespace julia {

/// What describe() returns.
struct QuadraticDescription {
  std::optional<Quaternion<double>> constant;  ///< c; if empty, the point where the orbit starts (Mandelbrot)
};

/// The Julia sets: c is fixed.
template <class Real>
class QuadraticMap final : public Map<Real> {
 public:
  explicit QuadraticMap(const Quaternion<double>& c) : mConstant(c), mC(c.as<Real>()) {}

  void logModulus(const QuaternionBatch<Real>& q, std::span<Real> l) const override;
  void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const override;
  Real surfaceLevel(Real logEscape) const override { return logEscape; }
  MapDescription describe() const override { return QuadraticDescription{mConstant}; }
  void logModulusRanges(std::span<const Ball> balls, std::span<LogRange> l) const override;
  void images(std::span<const Ball> balls, std::span<const LogRange> l,
              std::span<std::optional<Ball>> images) const override;

 private:
  Ball valueOver(const Ball& ball) const;
  LogRange rangeOver(const Ball& ball) const;
  std::optional<Ball> imageOf(const Ball& ball, const LogRange& l) const;

  Quaternion<double> mConstant;
  Quaternion<Real> mC;  ///< the constant, rounded
};

extern template class QuadraticMap<float>;
extern template class QuadraticMap<double>;

/// The Mandelbrot set: c = q_0, including the slice. It consists of the c that keep the orbit of 0 bounded.
template <class Real>
class QuadraticMandelbrot final : public CartesianMap<Real> {
 public:
  int dimension() const override { return 4; }
  void begin(const QuaternionBatch<Real>& start, QuaternionBatch<Real>& carried,
             QuaternionBatch<Real>& next) const override;
  void step(const QuaternionBatch<Real>& q, const QuaternionBatch<Real>& carried,
            QuaternionBatch<Real>& next) const override;
  std::optional<Ball> imageOf(const Ball& ball, const Ball& start, int number) const override;
  MapDescription describe() const override { return QuadraticDescription{}; }
};

extern template class QuadraticMandelbrot<float>;
extern template class QuadraticMandelbrot<double>;

/// A radius outside of which every point has escaped after @a iterations steps with a fixed c: |q^2 + c| >= |q|^2 -
/// |c|, applied backwards from the escape radius.
double quadraticBound(const Quaternion<double>& c, int iterations, double escapeRadius);

}  // namespace julia
