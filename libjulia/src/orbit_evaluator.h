// SPDX-License-Identifier: Apache-2.0
/// @file orbit_evaluator.h
/// The orbit loop of all evaluators, which takes a batch of points through the steps of a map. Orbits that have ended
/// leave the batch, so that the kernels' lanes stay full. Derived classes define how a step is taken.
#pragma once

#include "julia/evaluator.h"

#include "ball_arithmetic.h"
#include "batch_view.h"
#include "careful.h"
#include "object_pool.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace julia {

template <class Real>
class OrbitEvaluator : public FieldEvaluator {
 public:
  void evaluate(std::span<const Point> points, std::span<double> field, std::span<int> iterations) const final {
    evaluatePieces(points, field, iterations, {});
  }

  void orbitTraps(std::span<const Point> points, std::span<double> nearest) const final {
    std::vector<double> field(points.size());
    std::fill(nearest.begin(), nearest.end(), kFieldLimit);
    evaluatePieces(points, field, {}, nearest);
  }

  /// Working memory for so many points stays in the second-level cache.
  std::size_t preferredBatch() const final { return kPiece; }

  FieldDescription describe() const final {
    return {describeMap(), mEmbedding, mOptions, static_cast<double>(mLevel), std::is_same_v<Real, float>};
  }

 protected:
  /// The orbits that go on: their iterates, the logarithms of the moduli, and the points to which they belong.
  struct Batch {
    QuaternionBatch<Real> q, next;
    QuaternionBatch<Real> carried;  ///< what a map keeps for each orbit; empty if it keeps nothing
    std::vector<Real> l;
    std::vector<std::uint32_t> index;
    std::vector<std::uint32_t> stays;  ///< scratch of keep(): the places of the orbits that go on

    void resize(std::size_t n) {
      q.resize(n);
      if (carried.size() != 0) carried.resize(n);
      l.resize(n);
      index.resize(n);
      stays.resize(n);
    }
  };

  OrbitEvaluator(const Embedding& embedding, const OrbitOptions& options, Real level)
      : mEmbedding(embedding),
        mOptions(options),
        mEscapeSquared(static_cast<Real>(options.escapeRadius * options.escapeRadius)),
        mNearSquared(mEscapeSquared * (1 - 8 * std::numeric_limits<Real>::epsilon())),
        mLogEscape(logEscapeOf(options)),
        mLogTrap(static_cast<Real>(options.logTrap)),
        mLevel(level) {
    requireValid(options);
    if (!std::isfinite(embedding.slice) || std::abs(embedding.slice) > kMaxEscapeRadius)
      throw std::invalid_argument("slice is " + std::to_string(embedding.slice) + "; it must be between -1e9 and 1e9");
  }

  static Real logEscapeOf(const OrbitOptions& options) { return static_cast<Real>(std::log(options.escapeRadius)); }

  /// Sets batch.l to l of the iterates that follow batch.q, after @a step steps.
  virtual void takeStep(Batch& batch, int step) const = 0;
  /// Sets batch.q to those iterates, for the orbits that go on.
  virtual void formIterates(Batch& batch) const = 0;
  virtual MapDescription describeMap() const = 0;

