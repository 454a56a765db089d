// SPDX-License-Identifier: Apache-2.0
#include "julia/fit/minimise.h"

#include "number_text.h"

#include "julia/fit/cancelled.h"

#include <LBFGSB.h>
#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <stdexcept>
#include <string>

namespace julia {
namespace {

using Eigen::VectorXd;

/// Converts between a rational and the optimiser's variables C, tau, beta, T_1..., B_1..., each divided by a unit.
struct Variables {
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
};

/// Powers may be in the hundreds while tau and beta are about 1: the unit of a variable is about its own size.
VectorXd unitsOf(const Rational& rational, FitVariables kind) {
  const auto meanPower = [](const Polynomial& polynomial) {
    double sum = 0;
    for (const Root& root : polynomial.roots) sum += std::abs(root.power);
    return sum > 0 ? sum / static_cast<double>(polynomial.roots.size()) : 1.0;
  };
  VectorXd units = VectorXd::Ones(Variables{kind, {}}.count(rational));
  if (kind == FitVariables::Full) {
    const auto tops = static_cast<Eigen::Index>(rational.top.roots.size());
    units.segment(3, tops).setConstant(meanPower(rational.top));
    units.tail(units.size() - 3 - tops).setConstant(meanPower(rational.bottom));
  }
  units[0] = std::max(1.0, std::abs(rational.logScale) / 10);
  return units;
}

/// The energy as a function of the optimiser's variables. Stores the best point, and any exception.
class EnergyObjective {
 public:
  EnergyObjective(const ShapeEnergy& energy, const Rational& rational, FitVariables kind,
                  const MinimiseOptions& options)
      : mEnergy(energy),
        mOptions(options),
        mVariables{kind, unitsOf(rational, kind)},
        mLow(VectorXd::Zero(mVariables.units.size())),
        mAt(rational) {
    mLow[0] = -std::numeric_limits<double>::infinity();
    mBest = mVariables.of(rational).cwiseMax(mLow);
  }

  /// The interface for LBFGSpp. @param g  the gradient at x
  double operator()(const VectorXd& x, VectorXd& g) {
    try {
      if (mOptions.cancelled && mOptions.cancelled()) throw Cancelled();
      // Rounding may move a step slightly beyond a bound.
      const VectorXd within = x.cwiseMax(mLow);
      mVariables.assign(within, mAt);
      const double value = mEnergy.evaluate(mAt, &mGradient);
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
  const VectorXd& best() const { return mBest; }
  double lowest() const { return mLowest; }
  int steps() const { return mSteps; }
  void assignBest(Rational& rational) const { mVariables.assign(mBest, rational); }
  void rethrowFailure() const {
    if (mFailure) std::rethrow_exception(mFailure);
  }

 private:
  const ShapeEnergy& mEnergy;
  const MinimiseOptions& mOptions;
  Variables mVariables;
  VectorXd mLow, mBest;
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

}  // namespace

double minimise(const ShapeEnergy& energy, Rational& rational, FitVariables kind, const MinimiseOptions& options) {
  requireFinite(rational);
  requireValid(options);
  EnergyObjective objective(energy, rational, kind, options);
  LBFGSpp::LBFGSBParam<double> parameters = parametersOf(options);
  const VectorXd high = VectorXd::Constant(objective.low().size(), std::numeric_limits<double>::infinity());
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
      solver.minimize(objective, x, value, objective.low(), high);
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

}  // namespace julia
