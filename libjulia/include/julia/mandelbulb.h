// SPDX-License-Identifier: Apache-2.0
/// @file mandelbulb.h
/// Powers of triplex numbers, which are points of R^3 given by a radius and two angles (White and Nylander; Barrallo
/// 2010, Expanding the Mandelbrot Set into Higher Dimensions; [ZB25] Eqs. 1 and 2):
///
///   p -> r^n (cos n phi cos n theta, sin n phi cos n theta, sin n theta) + c
///
/// phi is the angle about the z axis and theta the angle above the xy plane; for n = 2 this is pair A of cross_map.h
/// without its undefined points. The other convention measures theta from the z axis and exchanges the sine and cosine
/// of n theta. It gives other sets, among them the well-known Mandelbulb of power 8.
///
/// x = y = 0 means phi = 0, and p = 0 means theta = 0 as well.
#pragma once

#include "julia/cartesian_map.h"
#include "julia/embedding.h"

#include <optional>

namespace julia {

enum class TriplexAngle {
  AbovePlane,  ///< from -pi/2 to pi/2, as in [ZB25]
  FromPole,    ///< from 0 to pi; 0 at [0 0 1]
};

struct MandelbulbOptions {
  double power = 8;  ///< n, a real number from -100 to 100; whole numbers from 2 to 64 need no trigonometry
  TriplexAngle angle = TriplexAngle::AbovePlane;
  std::optional<Point> constant;  ///< c; if empty, the point where the orbit starts (Mandelbrot)
};

/// The power of a triplex number if products compute it, which they do for whole powers from 2 to 64; otherwise 0.
int wholeTriplexPower(double power);

/// describe() returns the MandelbulbOptions.
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
  /// direction = p^n.
  void direction(const QuaternionBatch<Real>& start, QuaternionBatch<Real>& direction) const override;
  MapDescription describe() const override { return mOptions; }
  /// Empty unless the power is a whole number from 2 to 64.
  std::optional<Ball> imageOf(const Ball& ball, const Ball& start, int number) const override;

 private:
  template <class Constant>
  void power(const QuaternionBatch<Real>& p, const Constant& constant, QuaternionBatch<Real>& next) const;

  MandelbulbOptions mOptions;
  std::optional<Quaternion<Real>> mConstant;
};

extern template class Mandelbulb<float>;
extern template class Mandelbulb<double>;

/// A radius, at most the escape radius, outside of which every point has escaped after @a iterations steps, because
/// |p^n + c| >= |p|^n - |c|. For n = 2 it serves all maps whose square has the length |p|^2: the pairs A, A' and D of
/// cross_map.h in schemes (4) and (5), and the Mandelbrot set of quadratic_map.h. For n < 2 it is the escape radius.
double triplexBound(const MandelbulbOptions& options, int iterations, double escapeRadius);

}  // namespace julia
