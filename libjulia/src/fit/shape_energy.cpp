// SPDX-License-Identifier: Apache-2.0
#include "julia/fit/shape_energy.h"

#include "fit/log_matrix.h"
#include "number_text.h"

#include "julia/elementary.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace julia {

std::vector<Point> pointsOf(std::span<const FitCell> cells) {
  std::vector<Point> points;
  points.reserve(cells.size());
  for (const FitCell& cell : cells) points.push_back(cell.x);
  return points;
}

std::vector<double> cellWeights(std::span<const FitCell> cells, CellWeights kind, double cellSize) {
  std::vector<double> weights(cells.size());
  double inside = 0, outside = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const double distance = std::abs(double{cells[i].phi}) / cellSize, sign = cells[i].phi < 0 ? -1 : 1;
    const double by =
        kind == CellWeights::Layers ? std::max(std::ceil(distance), 1.0) : std::max(distance, kLeastDistance);
    weights[i] = sign * cells[i].volume / by;
    (sign < 0 ? inside : outside) += std::abs(weights[i]);
  }
  if (kind == CellWeights::Layers)
    for (double& weight : weights) weight /= 2 * (weight < 0 ? inside : outside);
  return weights;
}

struct ShapeEnergy::Parts {
  LogMatrix logs;
  std::vector<double> weights;
  ShapeEnergyOptions options;
  std::size_t tops = 0, bottoms = 0;
  double eta = 0;

  void requireSameCount(const Rational& rational) const {
    if (rational.top.roots.size() != tops || rational.bottom.roots.size() != bottoms)
      throw std::invalid_argument("the rational has " + std::to_string(rational.top.roots.size()) + " and " +
                                  std::to_string(rational.bottom.roots.size()) + " roots, the energy was made for " +
                                  std::to_string(tops) + " and " + std::to_string(bottoms));
  }

  std::vector<double> columnWeights(const Rational& rational) const {
    requireSameCount(rational);
    std::vector<double> result;
    for (const Root& root : rational.top.roots) result.push_back(rational.top.powerScale * root.power);
    for (const Root& root : rational.bottom.roots) result.push_back(-rational.bottom.powerScale * root.power);
    return result;
  }
};

namespace {

std::vector<Quaternion<double>> positionsOf(const Rational& roots) {
  std::vector<Quaternion<double>> positions;
  for (const Polynomial* polynomial : {&roots.top, &roots.bottom})
    for (const Root& root : polynomial->roots) positions.push_back(root.position);
  return positions;
}

}  // namespace

ShapeEnergy::ShapeEnergy(std::span<const Point> cells, std::vector<double> weights, const Rational& roots,
                         const ShapeEnergyOptions& options) {
  if (!(options.alpha > 0) || !std::isfinite(options.alpha))
    throw std::invalid_argument("the energy's alpha is " + textOf(options.alpha) + "; it must be above 0");
  if (!(options.powerPenalty >= 0) || !std::isfinite(options.powerPenalty))
    throw std::invalid_argument("the penalty on powers is " + textOf(options.powerPenalty) + "; it must be 0 or more");
  for (const Point& x : cells)
    for (const double coordinate : x)
      if (!std::isfinite(coordinate))
        throw std::invalid_argument("a coordinate of one of the energy's cells is " + textOf(coordinate));
  requireFinite(roots);
  mParts = std::make_unique<Parts>(
      Parts{LogMatrix(cells, options.memoryLimit), {}, options, roots.top.roots.size(), roots.bottom.roots.size(), 0});
  setWeights(std::move(weights));
  mParts->logs.append(positionsOf(roots));
}

void ShapeEnergy::moveRoots(const Rational& roots) {
  requireFinite(roots);
  mParts->requireSameCount(roots);
  mParts->logs.move(positionsOf(roots));
}

ShapeEnergy::~ShapeEnergy() = default;

const std::vector<double>& ShapeEnergy::weights() const { return mParts->weights; }
const ShapeEnergyOptions& ShapeEnergy::options() const { return mParts->options; }

