// SPDX-License-Identifier: Apache-2.0
#include "julia/rational.h"

#include "batch_view.h"
#include "careful.h"
#include "number_text.h"
#include "rational_factors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace julia {
namespace {

// Far beyond any useful value, and small enough that sums of powers times logarithms stay finite in 32 bits.
constexpr double kLargestNumber = 1e9;

void requireFinite(double value, const std::string& what) {
  if (!(std::abs(value) <= kLargestNumber))
    throw std::invalid_argument(what + " is " + textOf(value) + "; it must be a number between -1e9 and 1e9");
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
    throw std::invalid_argument("the factor to scale roots by is " + textOf(factor) + "; it must be finite and not 0");
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

namespace {

using kernels::Ieee;
using kernels::PowerMethod;

// An estimated scale is off by up to 3.5 per cent for each factor. Norms of products may accumulate e to this, twice.
constexpr double kGuessedDrift = 0.035, kMostDrift = 20;
// The largest power with estimated scales: alone it drifts by at most e^2.3.
constexpr double kMostGuessed = 64;

template <class Real>
kernels::RootFactor<Real> makeFactor(const Root& root, double power) {
  kernels::RootFactor<Real> factor{};
  const Quaternion<Real> t = root.position.as<Real>();
  const Real components[4] = {t.a, t.b, t.c, t.d};
  std::copy(components, components + 4, factor.root);
  factor.power = static_cast<Real>(power);
  factor.method = PowerMethod::Angle;
  if (power == std::floor(power)) {
    factor.method = std::abs(power) <= kMostGuessed ? PowerMethod::Products : PowerMethod::ExactProducts;
    factor.integer = static_cast<std::uint32_t>(std::abs(power));
  }
  return factor;
}

/// Where the products of estimated scales must be renormalised to about 1.
template <class Real>
void planRenormalisations(std::vector<kernels::RootFactor<Real>>& factors) {
  double drift = 0;
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const auto driftOf = [](const kernels::RootFactor<Real>& factor) {
      return factor.method == PowerMethod::Products ? factor.integer * kGuessedDrift : 0.1;
    };
    drift += driftOf(factors[i]);
    if (i + 1 < factors.size() && drift + driftOf(factors[i + 1]) > kMostDrift) {
      factors[i].renormaliseAfterward = true;
      drift = kGuessedDrift;
    }
  }
}

/// Points passed to a kernel at a time, so that the unusual ones need no separate memory.
constexpr std::size_t kPiece = 512;

/// Whether the kernels are reliable at this point: none of their squares underflows or overflows.
template <class Real>
bool isOrdinary(const Quaternion<Real>& q, Real least) {
  return least >= Ieee<Real>::kTiny && normSquared(q) <= 1 / Ieee<Real>::kTiny;
}

template <class Real>
Quaternion<Real> differenceTo(const kernels::RootFactor<Real>& factor, const Quaternion<Real>& q) {
  return {q.a - factor.root[0], q.b - factor.root[1], q.c - factor.root[2], q.d - factor.root[3]};
}

/// u^p of a unit quaternion. A negative real has no direction of its own and uses i.
template <class Real>
Quaternion<Real> unitPower(const Quaternion<Real>& u, const kernels::RootFactor<Real>& factor) {
  if (factor.method != PowerMethod::Angle)
    return careful::versorPower(factor.power < 0 ? conjugate(u) : u, static_cast<std::int64_t>(factor.integer));
  Quaternion<Real> axis{Real(0), u.b, u.c, u.d};
  Real sinus = std::sqrt(u.b * u.b + u.c * u.c + u.d * u.d);
  if (!(sinus * sinus >= Ieee<Real>::kTiny)) {
    // The versor is so close to a real that squares underflow; the remaining components still determine the axis.
    axis = axis == Quaternion<Real>{} ? Quaternion<Real>{Real(0), Real(1), Real(0), Real(0)} : careful::versorOf(axis);
    sinus = std::sqrt(Ieee<Real>::kTiny);  // an angle below rounding
  } else {
    axis = axis * (1 / sinus);
  }
  Real inverse, sine, cosine;
  kernels::sineCosine(factor.power * kernels::angleInQuadrants(u.a, sinus, &inverse), &sine, &cosine);
  return {cosine, axis.b * sine, axis.c * sine, axis.d * sine};
}

QuaternionBatch<double> widened(const QuaternionBatch<float>& q) {
  return {{q.a.begin(), q.a.end()}, {q.b.begin(), q.b.end()}, {q.c.begin(), q.c.end()}, {q.d.begin(), q.d.end()}};
}

}  // namespace

template <class Real>
std::vector<kernels::RootFactor<Real>> rootFactors(const Rational& rational, double& largest) {
  std::vector<kernels::RootFactor<Real>> factors;
  largest = 0;
  const auto append = [&](const Root& root, double power) {
    if (power == 0) return;
    factors.push_back(makeFactor<Real>(root, power));
    largest = std::max(largest, std::abs(power));
  };
  for (const Root& root : rational.top.roots) append(root, root.power * rational.top.powerScale);
  // The factors of the inverse of an ordered product are in reverse order.
  for (auto root = rational.bottom.roots.rbegin(); root != rational.bottom.roots.rend(); ++root)
    append(*root, -root->power * rational.bottom.powerScale);
  planRenormalisations(factors);
  return factors;
}

template std::vector<kernels::RootFactor<float>> rootFactors(const Rational&, double&);
template std::vector<kernels::RootFactor<double>> rootFactors(const Rational&, double&);

template <class Real>
RationalEvaluator<Real>::RationalEvaluator(const Rational& rational) {
  requireFinite(rational);
  auto factors = std::make_shared<Factors>();
  factors->logScale = static_cast<Real>(rational.logScale);
  factors->rational = rational;
  double largest = 0;
  factors->roots = rootFactors<Real>(rational, largest);
  mFactors = std::move(factors);
  if (largest > Ieee<Real>::kLargestPower) mWide = std::make_shared<RationalEvaluator<double>>(rational);
}

template <class Real>
std::size_t RationalEvaluator<Real>::rootCount() const {
  return mFactors->roots.size();
}

template <class Real>
const Rational& RationalEvaluator<Real>::rational() const {
  return mFactors->rational;
}

template <class Real>
void RationalEvaluator<Real>::logModulus(const QuaternionBatch<Real>& q, std::span<Real> l) const {
  const auto& factors = *mFactors;
  std::array<Real, kPiece> least;
  for (std::size_t first = 0; first < q.size(); first += kPiece) {
    const std::size_t size = std::min(kPiece, q.size() - first);
    if (!kernels::kernels<Real>().logModulus(factors.roots.data(), factors.roots.size(), factors.logScale,
                                             view(q, first), l.data() + first, least.data(), size))
      continue;
    for (std::size_t i = 0; i < size; ++i)
      if (!isOrdinary(q.get(first + i), least[i])) l[first + i] = logModulus(q.get(first + i));
  }
}

template <class Real>
void RationalEvaluator<Real>::versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const {
  u.resize(q.size());
  if constexpr (std::is_same_v<Real, float>) {
    if (mWide) {
      QuaternionBatch<double> wide;
      mWide->versor(widened(q), wide);
      for (std::size_t i = 0; i < q.size(); ++i) u.set(i, wide.get(i).template as<Real>());
      return;
    }
  }
  const auto& roots = mFactors->roots;
  std::array<Real, kPiece> least;
  for (std::size_t first = 0; first < q.size(); first += kPiece) {
    const std::size_t size = std::min(kPiece, q.size() - first);
    if (!kernels::kernels<Real>().versor(roots.data(), roots.size(), view(q, first), view(u, first), least.data(),
                                         size))
      continue;
    for (std::size_t i = 0; i < size; ++i)
      if (!isOrdinary(q.get(first + i), least[i])) u.set(first + i, versor(q.get(first + i)));
  }
}

template <class Real>
Real RationalEvaluator<Real>::logModulus(const Quaternion<Real>& q) const {
  Real sum = mFactors->logScale;
  Real powersHit = 0;
  bool hit = false;
  for (const auto& factor : mFactors->roots) {
    const Quaternion<Real> difference = differenceTo(factor, q);
    if (difference == Quaternion<Real>{}) {
      hit = true;
      powersHit += factor.power;
      continue;
    }
    sum += factor.power * careful::logNorm(difference);
  }
  if (hit && powersHit != 0) return std::copysign(std::numeric_limits<Real>::infinity(), -powersHit);
  return sum;
}

template <class Real>
Quaternion<Real> RationalEvaluator<Real>::versor(const Quaternion<Real>& q) const {
  if constexpr (std::is_same_v<Real, float>)
    if (mWide) return mWide->versor(q.template as<double>()).template as<Real>();
  Quaternion<Real> u = Quaternion<Real>::one();
  for (const auto& factor : mFactors->roots) {
    const Quaternion<Real> difference = differenceTo(factor, q);
    if (difference == Quaternion<Real>{}) continue;
    u = u * unitPower(careful::versorOf(difference), factor);
  }
  return careful::versorOf(u);
}

template class RationalEvaluator<float>;
template class RationalEvaluator<double>;

}  // namespace julia
