// SPDX-License-Identifier: Apache-2.0
#include "julia/evaluator.h"

#include "julia/log_polar.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace julia {
namespace {

template <class Real>
class ScalarEvaluator final : public FieldEvaluator {
 public:
  ScalarEvaluator(std::shared_ptr<const Map<Real>> map, const Embedding& embedding, const OrbitOptions& options)
      : mMap(std::move(map)),
        mEmbedding(embedding),
        mOptions(options),
        mLogEscape(static_cast<Real>(std::log(options.escapeRadius))),
        mLogTrap(static_cast<Real>(options.logTrap)),
        mLevel(mMap->surfaceLevel(mLogEscape)) {
    requireValid(options);
    if (!std::isfinite(embedding.slice) || std::abs(embedding.slice) > kMaxEscapeRadius)
      throw std::invalid_argument("slice is " + std::to_string(embedding.slice) + "; it must be between -1e9 and 1e9");
  }

  void evaluate(std::span<const Point> points, std::span<double> field, std::span<int> iterations) const override {
    QuaternionBatch<Real> q = embed(points), u;
    std::vector<std::size_t> index(points.size());  // which point an entry of the batch belongs to
    std::vector<Real> l(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      index[i] = i;
      l[i] = logNorm(q.get(i));
    }
    // Only what has not escaped goes on, and its entries stay together.
    std::size_t alive = keep(
        q, index, l, [this](Real value) { return value < mLogEscape; }, field, iterations, 0);
    for (int step = 1; alive != 0; ++step) {
      l.resize(alive);
      mMap->logModulus(q, l);
      const bool last = step == mOptions.maxIterations;
      alive = keep(
          q, index, l, [&](Real value) { return !last && value < mLogEscape && !isTrapped(value); }, field, iterations,
          step);
      if (alive == 0) break;
      mMap->versor(q, u);
      for (std::size_t i = 0; i < alive; ++i) q.set(i, toCartesian(LogPolar<Real>{l[i], u.get(i)}));
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

  /// An iterate of 0 has l = -inf too; without a trap it goes on, for not every map keeps it there.
  bool isTrapped(Real l) const { return l <= mLogTrap && mLogTrap > -std::numeric_limits<Real>::infinity(); }

  /// Writes the field of the entries that end at this step and closes the ranks of the others. @return how many go on
  template <class GoesOn>
  std::size_t keep(QuaternionBatch<Real>& q, std::vector<std::size_t>& index, std::vector<Real>& l, GoesOn goesOn,
                   std::span<double> field, std::span<int> iterations, int step) const {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < q.size(); ++i) {
      if (goesOn(l[i])) {
        q.set(kept, q.get(i));
        index[kept] = index[i];
        l[kept] = l[i];
        ++kept;
      } else {
        field[index[i]] = std::clamp<double>(static_cast<double>(l[i] - mLevel), -kFieldLimit, kFieldLimit);
        if (!iterations.empty()) iterations[index[i]] = step;
      }
    }
    q.resize(kept);
    return kept;
  }

  std::shared_ptr<const Map<Real>> mMap;
  Embedding mEmbedding;
  OrbitOptions mOptions;
  Real mLogEscape, mLogTrap, mLevel;
};

}  // namespace

template <class Real>
std::unique_ptr<FieldEvaluator> makeScalarEvaluator(std::shared_ptr<const Map<Real>> map, const Embedding& embedding,
                                                    const OrbitOptions& options) {
  return std::make_unique<ScalarEvaluator<Real>>(std::move(map), embedding, options);
}

template std::unique_ptr<FieldEvaluator> makeScalarEvaluator(std::shared_ptr<const Map<float>>, const Embedding&,
                                                             const OrbitOptions&);
template std::unique_ptr<FieldEvaluator> makeScalarEvaluator(std::shared_ptr<const Map<double>>, const Embedding&,
                                                             const OrbitOptions&);

}  // namespace julia
