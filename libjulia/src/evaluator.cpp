// SPDX-License-Identifier: Apache-2.0
#include "julia/evaluator.h"

#include "ball_arithmetic.h"
#include "batch_view.h"
#include "careful.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
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
        mNearSquared(mEscapeSquared * (1 - 8 * std::numeric_limits<Real>::epsilon())),
        mLogEscape(static_cast<Real>(std::log(options.escapeRadius))),
        mLogTrap(static_cast<Real>(options.logTrap)),
        mLevel(mMap->surfaceLevel(mLogEscape)) {
    requireValid(options);
    if (!std::isfinite(embedding.slice) || std::abs(embedding.slice) > kMaxEscapeRadius)
      throw std::invalid_argument("slice is " + std::to_string(embedding.slice) + "; it must be between -1e9 and 1e9");
  }

  void evaluate(std::span<const Point> points, std::span<double> field, std::span<int> iterations) const override {
    evaluatePieces(points, field, iterations, {});
  }

  void orbitTraps(std::span<const Point> points, std::span<double> nearest) const override {
    std::vector<double> field(points.size());
    std::fill(nearest.begin(), nearest.end(), kFieldLimit);
    evaluatePieces(points, field, {}, nearest);
  }

  /// The loop of evaluate() on ranges. A ball splits where an iterate may but need not end: those of its points that
  /// end there forbid one answer, the others go on within what is left of the range.
  void decide(std::span<const Point> centres, double radius, std::span<Decision> out) const override {
    std::fill(out.begin(), out.end(), Decision::Undecided);
    if (!signsFollowEnds() || !(radius >= 0)) return;
    BallBatch batch;
    start(centres, radius, batch, out);
    for (int step = 1; !batch.balls.empty(); ++step) {
      batch.l.resize(batch.balls.size());
      mMap->logModulusRanges(batch.balls, batch.l);
      keep(batch, out, step == mOptions.maxIterations);
      if (batch.balls.empty()) break;
      batch.images.resize(batch.balls.size());
      mMap->images(batch.balls, batch.l, batch.images);
      std::size_t kept = 0;
      for (std::size_t i = 0; i < batch.images.size(); ++i) {
        if (!batch.images[i] || !std::isfinite(batch.images[i]->radius)) continue;
        batch.balls[kept] = *batch.images[i];
        batch.rest[kept++] = batch.rest[i];
      }
      batch.resize(kept);
    }
  }

  void versors(std::span<const Point> points, std::span<Quaternion<double>> versors) const override {
    QuaternionBatch<Real> u;
    mMap->versor(embed(points), u);
    for (std::size_t i = 0; i < points.size(); ++i) versors[i] = u.get(i).template as<double>();
  }

 private:
  static constexpr std::size_t kPiece = 2048;

  QuaternionBatch<Real> embed(std::span<const Point> points) const {
    QuaternionBatch<Real> q;
    q.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) q.set(i, mEmbedding.quaternion<Real>(points[i]));
    return q;
  }

  /// The orbits that go on: their iterates, l of these, and which point each belongs to.
  struct Batch {
    QuaternionBatch<Real> q, next;
    std::vector<Real> l;
    std::vector<std::uint32_t> index;
    std::vector<std::uint32_t> stays;  ///< places of those that go on, while ranks close

    void resize(std::size_t n) {
      q.resize(n);
      l.resize(n);
      index.resize(n);
      stays.resize(n);
    }
  };

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
      mMap->logModulus(batch.q, batch.l);
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
      if (batch.q.size() == 0) break;
      mMap->versor(batch.q, batch.next);
      std::swap(batch.q, batch.next);
      kernels::kernels<Real>().scaleByExponential(batch.l.data(), view(batch.q), batch.q.size());
    }
  }

  /// An iterate of 0 has l = -inf too; without a trap it goes on, for not every map keeps it there.
  bool isTrapped(Real l) const { return l <= mLogTrap && mLogTrap > -std::numeric_limits<Real>::infinity(); }

  /// The points themselves, less those that have escaped before the first step.
  void start(std::span<const Point> points, Batch& batch, std::span<double> field, std::span<int> iterations) const {
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
    std::array<std::uint8_t, kPiece> goes;
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
      for (std::vector<Real>* part : {&batch.q.a, &batch.q.b, &batch.q.c, &batch.q.d, &batch.l})
        closeRanks(part->data());
      closeRanks(index);
    }
    batch.resize(kept);
  }

  /// A ball's number and which answers its points that have ended leave open.
  struct Rest {
    std::uint32_t index = 0;
    bool inside = true, outside = true;
  };
  /// The balls that hold the iterates of those that go on.
  struct BallBatch {
    std::vector<Ball> balls;
    std::vector<LogRange> l;
    std::vector<std::optional<Ball>> images;
    std::vector<Rest> rest;

    void resize(std::size_t n) {
      balls.resize(n);
      l.resize(n);
      rest.resize(n);
    }
  };

  /// What escapes is outside and what is trapped inside for all maps of the library, but a map may set its level as it
  /// likes.
  bool signsFollowEnds() const { return mLevel <= mLogEscape && (mLogTrap < mLevel || !isTrapped(mLogTrap)); }

  static Decision decision(const Rest& rest, bool inside, bool outside) {
    if (inside && rest.inside) return Decision::Inside;
    return outside && rest.outside ? Decision::Outside : Decision::Undecided;
  }

  void start(std::span<const Point> centres, double radius, BallBatch& batch, std::span<Decision> out) const {
    batch.balls.reserve(centres.size());
    batch.rest.reserve(centres.size());
    Embedding rounded = mEmbedding;
    rounded.slice = static_cast<double>(static_cast<Real>(mEmbedding.slice));
    const double escape = std::sqrt(static_cast<double>(mEscapeSquared)), slack = 8 * kEpsilonOf<Real>;
    for (std::size_t i = 0; i < centres.size(); ++i) {
      const Ball ball = roundedTo<Real>({rounded.quaternion<double>(centres[i]), radius});
      const double size = norm(ball.centre);
      Rest rest{static_cast<std::uint32_t>(i)};
      if ((size - ball.radius) * (1 - slack) >= escape) {
        out[i] = Decision::Outside;
        continue;
      }
      if (!std::isfinite(size + ball.radius)) continue;
      rest.inside = (size + ball.radius) * (1 + slack) < escape;
      batch.balls.push_back(ball);
      batch.rest.push_back(rest);
    }
  }

  /// Answers for the balls of which nothing goes on, and cuts the ranges of the others.
  void keep(BallBatch& batch, std::span<Decision> out, bool last) const {
    const double escape = static_cast<double>(mLogEscape), level = static_cast<double>(mLevel);
    const double trap = static_cast<double>(mLogTrap);
    const bool traps = isTrapped(mLogTrap);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < batch.balls.size(); ++i) {
      LogRange l = batch.l[i];
      Rest rest = batch.rest[i];
      const bool inside = last ? l.high < level : traps && l.high <= trap;
      const bool outside = l.low >= (last ? level : escape);
      if (last || inside || outside) {
        out[rest.index] = decision(rest, inside, outside);
        continue;
      }
      if (l.high >= escape) {
        l.high = escape;
        rest.inside = false;
      }
      if (traps && l.low <= trap) {
        l.low = trap;
        rest.outside = false;
      }
      if (!rest.inside && !rest.outside) continue;
      batch.balls[kept] = batch.balls[i];
      batch.l[kept] = l;
      batch.rest[kept++] = rest;
    }
    batch.resize(kept);
  }

  std::shared_ptr<const Map<Real>> mMap;
  Embedding mEmbedding;
  OrbitOptions mOptions;
  Real mEscapeSquared;
  Real mNearSquared;  ///< below, in whichever order squares are added
  Real mLogEscape, mLogTrap, mLevel;
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
  void orbitTraps(std::span<const Point> points, std::span<double> nearest) const override {
    mFull->orbitTraps(points, nearest);
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
