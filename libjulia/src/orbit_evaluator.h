// SPDX-License-Identifier: Apache-2.0
/// @file orbit_evaluator.h
/// The orbit loop of all evaluators, which takes a batch of points through the steps of a map. Orbits that have ended
/// leave the batch, so that the kernels' lanes stay full. Derived classes define the step.
#pragma once

#include "julia/elementary.h"
#include "julia/evaluator.h"
#include "julia/orbit_trace.h"

#include "ball_arithmetic.h"
#include "batch_view.h"
#include "careful.h"
#include "number_text.h"
#include "object_pool.h"
#include "orbit_limits.h"

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
class OrbitEvaluator : public FieldEvaluator, public OrbitTracer {
 public:
  void evaluate(std::span<const Point> points, std::span<double> field, std::span<int> iterations) const final {
    evaluatePieces(points, field, iterations, {});
  }

  void orbitTraps(std::span<const Point> points, std::span<double> nearest) const final {
    std::vector<double> field(points.size());
    std::fill(nearest.begin(), nearest.end(), kFieldLimit);
    evaluatePieces(points, field, {}, nearest);
  }

  void trace(std::span<const Point> points, const OrbitTrace& trace) const final {
    const auto batch = mBatches.borrow();
    const auto row = static_cast<std::size_t>(mOptions.maxIterations) + 1;
    for (std::size_t first = 0; first < points.size(); first += kPiece) {
      const std::size_t size = std::min(kPiece, points.size() - first);
      tracePiece(points.subspan(first, size), *batch,
                 {trace.iterates.subspan(first * row, size * row), trace.logModuli.subspan(first * row, size * row),
                  trace.steps.subspan(first, size), trace.ends.subspan(first, size)});
    }
  }

  void evaluateBlocks(std::span<const NodeBlock> blocks) const final {
    constexpr std::size_t kTogether = kPiece / NodeBlock::kSize;
    const auto batch = mBatches.borrow();
    for (std::size_t first = 0; first < blocks.size(); first += kTogether)
      evaluateBlockPiece(blocks.subspan(first, std::min(kTogether, blocks.size() - first)), *batch);
  }

  /// The working memory for this number of points fits in the second-level cache.
  std::size_t preferredBatch() const final { return kPiece; }

  FieldDescription describe() const final {
    return {describeMap(), mEmbedding, mOptions, static_cast<double>(mLevel), std::is_same_v<Real, float>};
  }

 protected:
  /// The continuing orbits: their iterates, the logarithms of the moduli, and the points to which they belong.
  struct Batch {
    QuaternionBatch<Real> q, next;
    QuaternionBatch<Real> carried;  ///< what the map carries for each orbit; empty if it carries nothing
    std::vector<Real> l;
    std::vector<std::uint32_t> index;

    void resize(std::size_t n) {
      q.resize(n);
      if (carried.size() != 0) carried.resize(n);
      l.resize(n);
      index.resize(n);
    }
  };

  OrbitEvaluator(const Embedding& embedding, const OrbitOptions& options, Real level)
      : OrbitEvaluator(embedding, options, level, OrbitLimits<Real>(options)) {}
  OrbitEvaluator(const Embedding& embedding, const OrbitOptions& options, Real level, const OrbitLimits<Real>& limits)
      : mEmbedding(embedding),
        mOptions(options),
        mEscapeSquared(limits.escapeSquared),
        mNearSquared(limits.nearSquared),
        mLogEscape(limits.logEscape),
        mLogTrap(limits.logTrap),
        mLevel(level) {
    requireValid(options);
    if (!std::isfinite(embedding.slice) || std::abs(embedding.slice) > kMaxEscapeRadius)
      throw std::invalid_argument("slice is " + textOf(embedding.slice) + "; it must be between -1e9 and 1e9");
  }

  static Real logEscapeOf(const OrbitOptions& options) { return OrbitLimits<Real>(options).logEscape; }

  /// Sets batch.l to l of the iterates that follow batch.q, after @a step steps.
  virtual void takeStep(Batch& batch, int step) const = 0;
  /// Sets batch.q to those iterates, for the continuing orbits.
  virtual void formIterates(Batch& batch) const = 0;
  virtual MapDescription describeMap() const = 0;
  /// After the first step: sets batch.l to +inf or -inf for nodes that are proved to be outside or inside, so that
  /// their orbits end. @pre batch.index holds the numbers of the nodes, counted through the blocks
  virtual void markDecided(std::span<const NodeBlock> /*blocks*/, Batch& /*batch*/) const {}

