// SPDX-License-Identifier: Apache-2.0
#include "julia/evaluator.h"

#include "ball_arithmetic.h"
#include "norms.h"
#include "orbit_evaluator.h"

#include "julia/elementary.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace julia {
namespace {

/// Evaluates maps in Cartesian form.
template <class Real>
class CartesianEvaluator final : public OrbitEvaluator<Real> {
  using Base = OrbitEvaluator<Real>;
  using typename Base::Batch;

 public:
  CartesianEvaluator(std::shared_ptr<const CartesianMap<Real>> map, const Embedding& embedding,
                     const OrbitOptions& options)
      : Base(embedding, options, Base::logEscapeOf(options)), mMap(std::move(map)) {
    if (mMap->dimension() == 3 && (embedding.slice != 0 || embedding.dropped != DropAxis::K))
      throw std::invalid_argument("this map is one of three dimensions; it has no slice and no dropped axis");
  }

  int dimension() const override { return mMap->dimension(); }

  void decide(std::span<const Point> centres, double radius, std::span<Decision> out) const override {
    std::fill(out.begin(), out.end(), Decision::Undecided);
    // With a trap, orbits would end inside.
    if (mOptions.confirmTrap || this->isTrapped(this->mLogTrap) || !(radius >= 0)) return;
    for (std::size_t i = 0; i < centres.size(); ++i) out[i] = decisionOf(this->embeddedBall(centres[i], radius));
  }

  void versors(std::span<const Point> points, std::span<Quaternion<double>> versors) const override {
    QuaternionBatch<Real> direction, u;
    mMap->direction(this->embed(points), direction);
    versorsOf(direction, u);
    for (std::size_t i = 0; i < points.size(); ++i) versors[i] = u.get(i).template as<double>();
  }

 private:
  using Base::mOptions;

  /// Follows a ball that contains the iterates of all orbits that have not escaped, until every orbit has.
  Decision decisionOf(const Ball& start) const {
    if (this->hasEscaped(start)) return Decision::Outside;
    // The evaluator compares rounded logarithms of rounded lengths.
    const double escape = mOptions.escapeRadius, logs = 2 * std::abs(elementary::log(escape)) + 16;
    const double slack = Base::kNormSlack + 2 * kEpsilonOf<Real> * logs;
    const auto largest = [](const Ball& ball) { return norm(ball.centre) + ball.radius; };
    const auto mayEscape = [&](const Ball& ball) { return !(largest(ball) * (1 + slack) < escape); };
    bool inside = mMap->isDefinedEverywhere() && !mayEscape(start);
    Ball ball = start;
    for (int number = 1; number <= mOptions.maxIterations; ++number) {
      const std::optional<Ball> image = mMap->imageOf(ball, start, number);
      if (!image || !std::isfinite(largest(*image))) return Decision::Undecided;
      ball = *image;
      if ((norm(ball.centre) - ball.radius) * (1 - slack) >= escape) return Decision::Outside;
      inside = inside && !mayEscape(ball);
      // The ball contains every point that has not escaped, and so will its images.
      if (ball.radius > norm(ball.centre) + escape) return Decision::Undecided;
    }
    return inside ? Decision::Inside : Decision::Undecided;
  }

  void takeStep(Batch& batch, int step) const override {
    if (step == 1)
      mMap->begin(batch.q, batch.carried, batch.next);
    else
      mMap->step(batch.q, batch.carried, batch.next);
    std::swap(batch.q, batch.next);
    logNorms<Real>(batch.q, batch.l);
  }

  void formIterates(Batch&) const override {}
  MapDescription describeMap() const override { return mMap->describe(); }

  std::shared_ptr<const CartesianMap<Real>> mMap;
};

}  // namespace

template <class Real>
std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const CartesianMap<Real>> map,
                                                   const Embedding& embedding, const OrbitOptions& options) {
  return std::make_unique<CartesianEvaluator<Real>>(std::move(map), embedding, options);
}

template std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const CartesianMap<float>>,
                                                            const Embedding&, const OrbitOptions&);
template std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const CartesianMap<double>>,
                                                            const Embedding&, const OrbitOptions&);

}  // namespace julia