  QuaternionBatch<Real> embed(std::span<const Point> points) const {
    QuaternionBatch<Real> q;
    q.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) q.set(i, mEmbedding.quaternion<Real>(points[i]));
    return q;
  }

  /// The relative error of the norms that evaluate() compares.
  static constexpr double kNormSlack = 8 * kEpsilonOf<Real>;

  /// A ball that contains what embed() makes of the points within @a radius of @a x.
  Ball embeddedBall(const Point& x, double radius) const {
    Embedding rounded = mEmbedding;
    rounded.slice = static_cast<double>(static_cast<Real>(mEmbedding.slice));
    return roundedTo<Real>({rounded.quaternion<double>(x), radius});
  }
  /// Whether all of it has escaped before the first step.
  bool hasEscaped(const Ball& start) const {
    return (norm(start.centre) - start.radius) * (1 - kNormSlack) >= std::sqrt(static_cast<double>(mEscapeSquared));
  }

  /// Without a trap, an iterate of 0, whose l is -inf too, goes on: not every map keeps it there.
  bool isTrapped(Real l) const { return l <= mLogTrap && mLogTrap > -std::numeric_limits<Real>::infinity(); }

  Embedding mEmbedding;
  OrbitOptions mOptions;
  Real mEscapeSquared;
  Real mNearSquared;  ///< below, in whichever order squares are added
  Real mLogEscape, mLogTrap, mLevel;

 private:
  static constexpr std::size_t kPiece = 2048;

  void evaluatePieces(std::span<const Point> points, std::span<double> field, std::span<int> iterations,
                      std::span<double> nearest) const {
    const auto batch = mBatches.borrow();
    const auto piece = [](auto values, std::size_t first, std::size_t size) {
      return values.empty() ? values : values.subspan(first, size);
    };
    for (std::size_t first = 0; first < points.size(); first += kPiece) {
      const std::size_t size = std::min(kPiece, points.size() - first);
      evaluatePiece(points.subspan(first, size), *batch, field.subspan(first, size), piece(iterations, first, size),
                    piece(nearest, first, size));
    }
  }

  /// @param nearest  receives the smallest l of each orbit, if not empty
  void evaluatePiece(std::span<const Point> points, Batch& batch, std::span<double> field, std::span<int> iterations,
                     std::span<double> nearest) const {
    start(points, batch, field, iterations);
    for (int step = 1; batch.q.size() != 0; ++step) {
      takeStep(batch, step);
      if (!nearest.empty())
        for (std::size_t i = 0; i < batch.l.size(); ++i) {
          double& smallest = nearest[batch.index[i]];
          smallest = std::max(-kFieldLimit, std::min(smallest, static_cast<double>(batch.l[i])));
        }
      const Real none = -std::numeric_limits<Real>::infinity();
      const bool traps = isTrapped(mLogTrap);
      const Real escape = step == mOptions.maxIterations ? none : mLogEscape, trap = mLogTrap;
      keep(
          batch, [=](Real l) { return (l < escape) & (!traps | (l > trap)); }, field, iterations, step);
      if (batch.q.size() != 0) formIterates(batch);
    }
  }

  /// Fills the batch with the points, except for those that have escaped before the first step.
  void start(std::span<const Point> points, Batch& batch, std::span<double> field, std::span<int> iterations) const {
    batch.carried.resize(0);
    batch.resize(points.size());
    if (!embed(points, batch)) return;
    for (std::size_t i = 0; i < points.size(); ++i)
      // At least the escape: a rounding error must not bring back what has escaped.
      batch.l[i] = normSquared(batch.q.get(i)) < mEscapeSquared
                       ? -std::numeric_limits<Real>::infinity()
                       : std::max(careful::logNorm(batch.q.get(i)), mLogEscape);
    keep(
        batch, [escape = mLogEscape](Real l) { return l < escape; }, field, iterations, 0);
  }

  /// @return whether a point may have escaped already
  bool embed(std::span<const Point> points, Batch& batch) const {
    QuaternionBatch<Real>& q = batch.q;
    const Quaternion<Real*> components{q.a.data(), q.b.data(), q.c.data(), q.d.data()};
    const std::array<Real*, 3> to = mEmbedding.point(components);
    Real* const toSlice = mEmbedding.slicePart(components);
    const Real slice = static_cast<Real>(mEmbedding.slice), near = mNearSquared;
    std::uint32_t* const index = batch.index.data();
    bool escaped = false;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Real x = static_cast<Real>(points[i][0]), y = static_cast<Real>(points[i][1]),
                 z = static_cast<Real>(points[i][2]);
      to[0][i] = x;
      to[1][i] = y;
      to[2][i] = z;
      toSlice[i] = slice;
      index[i] = static_cast<std::uint32_t>(i);
      escaped |= !(x * x + y * y + z * z + slice * slice < near);
    }
    return escaped;
  }

  /// Writes the field of the orbits that end at this step and closes the ranks of the others. There are no branches,
  /// which could not be predicted: orbits that go on have their field written again later.
  template <class GoesOn>
  void keep(Batch& batch, GoesOn goesOn, std::span<double> field, std::span<int> iterations, int step) const {
    const std::size_t size = batch.q.size();
    const Real* const l = batch.l.data();
    std::uint32_t* const index = batch.index.data();
    const Real level = mLevel;
    const auto fieldOf = [level](Real at) {
      const double value = static_cast<double>(at - level);
      const double above = value > -kFieldLimit ? value : -kFieldLimit;
      return above < kFieldLimit ? above : kFieldLimit;
    };
    if (size == field.size())
      for (std::size_t i = 0; i < size; ++i) field[i] = fieldOf(l[i]);
    else
      for (std::size_t i = 0; i < size; ++i) field[index[i]] = fieldOf(l[i]);
    if (!iterations.empty())
      for (std::size_t i = 0; i < size; ++i) iterations[index[i]] = step;
    // In a loop apart from the count, whose additions wait for each other.
    std::array<std::uint8_t, kPiece> isKept{};
    for (std::size_t i = 0; i < size; ++i) isKept[i] = goesOn(l[i]) ? 1 : 0;
    std::uint32_t* const stays = batch.stays.data();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < size; ++i) {
      stays[kept] = static_cast<std::uint32_t>(i);
      kept += isKept[i];
    }
    if (kept < size) {
      const auto closeRanks = [&](auto* values) {
        for (std::size_t k = 0; k < kept; ++k) values[k] = values[stays[k]];
      };
      for (QuaternionBatch<Real>* quaternions : {&batch.q, &batch.carried})
        for (std::vector<Real>* part : {&quaternions->a, &quaternions->b, &quaternions->c, &quaternions->d})
          if (!part->empty()) closeRanks(part->data());
      closeRanks(batch.l.data());
      closeRanks(index);
    }
    batch.resize(kept);
  }

  mutable ObjectPool<Batch> mBatches{[] { return std::make_unique<Batch>(); }};
};

}  // namespace julia
