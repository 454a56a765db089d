// SPDX-License-Identifier: Apache-2.0
#include "julia/evaluator.h"

#include "ball_arithmetic.h"
#include "batch_view.h"
#include "node_cubes.h"
#include "orbit_evaluator.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <vector>

namespace julia {

void FieldEvaluator::evaluateBlocks(std::span<const NodeBlock> blocks) const {
  constexpr std::size_t kSide = NodeBlock::kSide, kHalf = kSide / 2;
  std::vector<Point> points;
  std::vector<float*> to;
  for (const NodeBlock& block : blocks)
    for (std::size_t node = 0; node < NodeBlock::kSize; ++node) {
      const std::size_t x = node / kSide / kSide, y = node / kSide % kSide, z = node % kSide;
      if (!(block.wanted >> (x / kHalf * 4 + y / kHalf * 2 + z / kHalf) & 1)) continue;
      points.push_back({block.at[0][x], block.at[1][y], block.at[2][z]});
      to.push_back(&block.field[node]);
    }
  std::vector<double> field(points.size());
  evaluate(points, field, {});
  for (std::size_t i = 0; i < to.size(); ++i) *to[i] = storedField(field[i]);
}

void FieldEvaluator::evaluateSigns(const SearchLattice& lattice, std::span<SignBlock> blocks) const {
  constexpr std::size_t kSide = NodeBlock::kSide, kTogether = 64;
  std::vector<float> field(kTogether * NodeBlock::kSize);
  std::vector<NodeBlock> nodes;
  for (std::size_t first = 0; first < blocks.size(); first += kTogether) {
    const auto some = blocks.subspan(first, std::min(kTogether, blocks.size() - first));
    std::fill(field.begin(), field.end(), 1.0f);
    nodes.clear();
    for (std::size_t i = 0; i < some.size(); ++i) {
      float* const values = field.data() + i * NodeBlock::kSize;
      NodeBlock& block = nodes.emplace_back(
          NodeBlock{.wanted = some[i].wanted, .field = std::span<float, NodeBlock::kSize>(values, NodeBlock::kSize)});
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t k = 0; k < kSide; ++k)
          block.at[axis][k] =
              lattice.at(static_cast<double>(some[i].origin[axis]) + static_cast<double>(k), static_cast<int>(axis));
    }
    evaluateBlocks(nodes);
    for (std::size_t i = 0; i < some.size(); ++i)
      for (std::size_t x = 0; x < kSide; ++x) {
        std::uint64_t inside = 0;
        for (std::size_t k = 0; k < kSide * kSide; ++k)
          inside |= static_cast<std::uint64_t>(nodes[i].field[x * kSide * kSide + k] < 0) << k;
        some[i].inside[x] = inside;
      }
  }
}

void FieldEvaluator::followRays(const RayMarch&, std::span<const MarchedRay> rays, std::span<RayMeeting> met) const {
  for (std::size_t i = 0; i < rays.size(); ++i) met[i] = {.outside = rays[i].before, .inside = rays[i].t};
}

void FieldEvaluator::evaluateAround(std::span<const Point> centres, std::span<const double> distances,
                                    std::span<const Point> directions, std::span<double> field,
                                    std::span<int> iterations) const {
  std::vector<Point> points;
  points.reserve(centres.size() * directions.size());
  for (std::size_t i = 0; i < centres.size(); ++i)
    for (const Point& direction : directions) points.push_back(pointAlong(centres[i], distances[i], direction));
  evaluate(points, field, iterations);
}

namespace {

/// Evaluates maps in log-polar form.
template <class Real>
class LogPolarEvaluator final : public OrbitEvaluator<Real> {
  using Base = OrbitEvaluator<Real>;
  using typename Base::Batch;

 public:
  LogPolarEvaluator(std::shared_ptr<const Map<Real>> map, const Embedding& embedding, const OrbitOptions& options)
      : Base(embedding, options, map->surfaceLevel(Base::logEscapeOf(options))), mMap(std::move(map)) {}

