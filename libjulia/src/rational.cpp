// SPDX-License-Identifier: Apache-2.0
#include "julia/rational.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace julia {
namespace {

// Far beyond any use, and small enough that sums of powers times logarithms stay finite in 32 bits.
constexpr double kLargestNumber = 1e9;

void requireFinite(double value, const std::string& what) {
  if (!(std::abs(value) <= kLargestNumber))
    throw std::invalid_argument(what + " is " + std::to_string(value) + "; it must be a number between -1e9 and 1e9");
}

void requireFinite(const Polynomial& polynomial, const std::string& name) {
  requireFinite(polynomial.powerScale, "the power scale of the " + name + " polynomial");
  for (std::size_t i = 0; i < polynomial.roots.size(); ++i) {
    const std::string root = "of " + name + " root " + std::to_string(i);
    const Quaternion<double>& t = polynomial.roots[i].position;
    for (const double component : {t.a, t.b, t.c, t.d}) requireFinite(component, "a component " + root);
    requireFinite(polynomial.roots[i].power, "the power " + root);
    requireFinite(polynomial.roots[i].power * polynomial.powerScale, "the scaled power " + root);
  }
}

Polynomial concatenated(Polynomial left, const Polynomial& right) {
  const bool differ = left.powerScale != right.powerScale;
  if (differ) {
    for (Root& root : left.roots) root.power *= left.powerScale;
    left.powerScale = 1;
  }
  for (Root root : right.roots) {
    if (differ) root.power *= right.powerScale;
    left.roots.push_back(root);
  }
  return left;
}

}  // namespace

double summedPowers(const Polynomial& polynomial) {
  double sum = 0;
  for (const Root& root : polynomial.roots) sum += root.power;
  return sum * polynomial.powerScale;
}

Rational translated(Rational rational, const Quaternion<double>& offset) {
  for (Polynomial* polynomial : {&rational.top, &rational.bottom})
    for (Root& root : polynomial->roots) root.position = root.position + offset;
  return rational;
}

Rational scaled(Rational rational, double factor) {
  if (!std::isfinite(factor) || factor == 0)
    throw std::invalid_argument("the factor to scale roots by is " + std::to_string(factor) +
                                "; it must be finite and not 0");
  for (Polynomial* polynomial : {&rational.top, &rational.bottom})
    for (Root& root : polynomial->roots) root.position = root.position * factor;
  return rational;
}

Rational product(const Rational& left, const Rational& right) {
  return {left.logScale + right.logScale, concatenated(left.top, right.top), concatenated(left.bottom, right.bottom)};
}

void requireFinite(const Rational& rational) {
  requireFinite(rational.logScale, "the constant C of the rational");
  requireFinite(rational.top, "top");
  requireFinite(rational.bottom, "bottom");
}

template <class Real>
RationalEvaluator<Real>::RationalEvaluator(const Rational& rational) : mLogScale(static_cast<Real>(rational.logScale)) {
  requireFinite(rational);
  const auto append = [this](const Root& root, double power) {
    if (power == 0) return;
    const bool isInteger = power == std::floor(power);
    mFactors.push_back({root.position.as<Real>(), static_cast<Real>(power),
                        isInteger ? static_cast<std::int64_t>(power) : 0, isInteger});
  };
  for (const Root& root : rational.top.roots) append(root, root.power * rational.top.powerScale);
  // The inverse of an ordered product runs backwards.
  for (auto root = rational.bottom.roots.rbegin(); root != rational.bottom.roots.rend(); ++root)
    append(*root, -root->power * rational.bottom.powerScale);
}

template <class Real>
Real RationalEvaluator<Real>::logModulus(const Quaternion<Real>& q) const {
  Real sum = mLogScale;
  Real powersHit = 0;
  bool hit = false;
  for (const Factor& factor : mFactors) {
    const Real l = logNorm(q - factor.root);
    if (l == -std::numeric_limits<Real>::infinity()) {
      hit = true;
      powersHit += factor.power;
    } else {
      sum += factor.power * l;
    }
  }
  if (hit && powersHit != 0) return std::copysign(std::numeric_limits<Real>::infinity(), -powersHit);
  return sum;
}

template <class Real>
Quaternion<Real> RationalEvaluator<Real>::versor(const Quaternion<Real>& q) const {
  Quaternion<Real> u = Quaternion<Real>::one();
  for (const Factor& factor : mFactors) {
    const Quaternion<Real> difference = q - factor.root;
    if (difference == Quaternion<Real>{}) continue;
    const Quaternion<Real> direction = versorOf(difference);
    u = u * (factor.isInteger ? versorPower(direction, factor.integer) : versorPower(direction, factor.power));
  }
  return versorOf(u);
}

template class RationalEvaluator<float>;
template class RationalEvaluator<double>;

}  // namespace julia
