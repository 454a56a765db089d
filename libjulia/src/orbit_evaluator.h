// SPDX-License-Identifier: Apache-2.0
/// @file orbit_evaluator.h
/// The orbit loop of all evaluators: works through a batch in steps of a map. What has ended leaves the batch, so that
/// the kernels' lanes stay full. How a step is taken is the derived class's.
#pragma once

#include "julia/evaluator.h"

#include "ball_arithmetic.h"
#include "batch_view.h"
#include "careful.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
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

 protected:
  /// The orbits that go on: their iterates, l of these, and which point each belongs to.
  struct Batch {
    QuaternionBatch<Real> q, next;
    QuaternionBatch<Real> carried;  ///< what a map keeps for each orbit; empty if nothing
    std::vector<Real> l;
    std::vector<std::uint32_t> index;
    std::vector<std::uint32_t> stays;  ///< places of those that go on, while ranks close

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

  /// batch.l = l of the iterates that follow batch.q, after @a step steps.
  virtual void takeStep(Batch& batch, int step) const = 0;
  /// batch.q = those iterates, of the orbits that go on.
  virtual void formIterates(Batch& batch) const = 0;

  QuaternionBatch<Real> embed(std::span<const Point> points) const {
    QuaternionBatch<Real> q;
    q.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) q.set(i, mEmbedding.quaternion<Real>(points[i]));
    return q;
  }

  /// Of the norms that evaluate() compares.
  static constexpr double kNormSlack = 8 * kEpsilonOf<Real>;

  /// Holds what embed() makes of the points within @a radius of x.
  Ball embeddedBall(const Point& x, double radius) const {
    Embedding rounded = mEmbedding;
    rounded.slice = static_cast<double>(static_cast<Real>(mEmbedding.slice));
    return roundedTo<Real>({rounded.quaternion<double>(x), radius});
  }
  /// Whether all of it has escaped before the first step.
  bool hasEscaped(const Ball& start) const {
    return (norm(start.centre) - start.radius) * (1 - kNormSlack) >= std::sqrt(static_cast<double>(mEscapeSquared));
  }

  /// An iterate of 0 has l = -inf too; without a trap it goes on, for not every map keeps it there.
  bool isTrapped(Real l) const { return l <= mLogTrap && mLogTrap > -std::numeric_limits<Real>::infinity(); }

  Embedding mEmbedding;
  OrbitOptions mOptions;
  Real mEscapeSquared;
  Real mNearSquared;  ///< below, in whichever order squares are added
  Real mLogEscape, mLogTrap, mLevel;

 private:
  static constexpr std::size_t kPiece = 2048;

  /// In pieces that stay in the second-level cache; the room for one is kept for the next.
  void evaluatePieces(std::span<const Point> points, std::span<double> field, std::span<int> iterations,
                      std::span<double> nearest) const {
    static thread_local Batch batch;
    const auto piece = [](auto values, std::size_t first, std::size_t size) {
      return values.empty() ? values : values.subspan(first, size);
    };
    for (std::size_t first = 0; first < points.size(); first += kPiece) {
      const std::size_t size = std::min(kPiece, points.size() - first);
      evaluatePiece(points.subspan(first, size), batch, field.subspan(first, size), piece(iterations, first, size),
                    piece(nearest, first, size));
    }
  }

  /// @param nearest  takes the smallest l, if not empty
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

  /// The points themselves, less those that have escaped before the first step.
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

  /// @return whether one has escaped already
  bool embed(std::span<const Point> points, Batch& batch) const {
    QuaternionBatch<Real>& q = batch.q;
    const auto to = [&]() -> std::array<Real*, 4> {
      switch (mEmbedding.dropped) {
        case DropAxis::I: return {q.a.data(), q.c.data(), q.d.data(), q.b.data()};
        case DropAxis::J: return {q.a.data(), q.b.data(), q.d.data(), q.c.data()};
        case DropAxis::K: break;
      }
      return {q.a.data(), q.b.data(), q.c.data(), q.d.data()};
    }();
    const Real slice = static_cast<Real>(mEmbedding.slice), near = mNearSquared;
    std::uint32_t* const index = batch.index.data();
    bool escaped = false;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Real x = static_cast<Real>(points[i][0]), y = static_cast<Real>(points[i][1]),
                 z = static_cast<Real>(points[i][2]);
      to[0][i] = x;
      to[1][i] = y;
      to[2][i] = z;
      to[3][i] = slice;
      index[i] = static_cast<std::uint32_t>(i);
      escaped |= !(x * x + y * y + z * z + slice * slice < near);
    }
    return escaped;
  }

  /// Writes the field of the orbits that end at this step and closes the ranks of the others. Without branches, which
  /// would go either way: what goes on has its field written again later.
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
    // Apart from the count, whose additions wait for each other.
    std::array<std::uint8_t, kPiece> goes{};
    for (std::size_t i = 0; i < size; ++i) goes[i] = goesOn(l[i]) ? 1 : 0;
    std::uint32_t* const stays = batch.stays.data();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < size; ++i) {
      stays[kept] = static_cast<std::uint32_t>(i);
      kept += goes[i];
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
};

}  // namespace julia
