// SPDX-License-Identifier: Apache-2.0
#include "julia/fit/minimise.h"

#include "fit/eigen_setup.h"
#include "number_text.h"

#include "julia/fit/cancelled.h"

#include <LBFGSB.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <stdexcept>
#include <string>

namespace julia {
namespace {

using Eigen::VectorXd;

/// Between a rational and the optimiser's variables C, tau, beta, T_1..., B_1..., each divided by a unit.
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

}  // namespace

double minimise(const ShapeEnergy& energy, Rational& rational, FitVariables kind, const MinimiseOptions& options) {
  fixEigenBlocking();
  requireFinite(rational);
  if (options.maxIterations < 0)
    throw std::invalid_argument("the optimiser may make " + std::to_string(options.maxIterations) +
                                " iterations; it must be 0 or more");
  if (!(options.tolerance >= 0) || !std::isfinite(options.tolerance))
    throw std::invalid_argument("the optimiser's tolerance is " + textOf(options.tolerance) + "; it must be 0 or more");
  Variables variables{kind, {}};
  // Powers are hundreds where tau and beta are about 1: a unit of each variable is about its own size.
  variables.units.resize(variables.count(rational));
  const auto unit = [](const Polynomial& polynomial) {
    double sum = 0;
    for (const Root& root : polynomial.roots) sum += std::abs(root.power);
    return sum > 0 ? sum / static_cast<double>(polynomial.roots.size()) : 1.0;
  };
  variables.units.setOnes();
  if (kind == FitVariables::Full) {
    const auto tops = static_cast<Eigen::Index>(rational.top.roots.size());
    variables.units.segment(3, tops).setConstant(unit(rational.top));
    variables.units.tail(variables.units.size() - 3 - tops).setConstant(unit(rational.bottom));
  }
  variables.units[0] = std::max(1.0, std::abs(rational.logScale) / 10);

  VectorXd low = VectorXd::Zero(variables.units.size());
  low[0] = -std::numeric_limits<double>::infinity();
  const VectorXd high = VectorXd::Constant(low.size(), std::numeric_limits<double>::infinity());
  VectorXd best = variables.of(rational).cwiseMax(low);
  double lowest = std::numeric_limits<double>::infinity();
  RationalGradient gradient;
  Rational at = rational;
  int steps = -1;  // the first evaluation is none
  std::exception_ptr failure;
  const auto evaluate = [&](const VectorXd& x, VectorXd& g) {
    try {
      if (options.cancelled && options.cancelled()) throw Cancelled();
      // Rounding may take a step a little beyond a bound.
      const VectorXd within = x.cwiseMax(low);
      variables.assign(within, at);
      const double value = energy.evaluate(at, &gradient);
      g = variables.gradient(gradient, at);
      if (value < lowest) {
        lowest = value;
        best = within;
        if (++steps > 0 && options.onStep) options.onStep(value, at);
      }
      return value;
    } catch (...) {
      failure = std::current_exception();
      throw;
    }
  };

  LBFGSpp::LBFGSBParam<double> parameters;
  parameters.m = 20;
  parameters.epsilon = 1e-10;
  parameters.epsilon_rel = 0;
  parameters.past = 10;
  parameters.delta = options.tolerance;
  parameters.max_linesearch = 20;
  bool settled = false;
  if (options.maxIterations == 0) {
    VectorXd g;
    evaluate(best, g);
    settled = true;
  }
  while (!settled) {
    const double before = lowest;
    parameters.max_iterations = std::max(1, options.maxIterations - std::max(0, steps));
    LBFGSpp::LBFGSBSolver<double> solver(parameters);
    VectorXd x = best;
    double value = 0;
    try {
      solver.minimize(evaluate, x, value, low, high);
      settled = true;
    } catch (const std::exception&) {
      if (failure) std::rethrow_exception(failure);
      // LBFGSpp says so where a line search ends badly. What it remembers of the curvature may be at fault: another
      // start from the best so far, without memory, goes on as long as that helps.
      settled = !(before - lowest > options.tolerance) || steps >= options.maxIterations;
    }
  }
  variables.assign(best, rational);
  return lowest;
}

}  // namespace julia
