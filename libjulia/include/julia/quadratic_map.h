// SPDX-License-Identifier: Apache-2.0
/// @file quadratic_map.h
/// q^2 + c: the quaternion Julia sets of Norton 1982 and [HSK89], c fixed; and their Mandelbrot set, c = q_0. A point
/// of R^3 is squared as the quaternion [x y z S], S the slice: the sets in three dimensions are sections of those in
/// four.
#pragma once

#include "julia/cartesian_map.h"
#include "julia/map.h"

namespace julia {

/// c fixed.
template <class Real>
class QuadraticMap final : public Map<Real> {
 public:
  explicit QuadraticMap(const Quaternion<double>& c) : mC(c.as<Real>()) {}

  void logModulus(const QuaternionBatch<Real>& q, std::span<Real> l) const override;
  void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const override;
  Real surfaceLevel(Real logEscape) const override { return logEscape; }
  void logModulusRanges(std::span<const Ball> balls, std::span<LogRange> l) const override;
  void images(std::span<const Ball> balls, std::span<const LogRange> l,
              std::span<std::optional<Ball>> images) const override;

 private:
  Ball valueOver(const Ball& ball) const;
  LogRange rangeOver(const Ball& ball) const;
  std::optional<Ball> imageOf(const Ball& ball, const LogRange& l) const;

  Quaternion<Real> mC;
};

extern template class QuadraticMap<float>;
extern template class QuadraticMap<double>;

/// c = q_0, slice included: which c keep the orbit of 0 bounded.
template <class Real>
class QuadraticMandelbrot final : public CartesianMap<Real> {
 public:
  int dimension() const override { return 4; }
  void begin(const QuaternionBatch<Real>& start, QuaternionBatch<Real>& carried,
             QuaternionBatch<Real>& next) const override;
  void step(const QuaternionBatch<Real>& q, const QuaternionBatch<Real>& carried,
            QuaternionBatch<Real>& next) const override;
  std::optional<Ball> imageOf(const Ball& ball, const Ball& start, int number) const override;
};

extern template class QuadraticMandelbrot<float>;
extern template class QuadraticMandelbrot<double>;

/// For c fixed: a radius outside of which every point has escaped after @a iterations: |q^2 + c| >= |q|^2 - |c|, run
/// backwards from the escape radius.
double quadraticBound(const Quaternion<double>& c, int iterations, double escapeRadius);

}  // namespace julia