void ShapeEnergy::setWeights(std::vector<double> weights) {
  const std::size_t cells = mParts->logs.cellCount();
  if (cells == 0 || weights.size() != cells)
    throw std::invalid_argument("the energy has " + std::to_string(cells) + " cells and " +
                                std::to_string(weights.size()) + " weights; it needs one weight for each of some");
  double eta = 0;
  for (const double weight : weights) eta += std::abs(weight);
  if (!(eta > 0) || !std::isfinite(eta))
    throw std::invalid_argument("the weights of the energy's cells sum to " + textOf(eta) +
                                "; they must be finite and not all 0");
  mParts->weights = std::move(weights);
  mParts->eta = eta;
}

void ShapeEnergy::logModuli(const Rational& rational, std::span<double> l) const {
  mParts->logs.logModuli(mParts->columnWeights(rational), rational.logScale, l);
}

double ShapeEnergy::evaluate(const Rational& rational, RationalGradient* gradient, GradientOf of) const {
  const Parts& parts = *mParts;
  const bool wantPlaces = gradient && of == GradientOf::PowersAndPlaces;
  const double alpha = parts.options.alpha, share = 1 / parts.eta;
  const LogMatrix::Pass pass = parts.logs.pass(
      parts.columnWeights(rational), rational.logScale,
      [&](std::size_t begin, std::span<const double> l, std::span<double> factors) {
        double sum = 0;
        for (std::size_t i = 0; i < l.size(); ++i) {
          const double weight = parts.weights[begin + i] * share, step = elementary::tanh(alpha * l[i]);
          sum -= step * weight;
          factors[i] = -alpha * (1 - step * step) * weight;
        }
        return sum;
      },
      wantPlaces ? LogMatrix::Products::LogsAndPlaces
      : gradient ? LogMatrix::Products::Logs
                 : LogMatrix::Products::None);
  const double penalty = parts.options.powerPenalty;
  const double powers = summedPowers(rational.top) + summedPowers(rational.bottom);
  if (gradient) {
    const auto side = [&](const Polynomial& polynomial, std::size_t first, double sign, double& byScale,
                          std::vector<double>& byPower, std::vector<Quaternion<double>>& byPlace) {
      byScale = 0;
      byPower.resize(polynomial.roots.size());
      byPlace.clear();
      for (std::size_t i = 0; i < byPower.size(); ++i) {
        const double byWeight = sign * pass.products[first + i] + penalty;
        byPower[i] = polynomial.powerScale * byWeight;
        byScale += polynomial.roots[i].power * byWeight;
        if (wantPlaces)
          byPlace.push_back(pass.places[first + i] * (sign * polynomial.powerScale * polynomial.roots[i].power));
      }
    };
    gradient->logScale = pass.products.back();
    side(rational.top, 0, 1, gradient->topScale, gradient->top, gradient->topPlaces);
    side(rational.bottom, parts.tops, -1, gradient->bottomScale, gradient->bottom, gradient->bottomPlaces);
  }
  // The rounded sum may slightly exceed the whole.
  return std::clamp(pass.sum, -1.0, 1.0) + penalty * powers;
}

std::vector<double> reweighted(std::span<const double> weights, std::span<const double> l, double alpha,
                               std::span<const char> fractalInside) {
  double well = 0, poor = 0;
  for (std::size_t i = 0; i < weights.size(); ++i)
    if (weights[i] < 0) (fractalInside[i] ? well : poor) += std::abs(elementary::tanh(alpha * l[i]) * weights[i]);
  std::vector<double> result(weights.begin(), weights.end());
  if (!(well > 0) || !(poor > 0)) return result;
  const double half = (well + poor) / 2;
  for (std::size_t i = 0; i < result.size(); ++i)
    if (result[i] < 0) result[i] *= half / (fractalInside[i] ? well : poor);
  return result;
}

}  // namespace julia
