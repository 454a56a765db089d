// SPDX-License-Identifier: Apache-2.0
#include "julia/evaluator.h"

#include "batch_view.h"
#include "careful.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

namespace julia {
namespace {

/// Works through a batch in steps of the map. What has ended leaves the batch, so that the kernels' lanes stay full.
template <class Real>
class BatchEvaluator final : public FieldEvaluator {
 public:
  BatchEvaluator(std::shared_ptr<const Map<Real>> map, const Embedding& embedding, const OrbitOptions& options)
      : mMap(std::move(map)),
        mEmbedding(embedding),
        mOptions(options),
        mEscapeSquared(static_cast<Real>(options.escapeRadius * options.escapeRadius)),
        mLogEscape(static_cast<Real>(std::log(options.escapeRadius))),
        mLogTrap(static_cast<Real>(options.logTrap)),
        mLevel(mMap->surfaceLevel(mLogEscape)) {
    requireValid(options);
    if (!std::isfinite(embedding.slice) || std::abs(embedding.slice) > kMaxEscapeRadius)
      throw std::invalid_argument("slice is " + std::to_string(embedding.slice) + "; it must be between -1e9 and 1e9");
  }

  void evaluate(std::span<const Point> points, std::span<double> field, std::span<int> iterations) const override {
    Batch batch;
    start(points, batch, field, iterations);
    QuaternionBatch<Real> u;
    for (int step = 1; batch.q.size() != 0; ++step) {
      batch.l.resize(batch.q.size());
      mMap->logModulus(batch.q, batch.l);
      const bool last = step == mOptions.maxIterations;
      keep(
          batch, [&](Real l) { return !last && l < mLogEscape && !isTrapped(l); }, field, iterations, step);
      if (batch.q.size() == 0) break;
      mMap->versor(batch.q, u);
      std::swap(batch.q, u);
      kernels::kernels<Real>().scaleByExponential(batch.l.data(), view(batch.q), batch.q.size());
    }
  }

  void versors(std::span<const Point> points, std::span<Quaternion<double>> versors) const override {
    QuaternionBatch<Real> u;
    mMap->versor(embed(points), u);
    for (std::size_t i = 0; i < points.size(); ++i) versors[i] = u.get(i).template as<double>();
  }

 private:
  QuaternionBatch<Real> embed(std::span<const Point> points) const {
    QuaternionBatch<Real> q;
    q.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) q.set(i, mEmbedding.quaternion<Real>(points[i]));
    return q;
  }

  /// The orbits that go on: their iterates, l of these, and which point each belongs to.
  struct Batch {
    QuaternionBatch<Real> q;
    std::vector<Real> l;
    std::vector<std::uint32_t> index;
  };

  /// An iterate of 0 has l = -inf too; without a trap it goes on, for not every map keeps it there.
  bool isTrapped(Real l) const { return l <= mLogTrap && mLogTrap > -std::numeric_limits<Real>::infinity(); }

  /// The points themselves, less those that have escaped before the first step.
  void start(std::span<const Point> points, Batch& batch, std::span<double> field, std::span<int> iterations) const {
    batch.q = embed(points);
    batch.index.resize(points.size());
    std::iota(batch.index.begin(), batch.index.end(), 0u);
    Real farthest = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Real squared = normSquared(batch.q.get(i));
      farthest = squared > farthest ? squared : farthest;
    }
    if (farthest < mEscapeSquared) return;
    batch.l.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
      // At least the escape: a rounding error must not bring back what has escaped.
      batch.l[i] = normSquared(batch.q.get(i)) < mEscapeSquared
                       ? -std::numeric_limits<Real>::infinity()
                       : std::max(careful::logNorm(batch.q.get(i)), mLogEscape);
    keep(
        batch, [&](Real l) { return l < mLogEscape; }, field, iterations, 0);
  }

  /// Writes the field of the orbits that end at this step and closes the ranks of the others.
  template <class GoesOn>
  void keep(Batch& batch, GoesOn goesOn, std::span<double> field, std::span<int> iterations, int step) const {
    QuaternionBatch<Real>& q = batch.q;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < q.size(); ++i) {
      const Real l = batch.l[i];
      const std::uint32_t index = batch.index[i];
      if (goesOn(l)) {
        q.a[kept] = q.a[i];
        q.b[kept] = q.b[i];
        q.c[kept] = q.c[i];
        q.d[kept] = q.d[i];
        batch.index[kept] = index;
        batch.l[kept] = l;
        ++kept;
      } else {
        field[index] = std::clamp<double>(static_cast<double>(l - mLevel), -kFieldLimit, kFieldLimit);
        if (!iterations.empty()) iterations[index] = step;
      }
    }
    q.resize(kept);
    batch.l.resize(kept);
    batch.index.resize(kept);
  }

  std::shared_ptr<const Map<Real>> mMap;
  Embedding mEmbedding;
  OrbitOptions mOptions;
  Real mEscapeSquared, mLogEscape, mLogTrap, mLevel;
};

/// Two evaluators of one map, with a trap and without.
class ConfirmingEvaluator final : public FieldEvaluator {
 public:
  ConfirmingEvaluator(std::unique_ptr<FieldEvaluator> trapped, std::unique_ptr<FieldEvaluator> full)
      : mTrapped(std::move(trapped)), mFull(std::move(full)) {}

  void evaluate(std::span<const Point> points, std::span<double> field, std::span<int> iterations) const override {
    mTrapped->evaluate(points, field, iterations);
    std::vector<double> full(points.size());
    std::vector<int> steps(points.size());
    mFull->evaluate(points, full, steps);
    for (std::size_t i = 0; i < points.size(); ++i) {
      if ((full[i] < 0) == (field[i] < 0)) continue;
      field[i] = full[i];
      if (!iterations.empty()) iterations[i] = steps[i];
    }
  }
  void versors(std::span<const Point> points, std::span<Quaternion<double>> versors) const override {
    mFull->versors(points, versors);
  }

 private:
  std::unique_ptr<FieldEvaluator> mTrapped, mFull;
};

}  // namespace

template <class Real>
std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const Map<Real>> map, const Embedding& embedding,
                                                   const OrbitOptions& options) {
  auto evaluator = std::make_unique<BatchEvaluator<Real>>(map, embedding, options);
  if (!options.confirmTrap) return evaluator;
  OrbitOptions full = options;
  full.logTrap = -std::numeric_limits<double>::infinity();
  return std::make_unique<ConfirmingEvaluator>(std::move(evaluator),
                                               std::make_unique<BatchEvaluator<Real>>(std::move(map), embedding, full));
}

template std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const Map<float>>, const Embedding&,
                                                            const OrbitOptions&);
template std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const Map<double>>, const Embedding&,
                                                            const OrbitOptions&);

}  // namespace julia