  /// The loop of evaluate() on ranges. A ball splits where an orbit may end but need not: the points whose orbits end
  /// there rule out one answer, and the others continue within the rest of the range.
  void decide(std::span<const Point> centres, double radius, std::span<Decision> out) const override {
    std::fill(out.begin(), out.end(), Decision::Undecided);
    if (!signsFollowEnds() || !(radius >= 0)) return;
    BallBatch batch;
    start(centres, radius, batch, out);
    for (int step = 1; !batch.balls.empty(); ++step) {
      batch.l.resize(batch.balls.size());
      mMap->logModulusRanges(batch.balls, batch.l);
      finishStep(batch, out, step == mOptions.maxIterations);
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
    mMap->versor(this->embed(points), u);
    for (std::size_t i = 0; i < points.size(); ++i) versors[i] = u.get(i).template as<double>();
  }

 private:
  using Base::isTrapped;
  using Base::mEscapeSquared;
  using Base::mLevel;
  using Base::mLogEscape;
  using Base::mLogTrap;
  using Base::mOptions;

  MapDescription describeMap() const override { return mMap->describe(); }

  void takeStep(Batch& batch, int) const override { mMap->logModulus(batch.q, batch.l); }

  void formIterates(Batch& batch) const override {
    mMap->versor(batch.q, batch.next);
    std::swap(batch.q, batch.next);
    kernels::kernels<Real>().scaleByExponential(batch.l.data(), view(batch.q), batch.q.size());
  }

  void markDecided(std::span<const NodeBlock> blocks, Batch& batch) const override {
    const Proofs& proofs = this->proofs();
    const bool escapes = proofs.escape.least < mLogEscape;
    if (!escapes && !(proofs.usefulRadius > 0)) return;
    // The lattice is the same for all blocks, up to rounding.
    double diagonal = 0;
    for (const auto& at : blocks[0].at) {
      const double length = at.back() - at.front();
      diagonal += length * length;
    }
    const double half = 0.5 * std::sqrt(diagonal) * (1 + 1e-3) / (NodeBlock::kSide - 1);
    const bool isEscapeUseful = escapes && half <= proofs.escape.radius;
    const bool isImageUseful = static_cast<double>(kImagedSide - 1) * half <= proofs.usefulRadius;
    if (!isEscapeUseful && !isImageUseful) return;
    // Treats all nodes as wanted.
    const std::size_t size = blocks.size() * NodeBlock::kSize;
    Real* values = batch.l.data();
    std::vector<Real> all;
    if (batch.l.size() != size) {
      all.assign(size, std::numeric_limits<Real>::infinity());
      for (std::size_t i = 0; i < batch.l.size(); ++i) all[batch.index[i]] = batch.l[i];
      values = all.data();
    }
    if (isEscapeUseful) markEscaping(blocks, half, values, batch.next);
    if (isImageUseful) markByImages(blocks, half, values);
    if (!all.empty())
      for (std::size_t i = 0; i < batch.l.size(); ++i) batch.l[i] = all[batch.index[i]];
  }

  /// Nodes are decided in cubes: first the largest cubes for which something is known, then the smaller ones where
  /// these left nodes undecided. @param half  half the diagonal of a cell  @param centres  working memory
  void markEscaping(std::span<const NodeBlock> blocks, double half, Real* values,
                    QuaternionBatch<Real>& centres) const {
    const EscapeProof& proof = mProofs.escape;
    Pairs pairs;
    pairs.most.resize(blocks.size() * NodePairs::kCount);
    pairs.bounds.assign(pairs.most.size(), std::numeric_limits<Real>::infinity());
    for (std::size_t i = 0; i < blocks.size(); ++i)
      NodePairs::findMost(values + i * NodeBlock::kSize, mLogEscape, pairs.most.data() + i * NodePairs::kCount);
    for (std::size_t side = NodeBlock::kSide; side > 1; side /= 2)
      if (static_cast<double>(side - 1) * half <= proof.radius)
        boundCubes(blocks, side, static_cast<double>(side - 1) * half, pairs, centres);
    for (std::size_t i = 0; i < blocks.size(); ++i)
      NodePairs::raise(values + i * NodeBlock::kSize, pairs.bounds.data() + i * NodePairs::kCount);
  }

  /// The side of the smallest cubes whose images are formed: for cubes of two nodes this costs more than it saves.
  static constexpr std::size_t kImagedSide = 4;
  using ImagedCubes = NodeCubes<Real, kImagedSide>;

  /// A cube of nodes that the first step leaves undecided.
  struct Cube {
    std::size_t first = 0, across = 1;  ///< its first imaged cube, and how many of these there are along a side
    LogRange l;                         ///< of its undecided nodes
  };

  /// Decides cubes of nodes by the second step of all of their undecided nodes at once: whole blocks first, and then
  /// their eighths. Values of decided nodes become infinite. @param half  as for markEscaping()
  void markByImages(std::span<const NodeBlock> blocks, double half, Real* values) const {
    constexpr Real kInfinity = std::numeric_limits<Real>::infinity();
    constexpr std::size_t kCount = ImagedCubes::kCount, kAcross = ImagedCubes::kAcross;
    const Real trap = isTrapped(mLogTrap) ? mLogTrap : -kInfinity;
    std::vector<Real> least(blocks.size() * kCount), most(least.size()), decided(least.size(), 0);
    for (std::size_t i = 0; i < blocks.size(); ++i)
      ImagedCubes::findExtremes(values + i * NodeBlock::kSize, trap, mLogEscape, least.data() + i * kCount,
                                most.data() + i * kCount);
    std::vector<Cube> cubes;
    std::vector<Ball> balls;
    const auto add = [&](std::size_t first, std::size_t across) {
      const NodeBlock& block = blocks[first / kCount];
      const std::size_t cube = first % kCount, last = across * kImagedSide - 1;
      Cube added{first, across, {static_cast<double>(kInfinity), -static_cast<double>(kInfinity)}};
      forEachCube(added, [&](std::size_t k) {
        added.l.low = std::min(added.l.low, static_cast<double>(least[k]));
        added.l.high = std::max(added.l.high, static_cast<double>(most[k]));
      });
      if (!(added.l.low <= added.l.high)) return;
      const auto middle = [&](std::size_t axis, std::size_t at) {
        return 0.5 * (block.at[axis][at * kImagedSide] + block.at[axis][at * kImagedSide + last]);
      };
      const Point centre{middle(0, cube / kAcross / kAcross), middle(1, cube / kAcross % kAcross),
                         middle(2, cube % kAcross)};
      cubes.push_back(added);
      balls.push_back(this->embeddedBall(centre, static_cast<double>(last) * half));
    };
    for (std::size_t first = 0; first < least.size(); first += kCount) add(first, kAcross);
    decideCubes(cubes, balls, decided);
    cubes.clear();
    balls.clear();
    for (std::size_t first = 0; first < least.size(); ++first)
      if (decided[first] == 0) add(first, 1);
    decideCubes(cubes, balls, decided);
    for (std::size_t i = 0; i < blocks.size(); ++i)
      ImagedCubes::replace(values + i * NodeBlock::kSize, trap, mLogEscape, decided.data() + i * kCount);
  }

  /// Calls body(number) for each imaged cube in a cube.
  template <class Body>
  static void forEachCube(const Cube& cube, const Body& body) {
    constexpr std::size_t kAcross = ImagedCubes::kAcross;
    for (std::size_t x = 0; x < cube.across; ++x)
      for (std::size_t y = 0; y < cube.across; ++y)
        for (std::size_t z = 0; z < cube.across; ++z) body(cube.first + (x * kAcross + y) * kAcross + z);
  }

  /// Sets decided[k] to +inf or -inf for the imaged cubes in cubes whose next l escapes or is trapped everywhere.
  void decideCubes(const std::vector<Cube>& cubes, const std::vector<Ball>& balls, std::vector<Real>& decided) const {
    constexpr Real kInfinity = std::numeric_limits<Real>::infinity();
    const double escape = static_cast<double>(mLogEscape), trap = static_cast<double>(mLogTrap);
    std::vector<LogRange> l;
    for (const Cube& cube : cubes) l.push_back(cube.l);
    std::vector<std::optional<Ball>> images(balls.size());
    mMap->images(balls, l, images);
    std::vector<Ball> known;
    std::vector<std::size_t> numbers;
    for (std::size_t i = 0; i < images.size(); ++i)
      if (images[i] && std::isfinite(images[i]->radius)) {
        known.push_back(*images[i]);
        numbers.push_back(i);
      }
    l.resize(known.size());
    mMap->logModulusRanges(known, l);
    for (std::size_t i = 0; i < known.size(); ++i) {
      const bool outside = l[i].low >= escape, inside = isTrapped(mLogTrap) && l[i].high <= trap;
      if (outside || inside)
        forEachCube(cubes[numbers[i]], [&](std::size_t k) { decided[k] = outside ? kInfinity : -kInfinity; });
    }
  }

  /// Data of the cubes of two nodes a side, for all blocks.
  struct Pairs {
    std::vector<Real> most;    ///< the largest l that has not escaped
    std::vector<Real> bounds;  ///< the smallest l that is decided, as far as known
  };

  /// Lowers the bounds by what is known about cubes of @a side nodes. @param centres  working memory
  void boundCubes(std::span<const NodeBlock> blocks, std::size_t side, double radius, Pairs& pairs,
                  QuaternionBatch<Real>& centres) const {
    // A bound is seldom closer to the smallest possible one.
    const Real least = mProofs.escape.least + Real(0.15);
    const std::size_t across = NodeBlock::kSide / side, inside = side / 2;
    const auto forEachPair = [&](std::size_t first, const auto& body) {
      for (std::size_t x = 0; x < inside; ++x)
        for (std::size_t y = 0; y < inside; ++y)
          for (std::size_t z = 0; z < inside; ++z) body(first + (x * NodePairs::kAcross + y) * NodePairs::kAcross + z);
    };
    std::vector<std::size_t> asked;
    asked.reserve(pairs.most.size());
    centres.resize(pairs.most.size());
    for (std::size_t i = 0; i < blocks.size(); ++i)
      for (std::size_t x = 0; x < across; ++x)
        for (std::size_t y = 0; y < across; ++y)
          for (std::size_t z = 0; z < across; ++z) {
            const std::size_t first =
                i * NodePairs::kCount + ((x * NodePairs::kAcross + y) * NodePairs::kAcross + z) * inside;
            bool asks = false;
            forEachPair(first, [&](std::size_t k) {
              // Avoids a branch.
              const unsigned isEnough = pairs.most[k] >= least, isBelow = pairs.most[k] < pairs.bounds[k];
              asks |= (isEnough & isBelow) != 0;
            });
            if (!asks) continue;
            const auto middle = [&](std::size_t axis, std::size_t cube) {
              const auto& at = blocks[i].at[axis];
              return 0.5 * (at[cube * side] + at[cube * side + side - 1]);
            };
            const Point centre{middle(0, x), middle(1, y), middle(2, z)};
            centres.set(asked.size(), this->mEmbedding.template quaternion<Real>(centre));
            asked.push_back(first);
          }
    if (asked.empty()) return;
    centres.resize(asked.size());
    // The centres and the nodes, none of which has escaped, are rounded.
    const double rounded = radius * (1 + kSlack) + 4 * kEpsilonOf<Real> * (mOptions.escapeRadius + radius);
    std::vector<Real> found(asked.size());
    mMap->escapeBounds(centres, static_cast<Real>(rounded * (1 + kEpsilonOf<Real>)), mProofs.escape, found);
    for (std::size_t i = 0; i < asked.size(); ++i)
      forEachPair(asked[i], [&](std::size_t k) { pairs.bounds[k] = std::min(pairs.bounds[k], found[i]); });
  }

  using EscapeProof = typename Map<Real>::EscapeProof;
  using NodePairs = NodeCubes<Real, 2>;
  /// What can be proved about the second step after the first.
  struct Proofs {
    EscapeProof escape;
    double usefulRadius = 0;  ///< of balls whose images are worth forming
  };
  const Proofs& proofs() const {
    std::call_once(mProofsMade, [this] {
      if (!signsFollowEnds() || mOptions.maxIterations < 2) return;
      mProofs.escape = mMap->escapeProof(static_cast<double>(mOptions.maxIterations == 2 ? mLevel : mLogEscape));
      if (mOptions.maxIterations > 2) mProofs.usefulRadius = mMap->usefulRadius();
    });
    return mProofs;
  }

  /// The number of a ball, and the answers that its ended orbits still allow.
  struct Rest {
    std::uint32_t index = 0;
    bool inside = true, outside = true;
  };
  /// The balls that contain the iterates of the continuing orbits.
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

  /// Whether escaping orbits are outside and trapped ones inside. This holds for all maps of the library, but a map may
  /// choose any level.
  bool signsFollowEnds() const { return mLevel <= mLogEscape && (mLogTrap < mLevel || !isTrapped(mLogTrap)); }

  static Decision decision(const Rest& rest, bool inside, bool outside) {
    if (inside && rest.inside) return Decision::Inside;
    return outside && rest.outside ? Decision::Outside : Decision::Undecided;
  }

  void start(std::span<const Point> centres, double radius, BallBatch& batch, std::span<Decision> out) const {
    batch.balls.reserve(centres.size());
    batch.rest.reserve(centres.size());
    const double escape = std::sqrt(static_cast<double>(mEscapeSquared));
    for (std::size_t i = 0; i < centres.size(); ++i) {
      const Ball ball = this->embeddedBall(centres[i], radius);
      Rest rest{static_cast<std::uint32_t>(i)};
      if (this->hasEscaped(ball)) {
        out[i] = Decision::Outside;
        continue;
      }
      const double most = norm(ball.centre) + ball.radius;
      if (!std::isfinite(most)) continue;
      rest.inside = most * (1 + Base::kNormSlack) < escape;
      batch.balls.push_back(ball);
      batch.rest.push_back(rest);
    }
  }

  /// Answers for the balls without continuing orbits, and restricts the ranges of the others.
  void finishStep(BallBatch& batch, std::span<Decision> out, bool last) const {
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
  mutable std::once_flag mProofsMade;
  mutable Proofs mProofs;
};

/// Evaluates with a trap and without it, and uses the result without it where their signs differ.
class ConfirmingEvaluator final : public FieldEvaluator, public OrbitTracer {
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
  std::size_t preferredBatch() const override { return mTrapped->preferredBatch(); }
  FieldDescription describe() const override { return mTrapped->describe(); }
  void versors(std::span<const Point> points, std::span<Quaternion<double>> versors) const override {
    mFull->versors(points, versors);
  }
  void orbitTraps(std::span<const Point> points, std::span<double> nearest) const override {
    mTrapped->orbitTraps(points, nearest);
  }
  void trace(std::span<const Point> points, const OrbitTrace& trace) const override {
    traceOrbits(*mFull, points, trace);
  }

 private:
  std::unique_ptr<FieldEvaluator> mTrapped, mFull;
};

}  // namespace

template <class Real>
std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const Map<Real>> map, const Embedding& embedding,
                                                   const OrbitOptions& options) {
  auto evaluator = std::make_unique<LogPolarEvaluator<Real>>(map, embedding, options);
  if (!options.confirmTrap) return evaluator;
  OrbitOptions full = options;
  full.logTrap = -std::numeric_limits<double>::infinity();
  return std::make_unique<ConfirmingEvaluator>(
      std::move(evaluator), std::make_unique<LogPolarEvaluator<Real>>(std::move(map), embedding, full));
}

template std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const Map<float>>, const Embedding&,
                                                            const OrbitOptions&);
template std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const Map<double>>, const Embedding&,
                                                            const OrbitOptions&);

}  // namespace julia
