// SPDX-License-Identifier: Apache-2.0
#include "julia/fit/minimise.h"

#include "number_text.h"

#include "julia/fit/cancelled.h"

#include <LBFGSB.h>
#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace julia {
namespace {

using Eigen::VectorXd;

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

/// Converts between a rational and the optimiser's variables C, tau, beta, T_1..., B_1..., each divided by a unit.
struct PowerVariables {
  FitVariables kind;
  VectorXd units;

  Eigen::Index count(const Rational& rational) const {
    return 3 + (kind == FitVariables::Full
                    ? static_cast<Eigen::Index>(rational.top.roots.size() + rational.bottom.roots.size())
                    : 0);
  }

  template <class R, class Body>
  void forEach(R& rational, const Body& body) const {
    Eigen::Index i = 0;
    body(i++, rational.logScale);
    body(i++, rational.top.powerScale);
    body(i++, rational.bottom.powerScale);
    if (kind == FitVariables::Coarse) return;
    for (auto& root : rational.top.roots) body(i++, root.power);
    for (auto& root : rational.bottom.roots) body(i++, root.power);
  }

  VectorXd of(const Rational& rational) const {
    VectorXd x(count(rational));
    forEach(rational, [&](Eigen::Index i, double value) { x[i] = value / units[i]; });
    return x;
  }
  void assign(const VectorXd& x, Rational& rational) const {
    forEach(rational, [&](Eigen::Index i, double& value) { value = x[i] * units[i]; });
  }
  VectorXd gradient(const RationalGradient& by, const Rational& rational) const {
    VectorXd g(count(rational));
    g[0] = by.logScale;
    g[1] = by.topScale;
    g[2] = by.bottomScale;
    if (kind == FitVariables::Full) {
      std::copy(by.top.begin(), by.top.end(), g.data() + 3);
      std::copy(by.bottom.begin(), by.bottom.end(), g.data() + 3 + by.top.size());
    }
    return g.cwiseProduct(units);
  }
  /// The bounds.
  VectorXd low() const {
    VectorXd low = VectorXd::Zero(units.size());
    low[0] = -kUnbounded;
    return low;
  }
  VectorXd high() const { return VectorXd::Constant(units.size(), kUnbounded); }
};

/// The same for the positions of the roots: the moves of the three coordinates of each in its slice, divided by the
/// reach of the root.
struct PlaceVariables {
  std::vector<Quaternion<double>> start;  ///< top roots first
  std::span<const double> reach;

  VectorXd of(const Rational&) const { return VectorXd::Zero(3 * static_cast<Eigen::Index>(start.size())); }
  void assign(const VectorXd& x, Rational& rational) const {
    std::size_t j = 0;
    for (Polynomial* polynomial : {&rational.top, &rational.bottom})
      for (Root& root : polynomial->roots) {
        const auto move = x.segment<3>(3 * static_cast<Eigen::Index>(j)) * reach[j];
        root.position = start[j++] + Quaternion<double>{move[0], move[1], move[2], 0};
      }
  }
  VectorXd gradient(const RationalGradient& by, const Rational& rational) const {
    VectorXd g = of(rational);
    std::size_t j = 0;
    for (const auto* places : {&by.topPlaces, &by.bottomPlaces})
      for (const Quaternion<double>& place : *places) {
        g.segment<3>(3 * static_cast<Eigen::Index>(j)) << place.a * reach[j], place.b * reach[j], place.c * reach[j];
        ++j;
      }
    return g;
  }
  VectorXd low() const { return -high(); }
  VectorXd high() const { return VectorXd::Ones(3 * static_cast<Eigen::Index>(start.size())); }
};

/// Powers may be in the hundreds while tau and beta are about 1: the unit of a variable is about its own size.
VectorXd unitsOf(const Rational& rational, FitVariables kind) {
  const auto meanPower = [](const Polynomial& polynomial) {
    double sum = 0;
    for (const Root& root : polynomial.roots) sum += std::abs(root.power);
    return sum > 0 ? sum / static_cast<double>(polynomial.roots.size()) : 1.0;
  };
  VectorXd units = VectorXd::Ones(PowerVariables{kind, {}}.count(rational));
  if (kind == FitVariables::Full) {
    const auto tops = static_cast<Eigen::Index>(rational.top.roots.size());
    units.segment(3, tops).setConstant(meanPower(rational.top));
    units.tail(units.size() - 3 - tops).setConstant(meanPower(rational.bottom));
  }
  units[0] = std::max(1.0, std::abs(rational.logScale) / 10);
  return units;
}

/// The energy as a function of the optimiser's variables. Stores the best point, and any exception.
template <class Variables>
class EnergyObjective {
 public:
  using Evaluate = std::function<double(const Rational& rational, RationalGradient& gradient)>;

  EnergyObjective(Evaluate evaluate, const Rational& rational, Variables variables, const MinimiseOptions& options)
      : mEvaluate(std::move(evaluate)),
        mOptions(options),
        mVariables(std::move(variables)),
        mLow(mVariables.low()),
        mHigh(mVariables.high()),
        mBest(mVariables.of(rational).cwiseMax(mLow)),
        mAt(rational) {}

