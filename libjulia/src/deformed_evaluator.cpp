// SPDX-License-Identifier: Apache-2.0
#include "julia/deformed_evaluator.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace julia {
namespace {

class DeformedEvaluator final : public FieldEvaluator {
 public:
  DeformedEvaluator(std::shared_ptr<const FieldEvaluator> evaluator, std::shared_ptr<const Deformation> deformation)
      : mEvaluator(std::move(evaluator)),
        mDeformation(std::move(deformation)),
        mMaxIterations(mEvaluator->describe().orbit.maxIterations) {}

  void evaluate(std::span<const Point> points, std::span<double> field, std::span<int> iterations) const override {
    const Carried carried(*mDeformation, points);
    std::vector<double> inner(carried.points.size());
    std::vector<int> steps(iterations.empty() ? 0 : inner.size());
    mEvaluator->evaluate(carried.points, inner, steps);
    for (std::size_t i = 0, next = 0; i < points.size(); ++i) {
      const Decision decision = carried.decisions[i];
      if (decision == Decision::Undecided) {
        field[i] = inner[next];
        if (!iterations.empty()) iterations[i] = steps[next];
        ++next;
      } else {
        field[i] = decision == Decision::Inside ? -kFieldLimit : kFieldLimit;
        if (!iterations.empty()) iterations[i] = decision == Decision::Inside ? mMaxIterations : 0;
      }
    }
  }

  std::size_t preferredBatch() const override { return mEvaluator->preferredBatch(); }
  int dimension() const override { return mEvaluator->dimension(); }

  void versors(std::span<const Point> points, std::span<Quaternion<double>> versors) const override {
    const Carried carried(*mDeformation, points);
    std::vector<Quaternion<double>> inner(carried.points.size());
    mEvaluator->versors(carried.points, inner);
    carried.spread(std::span<const Quaternion<double>>(inner), Quaternion<double>::one(), versors);
  }

  void orbitTraps(std::span<const Point> points, std::span<double> nearest) const override {
    const Carried carried(*mDeformation, points);
    std::vector<double> inner(carried.points.size());
    mEvaluator->orbitTraps(carried.points, inner);
    carried.spread(std::span<const double>(inner), kFieldLimit, nearest);
  }

  void decide(std::span<const Point> centres, double radius, std::span<Decision> out) const override {
    std::vector<Deformation::Image> images(centres.size());
    mDeformation->images(centres, radius, images);
    std::vector<Point> inner;
    std::vector<std::size_t> number;
    double largest = 0;
    for (std::size_t i = 0; i < centres.size(); ++i) {
      out[i] = images[i].decision;
      if (out[i] != Decision::Undecided || !std::isfinite(images[i].radius)) continue;
      inner.push_back(images[i].centre);
      number.push_back(i);
      largest = std::max(largest, images[i].radius);
    }
    // The images of balls of one size are nearly of one size.
    std::vector<Decision> decided(inner.size());
    mEvaluator->decide(inner, largest, decided);
    for (std::size_t k = 0; k < inner.size(); ++k) out[number[k]] = decided[k];
  }

 private:
  /// The images of those points that have one.
  struct Carried {
    Carried(const Deformation& deformation, std::span<const Point> from) : points(from.size()), decisions(from.size()) {
      deformation.carry(from, points, decisions);
      std::size_t kept = 0;
      for (std::size_t i = 0; i < from.size(); ++i)
        if (decisions[i] == Decision::Undecided) points[kept++] = points[i];
      points.resize(kept);
    }

    template <class Value>
    void spread(std::span<const Value> inner, const Value& otherwise, std::span<Value> out) const {
      for (std::size_t i = 0, next = 0; i < out.size(); ++i)
        out[i] = decisions[i] == Decision::Undecided ? inner[next++] : otherwise;
    }

    std::vector<Point> points;
    std::vector<Decision> decisions;
  };

  std::shared_ptr<const FieldEvaluator> mEvaluator;
  std::shared_ptr<const Deformation> mDeformation;
  int mMaxIterations;
};

}  // namespace

std::unique_ptr<FieldEvaluator> makeDeformedEvaluator(std::shared_ptr<const FieldEvaluator> evaluator,
                                                      std::shared_ptr<const Deformation> deformation) {
  return std::make_unique<DeformedEvaluator>(std::move(evaluator), std::move(deformation));
}

}  // namespace julia
