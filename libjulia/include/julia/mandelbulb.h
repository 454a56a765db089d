// SPDX-License-Identifier: Apache-2.0
/// @file mandelbulb.h
/// Powers of triplex numbers, points of R^3 by their radius and two angles (White and Nylander; Barrallo 2010,
/// Expanding the Mandelbrot Set into Higher Dimensions; [ZB25] Eqs. 1 and 2):
///
///   p -> r^n (cos n phi cos n theta, sin n phi cos n theta, sin n theta) + c
///
/// phi is the angle about the z axis and theta that above the xy plane; for n = 2 this is pair A of cross_map.h without
/// its undefined points. The other convention, theta from the z axis, with sine and cosine of n theta exchanged, gives
/// other sets, among them the well-known Mandelbulb of power 8.
///
/// x = y = 0 means phi = 0, and p = 0 means theta = 0 also.
#pragma once

#include "julia/cartesian_map.h"
#include "julia/embedding.h"

#include <optional>

namespace julia {

enum class TriplexAngle {
  AbovePlane,  ///< from -pi/2 to pi/2, [ZB25]'s
  FromPole,    ///< from 0 to pi, [0 0 1] having 0
};

struct MandelbulbOptions {
  double power = 8;  ///< n, real, between -100 and 100; whole ones from 2 to 64 need no trigonometry
  TriplexAngle angle = TriplexAngle::AbovePlane;
  std::optional<Point> constant;  ///< c; none: the point where the orbit starts (Mandelbrot)
};

template <class Real>
class Mandelbulb final : public CartesianMap<Real> {
 public:
  /// @throw std::invalid_argument if the power is out of its range or the constant not finite
  explicit Mandelbulb(const MandelbulbOptions& options);

  int dimension() const override { return 3; }
  void begin(const QuaternionBatch<Real>& start, QuaternionBatch<Real>& carried,
             QuaternionBatch<Real>& next) const override;
  void step(const QuaternionBatch<Real>& p, const QuaternionBatch<Real>& carried,
            QuaternionBatch<Real>& next) const override;
  /// p^n.
  void direction(const QuaternionBatch<Real>& start, QuaternionBatch<Real>& direction) const override;
  /// For whole powers from 2 to 64.
  std::optional<Ball> imageOf(const Ball& ball, const Ball& start, int number) const override;

 private:
  template <class Constant>
  void power(const QuaternionBatch<Real>& p, const Constant& constant, QuaternionBatch<Real>& next) const;

  /// 0 if the power is not one that products make.
  int wholePower() const;

  double mPower;
  TriplexAngle mAngle;
  std::optional<Quaternion<Real>> mConstant;
};

extern template class Mandelbulb<float>;
extern template class Mandelbulb<double>;

/// A radius, at most the escape radius, outside of which every point has escaped after @a iterations: |p^n + c| >=
/// |p|^n - |c|. For n = 2 it serves all maps whose square is |p|^2 long: the pairs A, A' and D of cross_map.h in
/// schemes (4) and (5), and the Mandelbrot set of quadratic_map.h. For n < 2 it is the escape radius.
double triplexBound(const MandelbulbOptions& options, int iterations, double escapeRadius);

}  // namespace julia