  /// The interface for LBFGSpp. @param g  the gradient at x
  double operator()(const VectorXd& x, VectorXd& g) {
    try {
      if (mOptions.cancelled && mOptions.cancelled()) throw Cancelled();
      // Rounding may move a step slightly beyond a bound.
      const VectorXd within = x.cwiseMax(mLow).cwiseMin(mHigh);
      mVariables.assign(within, mAt);
      const double value = mEvaluate(mAt, mGradient);
      g = mVariables.gradient(mGradient, mAt);
      if (value < mLowest) {
        mLowest = value;
        mBest = within;
        if (++mSteps > 0 && mOptions.onStep) mOptions.onStep(value, mAt);
      }
      return value;
    } catch (...) {
      mFailure = std::current_exception();
      throw;
    }
  }

  const VectorXd& low() const { return mLow; }
  const VectorXd& high() const { return mHigh; }
  const VectorXd& best() const { return mBest; }
  double lowest() const { return mLowest; }
  int steps() const { return mSteps; }
  void assignBest(Rational& rational) const { mVariables.assign(mBest, rational); }
  void rethrowFailure() const {
    if (mFailure) std::rethrow_exception(mFailure);
  }

 private:
  Evaluate mEvaluate;
  const MinimiseOptions& mOptions;
  Variables mVariables;
  VectorXd mLow, mHigh, mBest;
  double mLowest = std::numeric_limits<double>::infinity();
  int mSteps = -1;  ///< the first evaluation does not count
  Rational mAt;
  RationalGradient mGradient;
  std::exception_ptr mFailure;
};

LBFGSpp::LBFGSBParam<double> parametersOf(const MinimiseOptions& options) {
  LBFGSpp::LBFGSBParam<double> parameters;
  parameters.m = 20;
  parameters.epsilon = 1e-10;
  parameters.epsilon_rel = 0;
  parameters.past = 10;
  parameters.delta = options.tolerance;
  parameters.max_linesearch = 20;
  return parameters;
}

void requireValid(const MinimiseOptions& options) {
  if (options.maxIterations < 0)
    throw std::invalid_argument("the optimiser's iterations are " + std::to_string(options.maxIterations) +
                                "; they must be 0 or more");
  if (!(options.tolerance >= 0) || !std::isfinite(options.tolerance))
    throw std::invalid_argument("the optimiser's tolerance is " + textOf(options.tolerance) + "; it must be 0 or more");
}

/// Runs the optimiser. @return the energy of the best rational, which it puts in @a rational
template <class Variables>
double lowestOf(EnergyObjective<Variables>& objective, Rational& rational, const MinimiseOptions& options) {
  LBFGSpp::LBFGSBParam<double> parameters = parametersOf(options);
  bool settled = false;
  if (options.maxIterations == 0) {
    VectorXd g;
    objective(objective.best(), g);
    settled = true;
  }
  while (!settled) {
    const double before = objective.lowest();
    parameters.max_iterations = std::max(1, options.maxIterations - std::max(0, objective.steps()));
    LBFGSpp::LBFGSBSolver<double> solver(parameters);
    VectorXd x = objective.best();
    double value = 0;
    try {
      solver.minimize(objective, x, value, objective.low(), objective.high());
      settled = true;
    } catch (const std::exception&) {
      objective.rethrowFailure();
      // LBFGSpp throws if a line search fails, possibly because of its curvature memory. Restarting from the best point
      // so far, without memory, continues as long as that helps.
      settled = !(before - objective.lowest() > options.tolerance) || objective.steps() >= options.maxIterations;
    }
  }
  objective.assignBest(rational);
  return objective.lowest();
}

}  // namespace

double minimise(const ShapeEnergy& energy, Rational& rational, FitVariables kind, const MinimiseOptions& options) {
  requireFinite(rational);
  requireValid(options);
  EnergyObjective objective(
      [&](const Rational& at, RationalGradient& gradient) { return energy.evaluate(at, &gradient); }, rational,
      PowerVariables{kind, unitsOf(rational, kind)}, options);
  return lowestOf(objective, rational, options);
}

double moveRoots(ShapeEnergy& energy, Rational& rational, std::span<const double> reach,
                 const MinimiseOptions& options) {
  requireFinite(rational);
  requireValid(options);
  PlaceVariables variables{{}, reach};
  for (const Polynomial* polynomial : {&rational.top, &rational.bottom})
    for (const Root& root : polynomial->roots) variables.start.push_back(root.position);
  if (reach.size() != variables.start.size())
    throw std::invalid_argument("the rational has " + std::to_string(variables.start.size()) +
                                " roots, and there are " + std::to_string(reach.size()) +
                                " reaches; each root needs one");
  for (const double value : reach)
    if (!(value >= 0) || !std::isfinite(value))
      throw std::invalid_argument("the reach of a root is " + textOf(value) + "; it must be 0 or more");
  EnergyObjective objective(
      [&](const Rational& at, RationalGradient& gradient) {
        energy.moveRoots(at);
        return energy.evaluate(at, &gradient, GradientOf::PowersAndPlaces);
      },
      rational, variables, options);
  const double lowest = lowestOf(objective, rational, options);
  energy.moveRoots(rational);
  return lowest;
}

}  // namespace julia