  QuaternionBatch<Real> embed(std::span<const Point> points) const {
    QuaternionBatch<Real> q;
    q.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) q.set(i, mEmbedding.quaternion<Real>(points[i]));
    return q;
  }

  /// The relative error of the norms that evaluate() compares.
  static constexpr double kNormSlack = 8 * kEpsilonOf<Real>;

  /// A ball that contains the results of embed() for the points within @a radius of @a x.
  Ball embeddedBall(const Point& x, double radius) const {
    Embedding rounded = mEmbedding;
    rounded.slice = static_cast<double>(static_cast<Real>(mEmbedding.slice));
    return roundedTo<Real>({rounded.quaternion<double>(x), radius});
  }
  /// Whether the whole ball has escaped before the first step.
  bool hasEscaped(const Ball& start) const {
    return (norm(start.centre) - start.radius) * (1 - kNormSlack) >= std::sqrt(static_cast<double>(mEscapeSquared));
  }

  /// Without a trap, an iterate of 0, whose l is -inf too, continues: not every map keeps it there.
  bool isTrapped(Real l) const { return l <= mLogTrap && mLogTrap > -std::numeric_limits<Real>::infinity(); }

  Embedding mEmbedding;
  OrbitOptions mOptions;
  Real mEscapeSquared;
  Real mNearSquared;
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
      finishStep(batch, step == mOptions.maxIterations, isTrapped(mLogTrap), field, iterations, step);
      if (batch.q.size() != 0) formIterates(batch);
    }
  }

  /// The loop of evaluatePiece(). Iterates are formed before the orbits that end leave the batch.
  void tracePiece(std::span<const Point> points, Batch& batch, const OrbitTrace& trace) const {
    const auto row = static_cast<std::size_t>(mOptions.maxIterations) + 1;
    const auto write = [&](std::size_t point, int step, const Quaternion<double>& q, double l) {
      constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
      const bool finite = std::isfinite(q.a) && std::isfinite(q.b) && std::isfinite(q.c) && std::isfinite(q.d);
      const std::size_t entry = point * row + static_cast<std::size_t>(step);
      trace.iterates[entry] = finite ? q : Quaternion<double>{kNaN, kNaN, kNaN, kNaN};
      trace.logModuli[entry] = std::clamp(l, -kFieldLimit, kFieldLimit);
      trace.ends[point] = l >= static_cast<double>(mLogEscape)          ? OrbitEnd::Escaped
                          : step > 0 && isTrapped(static_cast<Real>(l)) ? OrbitEnd::Trapped
                                                                        : OrbitEnd::Steps;
    };
    std::vector<double> field(points.size());
    start(points, batch, field, trace.steps);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Quaternion<Real> q = mEmbedding.quaternion<Real>(points[i]);
      const Real l = careful::logNorm(q);
      // As start() decides it: by the square, and not by its logarithm.
      const bool escaped = !(normSquared(q) < mEscapeSquared);
      const double below = std::nextafter(static_cast<double>(mLogEscape), -kFieldLimit);
      write(i, 0, q.template as<double>(),
            escaped ? static_cast<double>(std::max(l, mLogEscape)) : std::min(static_cast<double>(l), below));
    }
    for (int step = 1; batch.q.size() != 0; ++step) {
      takeStep(batch, step);
      formIterates(batch);
      for (std::size_t i = 0; i < batch.l.size(); ++i)
        write(batch.index[i], step, batch.q.get(i).template as<double>(), static_cast<double>(batch.l[i]));
      finishStep(batch, step == mOptions.maxIterations, isTrapped(mLogTrap), field, trace.steps, step);
    }
  }

  void evaluateBlockPiece(std::span<const NodeBlock> blocks, Batch& batch) const {
    batch.carried.resize(0);
    batch.resize(blocks.size() * NodeBlock::kSize);
    if (!placeNodes(blocks, batch)) return FieldEvaluator::evaluateBlocks(blocks);
    alignas(64) std::array<float, kPiece> field;
    const auto fieldOf = [level = mLevel](Real l) {
      constexpr Real kLimit = static_cast<Real>(kFieldLimit);
      const Real value = l - level, above = value > -kLimit ? value : -kLimit;
      const Real within = above < kLimit ? above : kLimit;
      if constexpr (std::is_same_v<Real, float>)
        return within;
      else
        return storedField(within);
    };
    for (int step = 1; batch.q.size() != 0; ++step) {
      takeStep(batch, step);
      if (step == 1) markDecided(blocks, batch);
      const std::size_t size = batch.l.size();
      if (size == blocks.size() * NodeBlock::kSize)
        for (std::size_t i = 0; i < size; ++i) field[i] = fieldOf(batch.l[i]);
      else
        for (std::size_t i = 0; i < size; ++i) field[batch.index[i]] = fieldOf(batch.l[i]);
      compact(batch, step == mOptions.maxIterations, isTrapped(mLogTrap));
      if (batch.q.size() != 0) formIterates(batch);
    }
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const float* const from = field.data() + i * NodeBlock::kSize;
      float* const to = blocks[i].field.data();
      forEachRun(blocks[i], [&](std::size_t node, std::size_t length) { std::copy_n(from + node, length, to + node); });
    }
  }

  /// Calls body(number of the first node, length) for the runs of wanted nodes along z.
  template <class Body>
  static void forEachRun(const NodeBlock& block, const Body& body) {
    constexpr std::size_t kSide = NodeBlock::kSide, kHalf = kSide / 2;
    if (block.wanted == 0xff) {
      for (std::size_t node = 0; node < NodeBlock::kSize; node += kSide) body(node, kSide);
      return;
    }
    for (std::size_t node = 0; node < NodeBlock::kSize; node += kHalf)
      if (block.wanted >> (node >> 8 << 2 | (node >> 5 & 1) << 1 | (node >> 2 & 1)) & 1) body(node, kHalf);
  }

  /// Fills the batch with the wanted nodes. @return whether none of them can have escaped already
  bool placeNodes(std::span<const NodeBlock> blocks, Batch& batch) const {
    constexpr std::size_t kSide = NodeBlock::kSide;
    QuaternionBatch<Real>& q = batch.q;
    const Quaternion<Real*> components{q.a.data(), q.b.data(), q.c.data(), q.d.data()};
    const std::array<Real*, 3> to = mEmbedding.point(components);
    const Real slice = static_cast<Real>(mEmbedding.slice);
    std::uint32_t* const index = batch.index.data();
    std::size_t count = 0;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      Real at[3][kSide];
      Real most = slice * slice;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        Real square = 0;
        for (std::size_t k = 0; k < kSide; ++k) {
          at[axis][k] = static_cast<Real>(blocks[i].at[axis][k]);
          square = std::max(square, at[axis][k] * at[axis][k]);
        }
        most += square;
      }
      if (!(most < mNearSquared)) return false;
      const auto block = static_cast<std::uint32_t>(i * NodeBlock::kSize);
      forEachRun(blocks[i], [&](std::size_t node, std::size_t length) {
        const Real x = at[0][node / kSide / kSide], y = at[1][node / kSide % kSide];
        const Real* const z = at[2] + node % kSide;
        const std::uint32_t number = block + static_cast<std::uint32_t>(node);
        for (std::size_t k = 0; k < length; ++k) {
          to[0][count + k] = x;
          to[1][count + k] = y;
          to[2][count + k] = z[k];
          index[count + k] = number + static_cast<std::uint32_t>(k);
        }
        count += length;
      });
    }
    batch.resize(count);
    Real* const toSlice = mEmbedding.slicePart(components);
    std::fill_n(toSlice, count, slice);
    return true;
  }

  /// Fills the batch with the points that have not escaped before the first step.
  void start(std::span<const Point> points, Batch& batch, std::span<double> field, std::span<int> iterations) const {
    batch.carried.resize(0);
    batch.resize(points.size());
    if (!embed(points, batch)) return;
    for (std::size_t i = 0; i < points.size(); ++i)
      // At least the escape value, so that a rounding error cannot revive an escaped point.
      batch.l[i] = normSquared(batch.q.get(i)) < mEscapeSquared
                       ? -std::numeric_limits<Real>::infinity()
                       : std::max(careful::logNorm(batch.q.get(i)), mLogEscape);
    finishStep(batch, false, false, field, iterations, 0);
  }

  /// @return false if no point has escaped yet
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

  /// Writes the field of the orbits that end at this step and compacts the others. It does not branch on their state,
  /// which is unpredictable: the field of continuing orbits is overwritten later.
  /// @param last  no orbit continues  @param traps  orbits in the trap end
  void finishStep(Batch& batch, bool last, bool traps, std::span<double> field, std::span<int> iterations,
                  int step) const {
    const std::size_t size = batch.q.size();
    const Real* const l = batch.l.data();
    const std::uint32_t* const index = batch.index.data();
    const auto fieldOf = [level = mLevel](Real at) { return fieldOfEnd(at, level); };
    if (size == field.size())
      for (std::size_t i = 0; i < size; ++i) field[i] = fieldOf(l[i]);
    else
      for (std::size_t i = 0; i < size; ++i) field[index[i]] = fieldOf(l[i]);
    if (!iterations.empty())
      for (std::size_t i = 0; i < size; ++i) iterations[index[i]] = step;
    compact(batch, last, traps);
  }

  /// Removes the orbits that have ended from the batch.
  void compact(Batch& batch, bool last, bool traps) const {
    if (last) return batch.resize(0);
    std::array<Real*, 8> rows;
    std::size_t count = 0;
    for (QuaternionBatch<Real>* quaternions : {&batch.q, &batch.carried})
      for (std::vector<Real>* part : {&quaternions->a, &quaternions->b, &quaternions->c, &quaternions->d})
        if (!part->empty()) rows[count++] = part->data();
    batch.resize(kernels::kernels<Real>().compact(mLogEscape, traps, mLogTrap, batch.l.data(), batch.index.data(),
                                                  rows.data(), count, batch.q.size()));
  }

  mutable ObjectPool<Batch> mBatches{[] { return std::make_unique<Batch>(); }};
};

}  // namespace julia
