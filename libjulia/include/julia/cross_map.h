// SPDX-License-Identifier: Apache-2.0
/// @file cross_map.h
/// The cross-product maps of R^3 of [ZB25] (Zimmermann & Bruckner 2025): two functions f and g of a point p, multiplied
/// as f(p) x g(p), in three schemes that are numbered like the paper's equations.
///
/// With p = (x, y, z), r = |p|, phi the angle about the z axis and theta the angle above the xy plane (Eq. 1), the
/// pairs are
///
///   A   f = r^2 (-sin 2phi, cos 2phi, 0)   g = (-sin 2theta / cos 2phi, 0, cos 2theta)
///   A'  f of A                             g = (+sin 2theta / cos 2phi, 0, cos 2theta)
///   B   f = (1, 1, 1)                      g = (cos x, cos y, cos z)
///   C   f = (x^2, y^2, z^2)                g of B
///   D   f of A                             g = (0, 0, 1)
///   E   f = (x^2 y, y^2, z^2)              g = (1, cos z, 1)
///
/// The sines and cosines of 2phi and 2theta are computed from the components. x = y = 0 means phi = 0, and p = 0 means
/// theta = 0 as well. A and A' are not defined where cos 2phi = 0, i.e. where |x| = |y| > 0: the orbit has escaped
/// there (F = 1e30).
///
/// The paper's i, default 10, is OrbitOptions::maxIterations: the largest number of cross products, including f(c) x
/// g(c) of scheme (3). Its r, default 2, is the escape radius: each iterate is tested after its step and has escaped if
/// |p| >= r; points that far out have escaped before any step.
#pragma once

#include "julia/cartesian_map.h"
#include "julia/embedding.h"

#include <memory>
#include <string>

namespace julia {

class ExpressionPair;

enum class CrossPair { A, APrime, B, C, D, E, User };

/// c is the point where the orbit starts.
enum class CrossScheme {
  FixedFactor,  ///< (3): p_0 = f(c) x g(c), p_{k+1} = p_k x g(c)
  Mandelbrot,   ///< (4): p_0 = c, p_{k+1} = f(p_k) x g(p_k) + c
  Julia,        ///< (5): p_0 = c, p_{k+1} = f(p_k) x g(p_k) + constant
};

struct CrossOptions {
  CrossPair pair = CrossPair::A;
  CrossScheme scheme = CrossScheme::Mandelbrot;
  Point constant{};  ///< for scheme (5); ignored by the other two
  std::string f, g;  ///< for the pair User, see expression_pair.h; ignored by the others
};

/// A cross-product map. Its direction(), by which [ZB25] colours, is f x g at the point. describe() returns the
/// CrossOptions.
template <class Real>
class CrossMap final : public CartesianMap<Real> {
 public:
  /// @throw std::invalid_argument if the constant is not finite, or under the conditions of ExpressionPair
  explicit CrossMap(const CrossOptions& options);

  int dimension() const override { return 3; }
  void begin(const QuaternionBatch<Real>& start, QuaternionBatch<Real>& carried,
             QuaternionBatch<Real>& next) const override;
  void step(const QuaternionBatch<Real>& p, const QuaternionBatch<Real>& carried,
            QuaternionBatch<Real>& next) const override;
  void direction(const QuaternionBatch<Real>& start, QuaternionBatch<Real>& direction) const override;
  MapDescription describe() const override { return mOptions; }
  /// Empty for the pair User, and for A and A' after the first step of scheme (3).
  std::optional<Ball> imageOf(const Ball& ball, const Ball& start, int number) const override;
  bool isDefinedEverywhere() const override;

 private:
  /// Sets next to f(p) x g(p) + constant, where the constant is one value for all orbits or one for each.
  template <class Constant>
  void multiply(const QuaternionBatch<Real>& p, const Constant& constant, QuaternionBatch<Real>& next) const;
  void second(const QuaternionBatch<Real>& p, QuaternionBatch<Real>& g) const;

  CrossOptions mOptions;
  Quaternion<Real> mConstant;
  std::shared_ptr<const ExpressionPair> mUser;  ///< for the pair User only
};

extern template class CrossMap<float>;
extern template class CrossMap<double>;

}  // namespace julia
